"""Floor plans from YAML files: read, checked, and explained when they are wrong."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from tca_bus import did_you_mean
from xavier_sim.floors._floor_checks import FloorError, check_floor
from xavier_sim.messages import FloorPlan

FLOORS = Path(__file__).parent
"""The floors that come with the package, one file each."""

DEFAULT_FLOOR = "wean5"


def floor_names() -> list[str]:
    """The names of the floors that come with the package."""
    return sorted(path.stem for path in FLOORS.glob("*.yaml"))


def find_floor(floor: str) -> Path:
    """The file of a floor, given its name or a path.

    Raises:
        FloorError: there is no such file and no floor of that name.
    """
    if floor in floor_names():
        return FLOORS / f"{floor}.yaml"
    path = Path(floor)
    with suppress(OSError):
        if path.is_file():
            return path
    near = did_you_mean(floor, floor_names())
    expected = f"a floor plan file or one of {', '.join(floor_names())}.{near}"
    raise FloorError(floor, "map", floor, expected)


def load_floor(floor: str = DEFAULT_FLOOR) -> FloorPlan:
    """Read and check a floor plan.

    Args:
        floor: the name of a floor of the package, or a path to a YAML file.

    Raises:
        FloorError: it cannot be read, is no YAML, or describes no possible floor; the error
            names file, item, value and what was expected.
    """
    path = find_floor(floor)
    plan = _validate(str(path), _read_yaml(path))
    check_floor(str(path), plan)
    return plan


class TwiceError(yaml.MarkedYAMLError):
    """A key stands twice in a mapping, of which YAML would silently take the last."""


class _Loader(yaml.SafeLoader):
    """Reads YAML in which no name is given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                raise TwiceError(problem=f"a second {key.value}", problem_mark=key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep=deep)


def _read_yaml(path: Path) -> Any:
    try:
        return yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)  # noqa: S506 - a safe one
    except OSError as error:
        why = f"unreadable: {error.strerror}"
        raise FloorError(str(path), "file", why, "a readable UTF-8 text file") from error
    except UnicodeDecodeError as error:
        why = f"no text from byte {error.start} on"
        raise FloorError(str(path), "file", why, "a readable UTF-8 text file") from error
    except RecursionError as error:
        raise FloorError(str(path), "file", "nested without end", "a plain mapping") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}" if mark else "file"
        expected = "each name once" if isinstance(error, TwiceError) else "valid YAML"
        raise FloorError(str(path), where, error.problem, expected) from error
    except yaml.YAMLError as error:
        raise FloorError(str(path), "file", error, "valid YAML") from error


def _validate(file: str, data: Any) -> FloorPlan:
    if not isinstance(data, dict):
        raise FloorError(file, "top level", type(data).__name__, "a mapping with spaces and doors")
    try:
        return FloorPlan.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        item = _item_name(data, first["loc"])
        value = None if first["type"] == "missing" else first["input"]
        raise FloorError(file, item, value, _expected(first["type"], first["msg"])) from error


def _expected(kind: str, message: str) -> str:
    """What should have been there, made from the kind and the words of a validator's complaint."""
    plain = {"missing": "a value", "extra_forbidden": "no field of that name"}
    if kind in plain:
        return plain[kind]
    return re.sub(r"^(Value error, |\w+ should (be |have ))", "", message)


def _item_name(data: dict[str, Any], location: tuple[int | str, ...]) -> str:
    """The field at ``location``, with the name of the space or door that it belongs to."""
    field = ".".join(str(part) for part in location)
    match location:
        case (str(section), int(index), *_):
            entry = data[section][index]
            name = entry.get("name") if isinstance(entry, dict) else None
            return f"{field} ({name})" if isinstance(name, str) else field
    return field
