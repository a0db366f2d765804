"""The robot of today, two wheels and a lidar, driven by the navigator that Xavier has."""

from __future__ import annotations

from navigate_loop import Loop

from xavier_sim.profile import MODERN


def test_it_drives_from_room_to_room():
    loop = Loop(seed=4, profile=MODERN)
    loop.drive("r-5303")
    assert loop.world.truth().space == "r-5303"
    drive = loop.drive("r-5307")
    assert drive.failure is None
    assert drive.metres > 7.0
    assert loop.off("r-5307") < 0.5
    assert loop.astray() < 0.25
    assert loop.world.truth().space == "r-5307"
    assert loop.navigator.position().room == "r-5307"
    assert loop.world.truth().bumps == 0


def test_it_waits_before_a_shut_door_and_gives_up():
    loop = Loop(seed=1, profile=MODERN)
    loop.world.set_door("r-5303", is_open=False)
    drive = loop.drive("r-5303")
    assert drive.failure.reason == "door_blocked"
    assert loop.navigator.report(drive).door == "r-5303"
    assert loop.world.truth().bumps == 0
