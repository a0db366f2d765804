"""Drives that come to nothing in spite of every recovery: held at a door, touched at each try."""

from __future__ import annotations

import pytest
from navigate_loop import Loop

from navigate.driving import STOP
from navigate.driving._view import Bumped, Stuck
from navigate.messages import NavigationFailure

COMES, STAYS = 140, 139
"""Ticks after which somebody comes anew, and for which they stay before the robot."""


class Held(Loop):
    """A robot in a door, and somebody before it who steps aside for a tick now and then."""

    ticks = troubles = 0
    is_held = False

    def tick(self):
        wheels, drive = self.navigator.wheels, self.navigator.driver.drive
        if len(drive.troubles) > self.troubles:
            self.troubles, self.is_held = len(drive.troubles), False
        self.is_held |= wheels.narrow and wheels.speed > 0.0
        self.world.step(wheels.speed, wheels.turn)
        self.sensors = self.robot.sensors()
        if self.is_held:
            self._step_in_the_way()
        self.navigator.step(self.sensors)

    def _step_in_the_way(self):
        self.ticks += 1
        if self.ticks % COMES < STAYS:
            sonar = self.sensors.sonar.copy()
            sonar[0] = 0.3 + 0.01 * (self.ticks % 3)
            fresh = self.sensors.sonar_fresh | 1
            self.sensors = self.sensors.model_copy(update={"sonar": sonar, "sonar_fresh": fresh})


def test_held_at_a_door_again_and_again_it_gives_up_as_no_progress():
    loop = Held(seed=1)
    drive = loop.drive("r-5303", most=4000)
    assert drive.failure.reason is NavigationFailure.NO_PROGRESS
    assert drive.failure.text == "came no nearer for 75 s, for the 3. time on this drive"
    assert [type(met) for met in drive.troubles] == [Stuck] * 3
    report = loop.navigator.report(drive)
    assert (report.outcome, report.recoveries) == ("no_progress", 2)
    assert report.seconds > 3 * 75.0
    assert loop.navigator.doors.doors["d-5303"].given_up == 1
    assert loop.navigator.wheels == STOP
    assert loop.world.truth().bumps == 0


def test_held_at_a_door_once_it_turns_and_gets_through():
    loop = Held(seed=1)
    loop.start("r-5303")
    drive = loop.navigator.driver.drive
    while not drive.troubles:
        loop.tick()
    loop._step_in_the_way = lambda: None
    while not drive.done:
        loop.tick()
    assert drive.failure is None
    assert isinstance(drive.troubles[0], Stuck)
    assert loop.off("r-5303") < 0.25


class Touched(Loop):
    """A robot one of whose bump panels is pressed: always, or once more whenever it drives on."""

    def __init__(self, panel, *, always):
        self.panel, self.always = panel, always
        super().__init__(seed=1)

    def tick(self):
        wheels = self.navigator.wheels
        self.world.step(wheels.speed, wheels.turn)
        self.sensors = self.robot.sensors()
        if self.always or self.world.reading.speed > 0.2:
            self.sensors = self.sensors.model_copy(update={"bump": 1 << self.panel})
        self.navigator.step(self.sensors)


@pytest.mark.parametrize("always", [True, False])
@pytest.mark.parametrize("panel", [0, 7])
def test_touched_at_each_try_it_gives_up_as_bump(panel, always):
    loop = Touched(panel, always=always)
    drive = loop.drive("r-5303", most=2000)
    assert drive.failure.reason is NavigationFailure.BUMP
    assert drive.failure.text.endswith("for the 7. time on this drive")
    assert sum(isinstance(met, Bumped) for met in drive.troubles) == 7
    report = loop.navigator.report(drive)
    assert (report.outcome, report.recoveries) == ("bump", 6)
    assert loop.navigator.wheels == STOP
