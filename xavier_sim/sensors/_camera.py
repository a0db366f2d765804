"""The camera on its pan-tilt head: reads the plates beside the doors.

Every door has its room's number on both faces of the wall, beside the frame. A plate is read
from near and not too much askance; the nearer and the more frontal, the surer. A reader that
takes one digit for another says how sure it is, and its word is good: of the readings with
confidence c, about a share c is right.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from xavier_sim.floors import Geometry
from xavier_sim.noise import stream
from xavier_sim.profile import CameraProfile

BESIDE_FRAME = 0.15
"""Metres from a door's frame to the middle of its plates."""

LOOK_ALIKES = {
    "0": "8", "1": "7", "2": "7", "3": "8", "4": "1",
    "5": "6", "6": "5", "7": "1", "8": "3", "9": "0",
}  # fmt: skip
"""What a digit is taken for when it is misread."""

Sight = Callable[[float, float], bool]
"""Whether nothing stands between the robot and a point in metres."""


@dataclass(frozen=True)
class Plate:
    """A door plate: its text, its middle in metres, and the unit normal of its face."""

    text: str
    x: float
    y: float
    normal_x: float
    normal_y: float


@dataclass(frozen=True)
class View:
    """How a plate is seen: metres off, and radians between its normal and the line of sight."""

    plate: Plate
    distance: float
    askance: float


@dataclass(frozen=True)
class Look:
    """What a look gives: the text, None for nothing, and the confidence in it, 0 to 1."""

    text: str | None
    confidence: float


NOTHING = Look(None, 0.0)


def door_plates(geometry: Geometry) -> list[Plate]:
    """Two plates for each door, one on either face of its wall.

    They hang on the side of the frame where the wall is longer.
    """
    plates, walls = [], geometry.walls.tolist()
    for segment, room in zip(geometry.doors, geometry.door_rooms, strict=True):
        x0, y0, x1, y1 = (float(value) for value in segment)
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        sides = [(x0 - ux * BESIDE_FRAME, y0 - uy * BESIDE_FRAME)]
        sides.append((x1 + ux * BESIDE_FRAME, y1 + uy * BESIDE_FRAME))
        x, y = max(sides, key=lambda side: _wall_beside(walls, side))
        plates += [Plate(room, x, y, nx, ny) for nx, ny in ((-uy, ux), (uy, -ux))]
    return plates


class Camera:
    """Looks round for a plate; the same tick and place give the same look.

    Args:
        geometry: of the floor whose doors have plates.
        profile: how well it sees.
        seed: of its errors.
    """

    def __init__(self, geometry: Geometry, profile: CameraProfile, seed: int) -> None:
        self._plates = door_plates(geometry)
        self._profile, self._seed = profile, seed
        self.is_on = True

    def look(self, x: float, y: float, theta: float, tick: int, sight: Sight) -> Look:
        """Read the plate that is seen best from a pose, in metres and radians."""
        seen = [view for plate in self._plates if (view := self._view(plate, x, y, theta))]
        seen.sort(key=self._badness)
        view = next((one for one in seen if sight(one.plate.x, one.plate.y)), None)
        return NOTHING if view is None else self._read(view, tick)

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"seed": self._seed, "on": self.is_on}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self._seed, self.is_on = state["seed"], state["on"]

    def _view(self, plate: Plate, x: float, y: float, theta: float) -> View | None:
        profile = self._profile
        dx, dy = x - plate.x, y - plate.y
        distance = math.hypot(dx, dy)
        if not profile.nearest <= distance <= profile.farthest:
            return None
        askance = math.acos((dx * plate.normal_x + dy * plate.normal_y) / distance)
        pan = abs(math.remainder(math.atan2(-dy, -dx) - theta, math.tau))
        if askance > profile.most_askance or pan > profile.pan:
            return None
        return View(plate, distance, askance)

    def _badness(self, view: View) -> float:
        """How hard a plate is to read, 0 for near and frontal to 2."""
        profile = self._profile
        far = (view.distance - profile.nearest) / (profile.farthest - profile.nearest)
        return float(far**2 + (view.askance / profile.most_askance) ** 2)

    def _read(self, view: View, tick: int) -> Look:
        draw = stream(self._seed, f"camera {tick}")
        profile, badness = self._profile, self._badness(view)
        if draw.random() < profile.blank + profile.blank_growth * badness:
            return NOTHING
        base = profile.misread + profile.misread_growth * badness
        misread = min(0.5, base * float(draw.exponential()))
        confidence = round(1.0 - misread, 3)
        if draw.random() >= misread:
            return Look(view.plate.text, confidence)
        return Look(_mistake(view.plate.text, float(draw.random())), confidence)


def _mistake(text: str, share: float) -> str:
    """A text with one of its last two digits taken for another."""
    digits = [place for place, sign in enumerate(text) if sign in LOOK_ALIKES][-2:]
    if not digits:
        return text[:-1]
    place = digits[int(share * len(digits))]
    return text[:place] + LOOK_ALIKES[text[place]] + text[place + 1 :]


def _wall_beside(walls: list[list[float]], point: tuple[float, float]) -> float:
    """The length of the wall that holds a point, 0.0 where there is none."""
    return max((_length(wall) for wall in walls if _holds(wall, point)), default=0.0)


def _length(wall: list[float]) -> float:
    return math.dist(wall[:2], wall[2:])


def _holds(wall: list[float], point: tuple[float, float]) -> bool:
    around = math.dist(wall[:2], point) + math.dist(point, wall[2:])
    return around - _length(wall) < 1e-6
