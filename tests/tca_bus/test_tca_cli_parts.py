"""Parts of the command line that need no bus: payloads, schemas, the configuration file, trees."""

from __future__ import annotations

import asyncio
import io
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, TypeAdapter, ValidationError

from tca_bus import ConfigError, Failure, InvalidMessageError, TaskStatus
from tca_bus._protocol import ProvidedMessage
from tca_bus._schema import schema_problems
from tca_bus.cli._answers import TypedLines
from tca_bus.cli._config import file_values
from tca_bus.cli._config_path import config_path
from tca_bus.cli._payload import check_class, check_payload, parse_payload
from tca_bus.cli._tree_rows import tree_lines
from tca_bus.cli.tca import app


class Inner(BaseModel, extra="forbid"):
    kind: str
    tags: list[int] = []


class Outer(BaseModel, extra="forbid"):
    name: str
    size: float
    inner: Inner | None = None
    level: int | str = 0


SCHEMA = Outer.model_json_schema()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{", "line 1 column 2"),
        ('{"a": 1,\n "b" 2}', "line 2 column 6"),
        ("[1]", "expected a JSON object"),
        ('"x"', "expected a JSON object"),
        ('{"x": NaN}', "NaN is no number"),
        ("[" * 100_000, "nested too deep"),
    ],
)
def test_what_is_no_json_object_is_told_with_its_place(text, problem):
    with pytest.raises(InvalidMessageError, match="go") as caught:
        parse_payload("go", text)
    assert problem in str(caught.value)


def test_a_dash_reads_standard_input(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO('{"x": 1}'))
    assert parse_payload("go", "-") == {"x": 1}


@pytest.mark.parametrize("kind", ["query", "inform", "broadcast", "goal", "command"])
def test_a_dash_is_no_option(kind):
    _, bound, _ = app.parse_args([kind, "go", "-", "--realm", "r"], print_error=False)
    assert bound.args == ("go", "-")


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ({"size": 1}, "name: field required"),
        ({"name": "a", "size": "b"}, "size: expected number, got 'b'"),
        ({"name": "a", "size": True}, "size: expected number, got True"),
        ({"name": "a", "size": 1, "levle": 2}, "Did you mean 'level'?"),
        ({"name": "a", "size": 1, "inner": {"kind": 1}}, "inner.kind: expected string, got 1"),
        (
            {"name": "a", "size": 1, "inner": {"kind": "k", "tags": [1, "2"]}},
            "inner.tags[1]: expected integer, got '2'",
        ),
        ({"name": "a", "size": 1, "level": []}, "level: expected integer, got []"),
    ],
)
def test_data_that_do_not_fit_their_schema_are_told_by_field(value, problem):
    assert any(problem in told for told in schema_problems(value, SCHEMA))


@given(
    st.fixed_dictionaries(
        {"name": st.text(), "size": st.integers() | st.floats(allow_nan=False)},
        optional={
            "inner": st.none() | st.fixed_dictionaries({"kind": st.text()}),
            "level": st.integers() | st.text() | st.none(),
        },
    )
)
def test_what_the_model_takes_the_schema_takes(value):
    try:
        TypeAdapter(Outer).validate_python(value, strict=True)
    except ValidationError:
        assert schema_problems(value, SCHEMA)
    else:
        assert schema_problems(value, SCHEMA) == []


def message_of(name, message_class):
    return ProvidedMessage(
        name=name,
        message_class=message_class,
        revision=1,
        summary="",
        message_schema=SCHEMA,
        reply_schema=None,
    )


def test_a_message_of_another_class_names_the_command_to_use():
    provided = message_of("go", "goal")
    check_class(provided, "go", "goal")
    with pytest.raises(InvalidMessageError, match="use 'tca goal go'"):
        check_class(provided, "go", "command")
    with pytest.raises(InvalidMessageError, match="name: field required"):
        check_payload(provided, "go", {"size": 1})
    check_payload(None, "go", {"anything": 1})


def test_a_question_to_all_is_asked_as_a_query():
    provided = message_of("survey", "multi_query")
    check_class(provided, "survey", "query")
    with pytest.raises(InvalidMessageError, match="use 'tca query survey'"):
        check_class(provided, "survey", "goal")


def test_the_configuration_file_is_found_in_flags_and_environment():
    assert config_path(["modules", "--config", "a.toml"], {}) == Path("a.toml")
    assert config_path(["--config=b.toml"], {"TCA_CONFIG": "c.toml"}) == Path("b.toml")
    assert config_path(["modules"], {"TCA_CONFIG": "c.toml"}) == Path("c.toml")
    assert config_path(["query", "--", "--config", "x"], {}) is None


def test_the_configuration_file_has_shared_flags_and_those_of_commands(tmp_path):
    file = tmp_path / "tca.toml"
    file.write_text('log_level = "debug"\n[tca.log]\nlast = 3\n[rogue.up]\nspeed = "max"\n')
    assert file_values(file, "tca", ["log"]) == {"log-level": "debug", "last": 3}
    assert file_values(file, "tca", ["tree"]) == {"log-level": "debug"}
    assert file_values(file, "rogue", ["up"]) == {"log-level": "debug", "speed": "max"}


@pytest.mark.parametrize(
    ("text", "problem"),
    [("relm = 1", "Did you mean 'realm'"), ("realm = ", "a TOML file"), (None, "can be read")],
)
def test_a_bad_configuration_file_is_told(tmp_path, text, problem):
    file = tmp_path / "tca.toml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigError, match=problem):
        file_values(file, "tca", [])


def status(id: str, parent: str | None, **facts) -> TaskStatus:
    values = {
        "name": "go",
        "task_class": "goal",
        "sender": "me",
        "state": "active",
        "handling": "handling",
        "planning": "planning",
        "achievement": "achieving",
        "existence": "alive",
        "created": 10.0,
        "sequence": 1,
    }
    return TaskStatus(id=id, parent=parent, **{**values, **facts})


def test_a_tree_is_drawn_with_what_each_node_does():
    failure = Failure(name="door_blocked", text="the door is closed")
    statuses = [
        status("a", None, handler="rogue"),
        status("b", "a", state="pending", waiting_for="navigate to take it"),
        status("c", "b", handler="navigate", attempt=2),
        status("d", "a", state="failed", ended=11.0, failure=failure),
        status("e", "gone"),
    ]
    assert list(tree_lines(statuses, 12.5)) == [
        "● go a  active  2.5 s  rogue",
        "├─ ○ go b  pending  2.5 s  waits for navigate to take it",
        "│  └─ ● go c  active  2.5 s  navigate (try 2)",
        "└─ ✗ go d  failed  1.0 s  the door is closed (door_blocked)",
        "● go e  active  2.5 s",
    ]


def test_what_is_suspended_or_was_retried_is_marked_in_the_tree():
    held = status("b", "a", state="pending", suspended=True, waiting_for="being resumed")
    statuses = [status("a", None, suspended=True, retries=2, attempt=3, handler="rogue"), held]
    assert list(tree_lines(statuses, 12.5)) == [
        "● go a  active, suspended, retried 2x  2.5 s  rogue (try 3)",
        "└─ ‖ go b  pending, suspended  2.5 s  waits for being resumed",
    ]


async def test_typed_lines_come_one_by_one_from_pipes_and_files(tmp_path):
    reader, writer = os.pipe()
    typed = TypedLines(reader)
    os.write(writer, b"y\nno\nlast")
    assert [await typed.next(), await typed.next()] == ["y", "no"]
    waiting = asyncio.ensure_future(typed.next())
    await asyncio.sleep(0)
    waiting.cancel()
    await asyncio.wait([waiting])
    os.close(writer)
    assert [await typed.next(), await typed.next()] == ["last", None]
    os.close(reader)
    path = tmp_path / "answers"
    path.write_text("y\n")
    with path.open("rb", buffering=0) as file:
        kept = TypedLines(file.fileno())
        assert [await kept.next(), await kept.next()] == ["y", None]
