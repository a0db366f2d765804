"""Reads a policy from a TOML file, with errors that say where and what."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from tca_bus._errors import ConfigError, did_you_mean
from tca_bus._policy import Grant, Limit, ModuleGrant, Policy

MOST_SHOWN = 80
"""Letters of a wrong value that an error repeats."""

KINDS = {
    "tuple_type": "a list of patterns",
    "dict_type": "a table",
    "model_type": "a table",
    "string_type": "a text",
}
"""What a validator calls after Python, as it is called in TOML."""


def read_policy(path: Path) -> Policy:
    """Read a policy.

    Raises:
        ConfigError: The file cannot be read, is no TOML, or a field of it cannot be used; it
            names the file, the field, the value and what was expected.
    """
    table = _read(path)
    try:
        return Policy.model_validate(table)
    except ValidationError as error:
        raise _as_config_error(error, path) from None


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError("policy", str(path), f"a file that can be read ({why})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("policy", str(path), f"a TOML file ({error})") from None


def _as_config_error(error: ValidationError, path: Path) -> ConfigError:
    problems = error.errors(include_url=False)
    problem = problems[0]
    where = [str(part) for part in problem["loc"] if part != "[key]"]
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    if problem["type"] == "extra_forbidden":
        expected = _known_fields(where)
    else:
        expected = _expected(problem["type"], problem["msg"])
    if not where:
        return ConfigError("policy", str(path), f"one that fits together: {expected}{more}")
    shown = problem["input"] if len(repr(problem["input"])) <= MOST_SHOWN else "..."
    return ConfigError(f"{path}: {'.'.join(where)}", shown, expected + more)


def _expected(kind: str, message: str) -> str:
    if kind in KINDS:
        return KINDS[kind]
    text = message.removeprefix("Value error, ").removeprefix("Input should be ")
    return text[:1].lower() + text[1:]


def _known_fields(where: list[str]) -> str:
    """What may stand in the place of an unknown field."""
    fields = _fields_beside(where)
    hint = did_you_mean(where[-1], fields)
    return f"one of the fields {', '.join(fields)}.{hint}"


def _fields_beside(where: list[str]) -> list[str]:
    if len(where) == 1:
        return list(Policy.model_fields)
    tables: dict[str, type[BaseModel]] = {
        "roles": Grant,
        "modules": ModuleGrant,
        "limits": Limit,
        "everyone": Grant,
    }
    return list(tables[where[0]].model_fields)
