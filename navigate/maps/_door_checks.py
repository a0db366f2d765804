"""What the doors of a map must fulfil: two spaces, a wall between them, a gap of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations

from navigate.maps._floor import inset
from navigate.maps._problems import SLACK, problem
from navigate.maps._walls import TOUCH, Passage, doorway
from tca_bus import did_you_mean
from xavier_sim.messages import Door, Space


def check_doors(doors: Iterable[Door], spaces: dict[str, Space]) -> list[str]:
    """List what is wrong with each door by itself."""
    return [found for door in doors for found in _check_door(door, spaces)]


def check_gaps(doors: Iterable[Door], spaces: dict[str, Space]) -> list[str]:
    """List the sound doors that are where another one is."""
    passages = [doorway(door, spaces) for door in doors]
    return [
        problem(
            f"door {other.name!r}: at", _point(*other.centre), f"a point beside door {one.name!r}"
        )
        for one, other in combinations(passages, 2)
        if _share_gap(one, other)
    ]


def _check_door(door: Door, spaces: dict[str, Space]) -> Iterator[str]:
    if door.name in spaces:
        yield problem("name of a door", door.name, "a name that no space has")
    item, (one, other) = f"door {door.name!r}: between", door.between
    unknown = [name for name in door.between if name not in spaces]
    for name in unknown:
        yield problem(item, name, f"the name of a space.{did_you_mean(name, spaces)}")
    if one == other:
        yield problem(item, f"{one}, {other}", "two different spaces")
    elif not unknown:
        yield from _check_wall(door, spaces)


def _check_wall(door: Door, spaces: dict[str, Space]) -> Iterator[str]:
    """The middle of a door and both its ends are where both of its spaces are."""
    one, other = door.between
    at = (door.at.x, door.at.y)
    if not _are_in_both(door, [at], spaces):
        expected = f"a point of the wall between {one!r} and {other!r}"
        yield problem(f"door {door.name!r}: at", _point(*at), expected)
    elif not _are_in_both(door, doorway(door, spaces).jambs, spaces):
        expected = f"one with which the door at {_point(*at)} ends within the wall between "
        yield problem(
            f"door {door.name!r}: width", f"{door.width:g}", f"{expected}{one!r}, {other!r}"
        )


def _are_in_both(
    door: Door, points: Iterable[tuple[float, float]], spaces: Mapping[str, Space]
) -> bool:
    both = [spaces[name] for name in door.between]
    return all(inset(space, x, y) >= -SLACK for x, y in points for space in both)


def _share_gap(one: Passage, other: Passage) -> bool:
    """Whether two doors take more of one wall than a survey can be off."""
    across = 0 if one.normal[0] else 1
    if bool(one.normal[0]) != bool(other.normal[0]):
        return False
    apart = abs(one.centre[1 - across] - other.centre[1 - across])
    in_line = abs(one.centre[across] - other.centre[across]) < TOUCH
    return in_line and (one.width + other.width) / 2 - apart > SLACK


def _point(x: float, y: float) -> str:
    return f"({x:g}, {y:g})"
