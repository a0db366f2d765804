"""IR-SIM: Python and numpy, worlds from YAML; each wall is an obstacle of its own."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from simulators.base import (
    BARE,
    FURNISHED,
    LIDAR_NOISE,
    LIDAR_RANGE,
    PERIOD,
    RADIUS,
    SONAR_RANGE,
    SONAR_RAYS,
    SPEED,
    START,
    STRIPER_BEAMS,
    STRIPER_RANGE,
    STRIPER_VIEW,
    TURN,
    Simulator,
)

ROUND = 2 * np.pi


class IrSim(Simulator):
    """The world alone, with a lidar."""

    title, group, package = "IR-SIM", "lidar", "irsim"
    eyes = ((LIDAR_RANGE, ROUND, BARE.beams),)

    def __init__(self, robots: int) -> None:
        super().__init__(robots)
        self._env = _quietly(self._document())
        self._actions = [np.array([[SPEED], [TURN]])] * robots

    def tick(self) -> None:
        self._env.step(self._actions)

    def ranges(self) -> np.ndarray:
        return np.asarray(self._env.robot_list[0].get_lidar_scan()["ranges"])

    def _document(self) -> dict[str, Any]:
        low, high = self.setting.walls.min(axis=0), self.setting.walls.max(axis=0)
        return {
            "world": {
                "width": float(high[2] - low[0]) + 10.0,
                "height": float(high[3] - low[1]) + 10.0,
                "offset": [float(low[0]) - 5.0, float(low[1]) - 5.0],
                "step_time": PERIOD,
                "sample_time": PERIOD,
                "collision_mode": "stop",
            },
            "robot": [self._robot(number) for number in range(self.robots)],
            "obstacle": [
                {"shape": {"name": "linestring", "vertices": [[a, b], [c, d]]}, "state": [0, 0, 0]}
                for a, b, c, d in self.setting.walls.tolist()
            ],
        }

    def _robot(self, number: int) -> dict[str, Any]:
        x, y = START[number]
        return {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": RADIUS},
            "state": [x, y, 0.0],
            "goal": [*START[(number + 7) % len(START)], 0.0],
            "sensors": [
                {
                    "name": "lidar2d",
                    "range_max": reach,
                    "angle_range": view,
                    "number": beams,
                    "noise": True,
                    "std": LIDAR_NOISE,
                }
                for reach, view, beams in self.eyes
            ],
        }


class IrSimFurnished(IrSim):
    """The same among furniture."""

    group, setting = "furnished", FURNISHED
    eyes = ((LIDAR_RANGE, ROUND, FURNISHED.beams),)


class IrSimLoop(IrSim):
    """As many rays as our cones and striper have, and its *dash* behaviour: straight on."""

    title, group = "IR-SIM, dash behaviour", "loop"
    eyes = ((SONAR_RANGE, ROUND, SONAR_RAYS), (STRIPER_RANGE, STRIPER_VIEW, STRIPER_BEAMS))

    def tick(self) -> None:
        self._env.step()

    def _robot(self, number: int) -> dict[str, Any]:
        return {**super()._robot(number), "behavior": {"name": "dash"}}


def _quietly(document: dict[str, Any]) -> Any:
    """The environment of a document, without a window and without its log."""
    os.environ["MPLBACKEND"] = "Agg"
    with (
        tempfile.TemporaryDirectory() as folder,
        Path(os.devnull).open("w", encoding="utf-8") as nowhere,
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
    ):
        import irsim  # noqa: PLC0415 -- not always there, and slow

        file = Path(folder) / "floor.yaml"
        file.write_text(yaml.safe_dump(document))
        return irsim.make(str(file), display=False, headless=True, log_level="ERROR")
