"""A survey of a floor: the same plan with the small metric errors that measuring makes."""

from __future__ import annotations

import math

import numpy as np
import yaml

from xavier_sim.floors._floor_checks import check_floor
from xavier_sim.floors._geometry import door_edge
from xavier_sim.messages import Corner, Door, FloorPlan, Space
from xavier_sim.noise import stream

DIGITS = 3
"""Survey results are rounded to millimetres."""


class Survey:
    """Draws one error for each wall line, so that what is in line stays in line.

    Args:
        sigma: standard deviation of the errors, metres.
        seed: of the errors.
    """

    def __init__(self, plan: FloorPlan, sigma: float, seed: int) -> None:
        self._plan, self._sigma = plan, sigma
        self._random = stream(seed, "survey")
        corners = [corner for space in plan.spaces for corner in (space.low, space.high)]
        self._xs = self._measure_lines({corner.x for corner in corners})
        self._ys = self._measure_lines({corner.y for corner in corners})

    def plan(self) -> FloorPlan:
        """The surveyed plan; places, start and charger keep their coordinates.

        Raises:
            FloorError: the errors are so large that the plan fell apart.
        """
        spaces = tuple(self._space(space) for space in self._plan.spaces)
        doors = tuple(self._door(door) for door in self._plan.doors)
        surveyed = self._plan.model_copy(update={"spaces": spaces, "doors": doors})
        check_floor(f"survey of {self._plan.name}", surveyed)
        return surveyed

    def _measure_lines(self, lines: set[float]) -> dict[float, float]:
        return {line: round(line + self._error(), DIGITS) for line in sorted(lines)}

    def _error(self) -> float:
        return self._sigma * float(np.clip(self._random.standard_normal(), -2.5, 2.5))

    def _space(self, space: Space) -> Space:
        low = Corner(x=self._xs[space.low.x], y=self._ys[space.low.y])
        high = Corner(x=self._xs[space.high.x], y=self._ys[space.high.y])
        return space.model_copy(update={"low": low, "high": high})

    def _door(self, door: Door) -> Door:
        spaces = {space.name: space for space in self._plan.spaces}
        edge = door_edge(door, spaces)
        error = self._error()
        if edge is not None and edge.axis == "x":
            at = Corner(x=self._xs[edge.at], y=round(door.at.y + error, DIGITS))
        else:
            at = Corner(x=round(door.at.x + error, DIGITS), y=self._ys[door.at.y])
        return door.model_copy(update={"at": at})


def survey_floor(plan: FloorPlan, *, sigma: float, seed: int) -> FloorPlan:
    """Survey a floor: walls and doors off by some centimetres, places where they are."""
    return Survey(plan, sigma, seed).plan()


def plan_to_yaml(plan: FloorPlan) -> str:
    """A plan as YAML text with one line for each space, door and place."""
    lines = [f"name: {_text(plan.name)}", "spaces:"]
    lines += [
        f"  - {{name: {_text(s.name)}, kind: {s.kind.value}, low: {_corner(s.low)}, "
        f"high: {_corner(s.high)}}}"
        for s in plan.spaces
    ]
    lines += ["doors:" if plan.doors else "doors: []"]
    lines += [
        f"  - {{name: {_text(d.name)}, "
        f"between: [{_text(d.between[0])}, {_text(d.between[1])}], "
        f"at: {_corner(d.at)}, width: {d.width!r}}}"
        for d in plan.doors
    ]
    lines += ["places:" if plan.places else "places: {}"]
    lines += [f"  {_text(name)}: {_corner(point)}" for name, point in plan.places.items()]
    lines += [f"start: {_corner(plan.start)}", f"start_heading: {plan.start_heading!r}"]
    lines += [f"charger: {_corner(plan.charger)}"] if plan.charger else []
    return "\n".join(lines) + "\n"


def _text(text: str) -> str:
    """A name as YAML takes it for one: in quotes where it would be a number or a truth value."""
    dumped: str = yaml.safe_dump(text, width=math.inf, allow_unicode=True)
    return dumped.removesuffix("\n").removesuffix("\n...")


def _corner(corner: Corner) -> str:
    return f"{{x: {corner.x!r}, y: {corner.y!r}}}"
