"""``rogue solve``: files in two languages, what it prints, and bad input."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from rogue.cli import app
from tca_bus.cli import run_app

DOMAINS = Path(__file__).parent / "prodigy" / "domains"

EVEN = """
(ptype-of box :top-type)
(ptype-of weight :top-type)
(OPERATOR weigh
  (params <b> <w>)
  (preconds ((<b> box) (<w> (and weight (is-even <w>)))) (unweighed <b>))
  (effects () ((del (unweighed <b>)) (add (weighed <b>)))))
(CONTROL-RULE heavy-ones (if (and (current-operator weigh) (candidate-bindings ((<w> . <n>)))
  (too-light <n>))) (then reject bindings ((<w> . <n>))))
"""
BOXES = """(create-problem
  (objects (a box) (w1 w2 w3 w4 weight)) (state (unweighed a)) (goal (weighed a)))"""
CODE = """
from operator import mul

def is_even(name):
    return int(name[1:]) % 2 == 0

def too_light(search, name):
    return int(name[1:]) < 3

def _hidden():
    raise RuntimeError

TABLE = {"is-even": is_even}
RULES = {"too-light": too_light}
"""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]):
    def run_command(*words: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            run_app(app, ["solve", *map(str, words)])
        printed = capsys.readouterr()
        return int(str(ended.value.code)), printed.out, printed.err

    return run_command


@pytest.fixture
def files(tmp_path: Path):
    def write(**texts: str) -> list[Path]:
        paths = []
        for name, text in texts.items():
            paths.append(tmp_path / name.replace("_", "."))
            paths[-1].write_text(text)
        return paths

    return write


def pair(problem: str) -> tuple[Path, Path]:
    return DOMAINS / f"{problem.partition('-')[0]}.pdl", DOMAINS / f"{problem}.pdl"


def test_json_has_the_plan_and_what_it_took(run) -> None:
    code, out, err = run(*pair("rockets-two"), "--json", "--check")
    document = json.loads(out)
    assert (code, err) == (0, "")
    assert {"status", "plan", "nodes", "seconds", "trace"} <= set(document)
    assert document["status"] == "solved"
    assert document["plan"][2] == "fly apollo here there"
    assert (document["cost"], document["valid"]) == (5, True)
    assert document["trace"][0] == "  2 n2 (done)"


def test_people_read_the_trace_a_summary_and_the_check(run) -> None:
    code, out, _ = run(*pair("rockets-two"), "--check", "--mode", "savta")
    lines = out.splitlines()
    assert code == 0
    assert lines[0] == "  2 n2 (done)"
    assert "\t<FLY APOLLO HERE THERE>" in lines
    assert lines[-2].startswith("solved: 5 steps; ")
    assert lines[-1] == "checked: the plan is valid"


def test_level_0_is_silent_and_level_1_has_no_nodes(run) -> None:
    assert run(*pair("rockets-two"), "--level", 0) == (0, "", "")
    _, out, _ = run(*pair("rockets-two"), "--level", 1)
    assert "n2 (done)" not in out
    assert "Achieved top-level goals." in out


def test_no_plan_and_a_limit_are_told_apart(run) -> None:
    code, out, _ = run(*pair("rockets-back"), "--level", 1)
    assert code == 1
    assert out.splitlines()[0].startswith("proved unsolvable: none of the ")
    assert out.splitlines()[1].startswith("unsolvable: ")
    code, out, _ = run(*pair("blocks-sussman"), "--level", 1, "--nodes", 12)
    assert code == 1
    assert out.splitlines()[0] == "gave up after 12 nodes; there is a plan"
    assert out.splitlines()[1].startswith("limit: 12 nodes")


@pytest.mark.parametrize("place", ["{}", "{}:TABLE"])
def test_functions_come_from_a_users_file(run, files, place: str) -> None:
    domain, problem, code = files(d_pdl=EVEN, p_pdl=BOXES, f_py=CODE)
    functions = place.format(code)
    rules = f"{code}:RULES"
    ended, out, err = run(
        domain, problem, "--functions", functions, "--meta-predicates", rules, "--level", 3
    )
    assert (ended, err) == (0, "")
    assert "\t<WEIGH A W4>" in out


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("", "found is-even, expected a registered function"),
        ("nowhere.py", "functions nowhere.py: there is no such file"),
        ("no_such_module", "loading it raised ModuleNotFoundError"),
        ("json:nothing", "nothing is neither a function nor a table of functions"),
        ("{bad}", "loading it raised ZeroDivisionError"),
    ],
)
def test_functions_that_are_not_there_are_named(run, files, place: str, message: str) -> None:
    domain, problem, bad = files(d_pdl=EVEN, p_pdl=BOXES, bad_py="1 / 0")
    words = ["--functions", place.format(bad=bad)] if place else []
    code, out, err = run(domain, problem, *words)
    assert (code, out) == (2, "")
    assert message in err


def test_a_function_that_raises_ends_the_search_with_a_sentence(run, files) -> None:
    broken = CODE.replace("% 2", "% 0")
    domain, problem, code = files(d_pdl=EVEN, p_pdl=BOXES, f_py=broken)
    ended, _, err = run(domain, problem, "--functions", code, "--meta-predicates", f"{code}:RULES")
    assert ended == 2
    assert "function (is-even w1) raised ZeroDivisionError" in err


PDDL = """(define (domain boxes) (:predicates (p)) (:action a :parameters () :effect (p)))"""
PDDL_PROBLEM = "(define (problem x) (:domain boxes) (:init) (:goal (p)))"


GENERATED = """
(ptype-of box :top-type)
(infinite-type weight #'numberp)
(OPERATOR weigh
  (params <b> <w>)
  (preconds ((<b> box) (<w> (and weight (weights <b> <w>)))) (unweighed <b>))
  (effects () ((del (unweighed <b>)) (add (weighs <b> <w>)))))
"""


def test_generators_come_from_a_users_file(run, files) -> None:
    code = """
from rogue.prodigy import generator

@generator
def weights(box, weight):
    return [3, 5] if weight is None else [weight]
"""
    problem = "(create-problem (objects (a box)) (state (unweighed a)) (goal (weighs a 5)))"
    paths = files(d_pdl=GENERATED, p_pdl=problem, f_py=code)
    ended, out, err = run(*paths[:2], "--functions", paths[2], "--check")
    assert (ended, err) == (0, "")
    assert "\t<WEIGH A 5>" in out


def test_pddl_is_recognised_by_its_text(run, files) -> None:
    comment = ";(ptype-of this is not)\n\n"
    domain, problem = files(d_txt=comment + PDDL, p_txt=PDDL_PROBLEM.upper())
    code, out, err = run(domain, problem, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["plan"] == ["a"]


COSTS = """(define (domain ways) (:requirements :action-costs) (:predicates (here) (there))
  (:functions (total-cost) - number)
  (:action fly :parameters () :precondition (here)
    :effect (and (there) (increase (total-cost) 9)))
  (:action walk :parameters () :precondition (here)
    :effect (and (there) (increase (total-cost) 2.5))))"""
AWAY = "(define (problem x) (:domain ways) (:init (here)) (:goal (there)) {})"


def test_a_problem_with_a_metric_is_solved_ever_more_cheaply(run, files) -> None:
    metric = AWAY.format("(:metric minimize (total-cost))")
    paths = files(d_x=COSTS, p_x=metric, q_x=AWAY.format(""))
    _, out, _ = run(*paths[:2], "--level", 1)
    assert "solution 1: 1 step at a cost of 9" in out
    assert "solution 2: 1 step at a cost of 2.5" in out
    assert "solved: 1 step at a cost of 2.5; " in out
    document = json.loads(run(*paths[:2], "--json")[1])
    assert document["solutions"] == [{"plan": ["fly"], "cost": 9}, {"plan": ["walk"], "cost": 2.5}]
    assert (document["plan"], document["cost"]) == (["walk"], 2.5)
    document = json.loads(run(paths[0], paths[2], "--json")[1])
    assert document["solutions"] == [{"plan": ["fly"], "cost": 9}]


def test_all_solutions_are_listed(run) -> None:
    code, out, _ = run(*pair("rockets-two"), "--solutions", "different", "--json")
    plans = [tuple(solution["plan"]) for solution in json.loads(out)["solutions"]]
    assert code == 0
    assert len(set(plans)) == len(plans) == 4


def test_protection_keeps_a_goal_that_a_conditional_effect_would_undo(run) -> None:
    code, out, _ = run(*pair("briefcase-home"), "--protection", "--check", "--level", 1)
    assert code == 0
    assert "solved: " in out
    assert out.endswith("checked: the plan is valid\n")


@pytest.mark.parametrize(
    ("domain", "problem", "message"),
    [
        (PDDL, BOXES, "p.x:1:1: found PRODIGY's language, expected PDDL, in which"),
        (EVEN, PDDL_PROBLEM, "p.x:1:1: found PDDL, expected PRODIGY's language, in which"),
        (PDDL_PROBLEM, PDDL, "d.x:1:10: found problem, expected domain"),
        (PDDL, PDDL, "p.x:1:10: found domain, expected problem"),
        (PDDL.replace("boxes", "crates"), PDDL_PROBLEM, "p.x:1:30: found boxes, expected crates"),
        (BOXES, BOXES, "d.x:1:2: found create-problem, expected one of"),
        ("", BOXES, "d.x:1:1: found no expression, expected a domain"),
        (PDDL, "", "p.x:1:1: found PRODIGY's language, expected PDDL"),
        ("# A title\n\nSome prose.", BOXES, "d.x:1:1: found #, expected '('"),
        ('{"domain": [1, 2]}', BOXES, "d.x:1:1: found {, expected '('"),
        (PDDL.replace("(:p", "(:requirements :adl :time) (:p"), PDDL_PROBLEM, "found :time"),
    ],
)
def test_the_wrong_text_is_refused(run, files, domain: str, problem: str, message: str) -> None:
    code, out, err = run(*files(d_x=domain, p_x=problem))
    assert (code, out) == (2, "")
    assert message in err
    assert len(err.splitlines()) == 1


def test_what_is_no_file_is_refused(run, files, tmp_path: Path) -> None:
    (problem,) = files(p_pdl=BOXES)
    binary = tmp_path / "binary"
    binary.write_bytes(b"(ptype-of a :top-type)\n\x7fELF\xff\xfe")
    for domain, message in [
        (tmp_path / "none", f"{tmp_path}/none cannot be read: No such file or directory"),
        (tmp_path, f"{tmp_path} cannot be read: Is a directory"),
        (binary, "binary:2:5: found byte 0xff, expected text in UTF-8"),
        (Path("/dev/zero"), "expected a file of at most 50 MB"),
    ]:
        code, out, err = run(domain, problem)
        assert (code, out) == (2, "")
        assert message in err


@pytest.mark.parametrize("language", ["pdl", "pddl"])
def test_a_large_file_with_an_error_at_its_end_is_refused_there(run, files, language: str) -> None:
    facts = "\n".join(f"(unweighed b{n})" for n in range(20_000))
    if language == "pdl":
        problem = f"(create-problem (objects (a box)) (state (and\n{facts})) (goal (weighed a)))"
        domain = EVEN.partition("(CONTROL-RULE")[0].replace("(is-even <w>)", "(diff <b> <w>)")
    else:
        problem = f"(define (problem x) (:domain boxes) (:init\n{facts}\n) (:goal (p)))"
        domain = PDDL
    code, _, err = run(*files(d_x=domain, p_x=problem))
    assert code == 2
    assert "p.x:2:" in err


def test_bad_flags_are_usage_errors(run) -> None:
    for words in (["--mode", "best"], ["--level", 4], ["--nodes", 0], ["--time", -1]):
        code, out, err = run(*pair("rockets-two"), *words)
        assert (code, out) == (2, "")
        assert err.startswith("error: ")


def test_the_search_tree_is_drawn(run, tmp_path: Path):
    domain, problem = DOMAINS / "rockets.pdl", DOMAINS / "rockets-two.pdl"
    assert run(domain, problem, "--svg", tmp_path / "tree.svg")[0] == 0
    root = ET.parse(tmp_path / "tree.svg").getroot()
    words = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "Solution:" in words
    assert "  3  <fly apollo here there>  done" in words
