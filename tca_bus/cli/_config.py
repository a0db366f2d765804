"""The file behind ``--config``: values for flags, shared or of one command."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from tca_bus._errors import ConfigError, did_you_mean
from tca_bus.cli._flags import BusFlags


def file_values(path: Path, tool: str, commands: Sequence[str]) -> dict[str, Any]:
    """Read the flags that the file gives to one command of one tool.

    Keys at the top are shared flags; the table ``[tool.command]`` holds those of a command.

    Raises:
        ConfigError: the file cannot be read, is no TOML, or has a key that no flag has.
    """
    table = _read(path)
    shared = {key: value for key, value in table.items() if not isinstance(value, dict)}
    known = {field.name for field in fields(BusFlags)} - {"config"}
    for key, value in shared.items():
        if key.replace("-", "_") not in known:
            hint = did_you_mean(key, known)
            raise ConfigError(
                f"{key} in {path}", value, f"one of {', '.join(sorted(known))}.{hint}"
            )
    own = table.get(tool, {})
    for command in commands:
        own = own.get(command, {}) if isinstance(own, dict) else {}
    return {_flag(key): value for key, value in {**shared, **own}.items()}


def _flag(key: str) -> str:
    return key.replace("_", "-")


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError("--config", str(path), f"a file that can be read ({why})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("--config", str(path), f"a TOML file ({error})") from None
