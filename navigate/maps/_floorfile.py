"""Floor plans on disk: read from YAML, checked, with errors that say what is wrong where."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from navigate.maps._map_checks import check_plan
from tca_bus import TcaError, did_you_mean
from xavier_sim.messages import FloorPlan

DEFAULT_MAP = "wean5"


class MapError(TcaError, ValueError):
    """A map cannot be used. ``source`` is the file or name, ``problems`` say why."""

    exit_code = 2

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source, self.problems = source, problems
        super().__init__(f"map {source}: {'; '.join(problems)}")


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Reads YAML in which no name stands twice: YAML itself would take the last, silently."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                line = key.start_mark.line + 1
                raise yaml.YAMLError(
                    f"{key.value!r} stands twice in one mapping, again in line {line}"
                )
            seen.add(key.value)
        return dict(super().construct_mapping(node, deep=deep))


def load_plan(source: str | Path | None = None) -> FloorPlan:
    """Load a floor plan from a YAML file, or one of the package's own by its bare name.

    Args:
        source: a path, or a name such as ``wean5``; the default map when None.

    Raises:
        MapError: the file is missing, is no YAML, or does not describe a sound floor.
    """
    path = _locate(str(source or DEFAULT_MAP))
    try:
        raw = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)  # noqa: S506 - safe ones
        plan = FloorPlan.model_validate(raw)
    except OSError as error:
        raise MapError(str(path), [f"cannot be read: {error.strerror}"]) from error
    except RecursionError as error:
        raise MapError(str(path), ["is nested without end"]) from error
    except UnicodeDecodeError as error:
        raise MapError(str(path), ["is no UTF-8 text"]) from error
    except yaml.YAMLError as error:
        raise MapError(
            str(path), [f"cannot be read as YAML: {' '.join(str(error).split())}"]
        ) from error
    except ValidationError as error:
        raise MapError(str(path), _sentences(error)) from error
    if problems := check_plan(plan):
        raise MapError(str(path), problems)
    return plan


def own_maps() -> list[str]:
    """Names of the maps that come with the package."""
    folder = resources.files("navigate") / "maps"
    return sorted(
        entry.name.removesuffix(".yaml")
        for entry in folder.iterdir()
        if entry.name.endswith(".yaml")
    )


def _locate(source: str) -> Path:
    path = Path(source).expanduser()
    if path.suffix or _is_there(path):
        return path
    known = own_maps()
    if source not in known:
        near = did_you_mean(source, known)
        raise MapError(source, [f"no such file, and no map of that name.{near}"])
    return Path(str(resources.files("navigate") / "maps" / f"{source}.yaml"))


def _is_there(path: Path) -> bool:
    """Whether there is such a file; a name that no file can have names none."""
    try:
        return path.exists()
    except OSError:
        return False


def _sentences(error: ValidationError) -> list[str]:
    return [
        f"{'.'.join(str(part) for part in item['loc']) or 'the document'}: {item['msg']}"
        + ("" if item["type"] == "missing" else f", got {str(item['input'])[:80]!r}")
        for item in error.errors()[:5]
    ]
