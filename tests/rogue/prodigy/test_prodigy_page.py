"""The page of the language: its examples are read, and its programs print what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rogue.prodigy import _functions, _meta_predicates, parse_domain, validate_plan
from rogue.prodigy._parse_rules import CHOICES

PAGE = (Path(__file__).parents[3] / "docs" / "pdl.md").read_text(encoding="utf-8")
FILE = re.compile(r"```lisp (\S+)\n(.*?)```", re.DOTALL)
PROGRAM = re.compile(r"```python\n(.*?)```\n+```text\n(.*?)```", re.DOTALL)
HARBOUR = "".join(text for name, text in FILE.findall(PAGE) if name == "harbour.pdl")


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "harbour.pdl").write_text(HARBOUR, encoding="utf-8")
    for name, text in FILE.findall(PAGE):
        if name != "harbour.pdl":
            (tmp_path / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(("source", "output"), PROGRAM.findall(PAGE))
def test_a_program_prints_what_the_page_says(
    source: str, output: str, capsys: pytest.CaptureFixture[str]
) -> None:
    exec(source, {})
    assert capsys.readouterr().out == output


def test_the_plan_of_the_page_is_valid() -> None:
    (source, _), *_ = PROGRAM.findall(PAGE)
    names: dict[str, object] = {}
    exec(source + "problem = load_problem('evening.pdl', harbour)\nresult = solve(problem)", names)
    assert validate_plan(names["problem"], names["result"].plan) is None  # type: ignore[arg-type, attr-defined]


def test_the_page_has_every_form() -> None:
    domain = parse_domain(
        HARBOUR,
        functions={"is-fair": bool, "with-tax": _functions.generator(lambda *_: [])},
        meta_predicates={"is-lighter": bool},
    )
    assert {rule.mode for rule in domain.inference_rules} == {"static", "lazy"}
    assert set(re.findall(r"\w+", HARBOUR)) >= {"exists", "forall", "or", "if"}


@pytest.mark.parametrize(
    "name", [*_functions.BUILT_IN, *_meta_predicates.BUILT_IN, *CHOICES, "sub-goal", "apply"]
)
def test_the_page_names_everything_built_in(name: str) -> None:
    assert re.search(rf"[`(]{re.escape(name.removesuffix('s') if name in CHOICES else name)}", PAGE)
