"""The table from TCA's functions to ours: what it names is there, and what is not says why."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import shlex
import typing
from pathlib import Path

import pytest
from pydantic import BaseModel

import tca_bus
import tca_bus.testing
from tca_bus import Message
from tca_bus.cli.tca import app

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "tca.md").read_text(encoding="utf-8")
TESTS = Path(__file__).parent

ROW = re.compile(r"^\| (?P<theirs>.+?) \| (?P<ours>.+?) \|(?P<why>.*)\|$", re.MULTILINE)
HEADS = {"TCA", "TCM"}
ROWS = [match for match in ROW.finditer(PAGE) if match["theirs"] not in HEADS]
OURS = sorted({name for row in ROWS for name in re.findall(r"`([^`]+)`", row["ours"])})
THEIRS = [name for row in ROWS for name in re.findall(r"`(tca[A-Z]\w+)`", row["theirs"])]
SECTIONS = {
    title: re.findall(r"`(test_\w+\.py)`", text)
    for title, text in re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
}
GROUPS = sorted(title for title, tests in SECTIONS.items() if tests)

CALL = re.compile(r"(?P<path>[\w.]+)(?:\((?P<option>\w+)=\))?")


def wire_names(kind: type[Message] = Message) -> set[str]:
    below = [wire_names(sub) for sub in kind.__subclasses__()]
    return {kind.wire_name}.union(*below)


def find(path: str) -> object:
    """What a dotted name stands for.

    Raises:
        AttributeError: It stands for nothing.
    """
    if path.startswith("tca_bus."):
        return importlib.import_module(path)
    first, *rest = path.split(".")
    value = getattr(tca_bus, first)
    for name in rest:
        value = attribute(value, name)
    return value


def attribute(value: object, name: str) -> object:
    if typing.is_typeddict(value):
        return inspect.get_annotations(value)[name]
    if isinstance(value, type) and issubclass(value, BaseModel) and name in value.model_fields:
        return value.model_fields[name]
    return getattr(value, name)


@pytest.mark.parametrize("name", [name for name in OURS if not name.startswith(("tca ", "tca."))])
def test_what_is_named_is_there(name):
    match = CALL.fullmatch(name)
    assert match is not None, f"{name} is neither a name nor name(option=)"
    value = find(match["path"])
    if match["option"] is not None:
        assert match["option"] in inspect.signature(value).parameters


@pytest.mark.parametrize("command", [name for name in OURS if name.startswith("tca ")])
def test_commands_are_understood(command):
    _, *words = shlex.split(command)
    app.parse_args(words, exit_on_error=False, print_error=False)
    assert app.parse_commands(words)[0][0] == words[0]


def test_central_serves_what_the_table_says():
    named = {name for name in OURS if name.startswith("tca.")}
    assert named
    assert named <= wire_names()


def test_what_has_no_counterpart_says_why():
    silent = [row["theirs"] for row in ROWS if row["ours"] == "–" and not row["why"].strip()]
    assert not silent


def test_each_function_of_tca_is_there_once():
    assert len(THEIRS) > 130
    assert sorted(set(THEIRS)) == sorted(THEIRS)


def test_every_condition_and_flag_of_the_original_has_its_row():
    theirs = {row["theirs"] for row in ROWS}
    assert theirs >= {condition.value for condition in tca_bus.TapCondition}
    assert theirs >= {"SEQ_ACH", "SEQ_PLANNING", "PLAN_FIRST", "DELAY_PLANNING", "NO_TPLCONSTR"}
    relations = {relation.name for relation in tca_bus.Relation}
    assert {f"Relation.{name}" for name in relations} <= {
        name for name in OURS if name.startswith("Relation.")
    }


@pytest.mark.parametrize("title", GROUPS)
def test_the_tests_of_a_group_are_there(title):
    for name in SECTIONS[title]:
        tree = ast.parse((TESTS / name).read_text(encoding="utf-8"))
        assert ast.get_docstring(tree), name


def test_every_group_has_tests():
    tables = re.findall(r"^## (.+?)\n(?:(?!^## ).*\n)*?\| TC[AM] ", PAGE, re.MULTILINE)
    assert len(tables) == 16
    assert set(tables) <= set(GROUPS)
