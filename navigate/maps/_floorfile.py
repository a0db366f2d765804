"""Floor plans on disk: read from YAML, checked, with errors that say what is wrong where."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from tca_bus import TcaError, did_you_mean
from xavier_sim.messages import Corner, FloorPlan, Space

_Loader: type[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

DEFAULT_MAP = "wean5"


class MapError(TcaError, ValueError):
    """A map cannot be used. ``source`` is the file or name, ``problems`` say why."""

    exit_code = 2

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source, self.problems = source, problems
        super().__init__(f"map {source}: {'; '.join(problems)}")


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
    except UnicodeDecodeError as error:
        raise MapError(str(path), ["is no UTF-8 text"]) from error
    except yaml.YAMLError as error:
        raise MapError(str(path), [f"is no YAML: {' '.join(str(error).split())}"]) from error
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


def check_plan(plan: FloorPlan) -> list[str]:
    """List what is wrong with a plan beyond the types of its fields; empty when it is sound."""
    spaces = {space.name: space for space in plan.spaces}
    return [
        *_check_names(plan),
        *_check_sizes(plan),
        *_check_doors(plan, spaces),
        *_check_places(plan, spaces),
        *_check_start(plan),
    ]


def contains(space: Space, point: Corner, *, slack: float = 0.0) -> bool:
    """Whether ``point`` lies in the rectangle of ``space``, give or take ``slack`` metres."""
    return (
        space.low.x - slack <= point.x <= space.high.x + slack
        and space.low.y - slack <= point.y <= space.high.y + slack
    )


def _locate(source: str) -> Path:
    path = Path(source).expanduser()
    if path.exists() or path.suffix:
        return path
    own = resources.files("navigate") / "maps" / f"{source}.yaml"
    if not own.is_file():
        known = own_maps()
        raise MapError(
            source,
            [f"no such file, and no map of that name.{did_you_mean(source, known)}"],
        )
    return Path(str(own))


def _sentences(error: ValidationError) -> list[str]:
    return [
        f"{'.'.join(str(part) for part in item['loc']) or 'the document'}: {item['msg']}"
        + ("" if item["type"] == "missing" else f", got {str(item['input'])[:80]!r}")
        for item in error.errors()[:5]
    ]


def _check_names(plan: FloorPlan) -> list[str]:
    problems = []
    for kind, names in (
        ("space", [space.name for space in plan.spaces]),
        ("door", [door.name for door in plan.doors]),
    ):
        twice = sorted({name for name in names if names.count(name) > 1})
        problems += [f"{kind} {name!r} is there more than once" for name in twice]
    return problems if plan.spaces else ["there are no spaces"]


def _check_sizes(plan: FloorPlan) -> list[str]:
    return [
        f"space {space.name!r}: low must lie below and left of high, and be 0.7 m away or more"
        for space in plan.spaces
        if min(space.high.x - space.low.x, space.high.y - space.low.y) < 0.7
    ]


def _check_doors(plan: FloorPlan, spaces: dict[str, Space]) -> list[str]:
    problems = []
    for door in plan.doors:
        unknown = [name for name in door.between if name not in spaces]
        problems += [
            f"door {door.name!r} leads to unknown space {name!r}.{did_you_mean(name, spaces)}"
            for name in unknown
        ]
        if not unknown and not all(
            contains(spaces[name], door.at, slack=0.3) for name in door.between
        ):
            one, other = door.between
            problems.append(f"door {door.name!r} is in no wall between {one!r} and {other!r}")
    return problems


def _check_places(plan: FloorPlan, spaces: dict[str, Space]) -> list[str]:
    problems = []
    for room, point in plan.places.items():
        if room not in spaces:
            problems.append(f"place {room!r} is in no space.{did_you_mean(room, spaces)}")
        elif not contains(spaces[room], point, slack=0.3):
            problems.append(f"the place of {room!r} lies outside of it")
    return problems


def _check_start(plan: FloorPlan) -> list[str]:
    if any(contains(space, plan.start) for space in plan.spaces):
        return []
    return [f"start ({plan.start.x:g}, {plan.start.y:g}) lies in no space"]
