"""What is written can be read back; what is no PDL gives a PdlError and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_writing import domain_text, problem_text

from rogue.prodigy import (
    Domain,
    Effect,
    InferenceMode,
    InferenceRule,
    Literal,
    Objects,
    Operator,
    PdlError,
    Problem,
    SearchOptions,
    State,
    Status,
    load_domain,
    load_problem,
    parse_domain,
    parse_literal,
    parse_problem,
    solve,
)
from rogue.prodigy._expressions import (
    TRUE,
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
)
from rogue.prodigy._functions import BUILT_IN
from rogue.prodigy._terms import Atom, Term, Variable
from rogue.prodigy._types import TOP_TYPE, TypeSpec, TypeTree

DOMAINS = Path(__file__).parent / "domains"
PARENTS = {"animal": TOP_TYPE, "dog": "animal", "cat": "animal", "puppy": "dog", "food": TOP_TYPE}
TREE = TypeTree(PARENTS, {"weight": "numberp"})
CONSTANTS = {"rex": "puppy", "tom": "cat", "fish": "food", "ball": TOP_TYPE}
ARITIES = {"owns": 2, "eats": 2, "happy": 1, "raining": 0}

finite = st.frozensets(st.sampled_from(TREE.finite()), min_size=1).map(TREE.spec)
simple = st.sampled_from([TypeSpec((name,)) for name in TREE.finite()])


def calls(names: tuple[str, ...]) -> st.SearchStrategy[tuple[Call, ...]]:
    terms = st.sampled_from([*map(Variable, names), "rex"])
    tests = st.builds(Call, st.just("diff"), st.tuples(terms, terms))
    atom = st.builds(Atom, st.just("owns"), st.tuples(terms, terms))
    generators = st.builds(Call, st.just("gen-from-pred"), st.just(()), atom)
    return st.lists(tests | generators, max_size=2).map(tuple)


def declared(names: tuple[str, ...]) -> st.SearchStrategy[tuple[VariableSpec, ...]]:
    each = (st.builds(VariableSpec, st.just(name), simple, calls(names)) for name in names)
    return st.tuples(*each)


def atoms(names: tuple[str, ...]) -> st.SearchStrategy[Atom]:
    terms: st.SearchStrategy[Term] = st.sampled_from([*map(Variable, names), *CONSTANTS, 3, -0.5])
    return st.sampled_from(sorted(ARITIES)).flatmap(
        lambda name: st.builds(Atom, st.just(name), st.tuples(*[terms] * ARITIES[name]))
    )


def expressions(names: tuple[str, ...], depth: int = 3) -> st.SearchStrategy[Expression]:
    leaf: st.SearchStrategy[Expression] = atoms(names).map(Holds)
    if depth == 0:
        return leaf
    inner = expressions(names, depth - 1)
    more = (*names, f"<q{depth}>")
    quantified = expressions(more, depth - 1)
    variables = declared(more[-1:])
    several = st.lists(inner, max_size=2).map(tuple)
    return st.one_of(
        leaf,
        inner.map(Not),
        several.map(And),
        several.map(Or),
        st.builds(Exists, variables, quantified),
        st.builds(Forall, variables, quantified),
    )


def plain_effects(names: tuple[str, ...], adds: bool) -> st.SearchStrategy[Effect]:
    return st.builds(Effect, atoms(names), st.just(adds), st.just(()), st.just(TRUE))


def ranging_effects(names: tuple[str, ...], adds: bool) -> st.SearchStrategy[Effect]:
    atom = st.just(Atom("owns", (Variable(names[0]), Variable("<e>"))))
    variables = st.builds(VariableSpec, st.just("<e>"), simple).map(lambda spec: (spec,))
    return st.builds(Effect, atom, st.just(adds), variables, expressions((*names, "<e>"), 1))


def effects(names: tuple[str, ...]) -> st.SearchStrategy[tuple[Effect, ...]]:
    def some(adds: bool) -> st.SearchStrategy[list[Effect]]:
        return st.lists(plain_effects(names, adds) | ranging_effects(names, adds), max_size=2)

    return st.builds(lambda dels, adds: (*dels, *adds), some(False), some(True))


NAMES = ("<x>", "<y>")
parts = (declared(NAMES), expressions(NAMES), effects(NAMES))
params = st.sampled_from([(), ("<y>",), ("<y>", "<x>")])


@st.composite
def domains(draw: st.DrawFn) -> Domain:
    operators = tuple(
        Operator(f"op{at}", draw(params), *draw(st.tuples(*parts)))
        for at in range(draw(st.integers(0, 2)))
    )
    rules = tuple(
        InferenceRule(f"rule{at}", draw(params), *draw(st.tuples(*parts)), InferenceMode.LAZY)
        for at in range(draw(st.integers(0, 1)))
    )
    return Domain("zoo", TREE, operators, {}, {}, CONSTANTS, inference_rules=rules)


@settings(max_examples=40, deadline=None)
@given(domains())
def test_a_domain_is_read_back_as_it_was_written(domain: Domain) -> None:
    read = parse_domain(domain_text(domain))
    assert read.name == domain.name
    assert read.types == domain.types
    assert read.constants == domain.constants
    assert read.operators == domain.operators
    assert read.inference_rules == domain.inference_rules
    assert read.predicates.items() <= ARITIES.items()
    assert parse_domain(domain_text(domain).upper()).operators == domain.operators


ground = expressions(("<g>",), 2)
facts = st.sampled_from(sorted(ARITIES)).flatmap(
    lambda name: st.builds(
        Literal, st.just(name), st.tuples(*[st.sampled_from([*CONSTANTS, 3])] * ARITIES[name])
    )
)


@settings(max_examples=60, deadline=None)
@given(st.lists(facts, max_size=5), declared(("<g>",)), ground)
def test_a_problem_is_read_back_as_it_was_written(
    true: list[Literal], variables: tuple[VariableSpec, ...], goal: Expression
) -> None:
    domain = Domain("zoo", TREE, (), ARITIES, BUILT_IN, CONSTANTS)
    objects = Objects(TREE, {**CONSTANTS, "spot": "dog"})
    problem = Problem(domain, "feeding", objects, State(true), goal, variables)
    read = parse_problem(problem_text(problem), domain)
    assert read.name == "feeding"
    assert read.objects.types_of == objects.types_of
    assert read.state == problem.state
    assert (read.variables, read.goal) == (variables, goal)


TypeTerm = tuple[str, frozenset[str]]


def type_terms(depth: int) -> st.SearchStrategy[TypeTerm]:
    below = {t: frozenset(n for n in TREE.finite() if TREE.is_a(n, t)) for t in TREE.finite()}
    leaf = st.sampled_from(sorted(below)).map(lambda name: (name, below[name]))
    if depth == 0:
        return leaf
    inner = st.lists(type_terms(depth - 1), min_size=1, max_size=3)

    def combined(word: str) -> st.SearchStrategy[TypeTerm]:
        def combine(terms: list[TypeTerm]) -> TypeTerm:
            sets = [members for _, members in terms]
            every = frozenset(TREE.finite())
            made = {
                "and": frozenset.intersection(*sets),
                "or": frozenset.union(*sets),
                "not": every - frozenset.union(*sets),
            }
            return f"({word} {' '.join(text for text, _ in terms)})", made[word]

        return inner.map(combine)

    return leaf | combined("and") | combined("or") | combined("not")


@settings(max_examples=80, deadline=None)
@given(type_terms(3))
def test_combinations_of_types_are_sets(term: TypeTerm) -> None:
    text, members = term
    types = "".join(f"(ptype-of {name} {above})" for name, above in PARENTS.items())
    text = f"{types}(operator see (preconds ((<x> {text}))) (effects () ()))"
    if not members:
        with pytest.raises(PdlError, match="that some object can have"):
            parse_domain(text)
        return
    domain = parse_domain(text)
    assert domain.types.members(domain.operators[0].variables[0].types) == members


SOUND = sorted(DOMAINS.glob("*.pdl"))


BLOCKS = load_domain(DOMAINS / "blocks.pdl")


def complaints(text: str) -> list[PdlError]:
    """Read a text as everything that it may be; any other error fails the test."""
    found: list[PdlError] = []
    readers: list[Callable[[str], object]] = [
        parse_domain,
        lambda text: parse_problem(text, BLOCKS),
        lambda text: parse_literal(text, BLOCKS),
    ]
    for read in readers:
        try:
            read(text)
        except PdlError as error:
            found.append(error)
    return found


def flawed(data: st.DataObject, content: bytearray) -> None:
    at = data.draw(st.integers(0, max(0, len(content) - 1)))
    match data.draw(st.sampled_from(["flip", "cut", "drop", "insert"])):
        case "flip":
            content[at : at + 1] = bytes([data.draw(st.integers(0, 255))])
        case "cut":
            del content[at:]
        case "drop":
            del content[at : at + data.draw(st.integers(1, 40))]
        case _:
            content[at:at] = data.draw(st.sampled_from([b"(", b")", b'"', b"'", b"#|", b"\xff"]))


@settings(max_examples=120, deadline=None)
@given(st.sampled_from(SOUND), st.data())
def test_a_file_with_flaws_gives_an_error_of_the_language(path: Path, data: st.DataObject) -> None:
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        flawed(data, content)
    errors = complaints(content.decode("latin-1"))
    assert errors
    assert all(e.position.line >= 1 and e.position.column >= 1 and str(e) for e in errors)


WORDS = (
    *("(", "(", "(", ")", ")", ")", "operator", "inference-rule", "control-rule", "if", "then"),
    *("and", "or", "~", "forall", "exists", "<x>", "<y>", "a", "object", "on", "clear", "params"),
    *("preconds", "effects", "add", "del", "select", "goal", "bindings", ".", "current-goal"),
    *("known", "nil", "9/0", "pinstance-of", "ptype-of", "infinite-type", ":top-type"),
    *("create-problem", "objects", "state", "objects-are", "mode", "type-of-object"),
)


@settings(max_examples=120, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=40), st.sampled_from(["", "(operator x ", "("]))
def test_words_in_any_order_give_an_error_of_the_language(words: list[str], start: str) -> None:
    assert all(str(error) for error in complaints(start + " ".join(words)))


def test_files_are_read_in_any_case_of_letters_and_with_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "blocks.lisp"
    path.write_bytes(b"\xef\xbb\xbf" + (DOMAINS / "blocks.pdl").read_bytes().upper())
    domain = load_domain(path)
    assert domain.operators == BLOCKS.operators
    problem = load_problem(DOMAINS / "blocks-sussman.pdl", domain)
    assert solve(problem).status is Status.SOLVED


@pytest.mark.parametrize("levels", [2, 94])
@pytest.mark.parametrize("word", ["and", "or", "~", "exists ((<v> object))"])
def test_nesting_is_bounded_and_not_by_the_stack(levels: int, word: str) -> None:
    opened = "".join(f"({word.replace('<v>', f'<v{at}>')} " for at in range(levels))
    text = f"(create-problem (objects (a object)) (state (holding a)) (goal {opened}(holding a)"
    problem = parse_problem(text + ")" * (levels + 2), BLOCKS)
    assert solve(problem, SearchOptions(max_nodes=200)).status is Status.SOLVED


def test_too_deep_a_nesting_says_so() -> None:
    with pytest.raises(PdlError, match="at most 100 levels"):
        parse_literal("(" * 100_000, BLOCKS)


def test_numbers_are_read_as_lisp_writes_them() -> None:
    domain = parse_domain("(operator weigh (preconds () (is 1 2 3 4 5)) (effects () ()))")
    assert parse_literal("(is 9/64 4/2 -0.5 +3 1e3)", domain) == Literal(
        "is", (0.140625, 2, -0.5, 3, 1000.0)
    )
    for word in ("inf", "nan", "1_000", "1/0", "9" * 400, "1e999", "1+"):
        assert parse_literal(f"(is {word} a b c d)", domain).args[0] == word


@pytest.mark.parametrize(
    "state", ["(and (clear a) (clear b))", "(clear a) (clear b)", "((clear a) (clear b))"]
)
def test_facts_are_listed_in_several_ways(state: str) -> None:
    problem = parse_problem(
        f"(create-problem (objects (a b object)) (state {state}) (goal ()))", BLOCKS
    )
    assert len(problem.state.tuples("clear")) == 2


def large(objects: int, facts: int) -> str:
    names = " ".join(f"b{at}" for at in range(objects))
    on = "\n".join(f"(on b{at % objects} b{(at * 7 + 1) % objects})" for at in range(facts))
    return (
        f"(create-problem (objects (objects-are {names} object))\n"
        f"  (state (and {on}))\n"
        "  (goal (on b1 b2)))"
    )


def test_ten_thousand_objects_are_read() -> None:
    problem = parse_problem(large(10_000, 10_000), BLOCKS)
    assert len(problem.objects.names()) == 10_000
    assert len(problem.state.tuples("on")) == 10_000


def test_an_error_in_a_large_file_is_as_short_as_in_a_small_one() -> None:
    text = large(2_000, 2_000).replace("(on b1 b2)", f"(on b1 b{'x' * 100_000})")
    with pytest.raises(PdlError) as caught:
        parse_problem(text, BLOCKS)
    assert len(str(caught.value)) < 300
    with pytest.raises(PdlError, match="the end of the text") as caught:
        parse_problem(large(2_000, 2_000)[:-1], BLOCKS)
    assert "')' for '(' at problem:1:1" in str(caught.value)
