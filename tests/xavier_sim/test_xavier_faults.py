"""The battery and the faults, in the world and on the bus."""

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError
from test_xavier_bus import robot

from tca_bus import HandlerFailedError, Module
from tca_bus.testing import bus
from xavier_sim.body import Battery
from xavier_sim.floors import UnknownDoorError, load_floor
from xavier_sim.messages import Battery as BatteryNews
from xavier_sim.messages import (
    CameraPower,
    DoorMoved,
    Fault,
    Kidnap,
    LaserOffset,
    MoveDoor,
    ReadBattery,
    ReadPlate,
    Slip,
    SonarFault,
    WhereReally,
)
from xavier_sim.profile import MODERN, XAVIER, BatteryProfile
from xavier_sim.world import NotFreeError, World

PLAN = load_floor()
WEAK = BatteryProfile(standing_seconds=100.0, metres=10.0, charging_seconds=10.0)


def test_standing_and_driving_drain_the_battery_and_the_charger_fills_it():
    battery = Battery(WEAK)
    battery.use(0.0, 50.0, at_charger=False)
    assert battery.charge == pytest.approx(0.5)
    battery.use(3.5, 0.0, at_charger=False)
    assert (battery.charge, battery.low) == (pytest.approx(0.15), True)
    battery.use(3.5, 0.0, at_charger=False)
    assert (battery.charge, battery.empty) == (0.0, True)
    battery.use(0.0, 20.0, at_charger=True)
    assert (battery.charge, battery.charging, battery.low) == (1.0, True, False)


def test_an_empty_robot_stands_and_one_at_the_charger_recovers():
    world = World(PLAN, 1, XAVIER.model_copy(update={"battery": WEAK}))
    for _ in range(10):
        world.step(0.0, 0.0)
    assert world.robot.battery.charging
    world.place_robot(7.57, 19.0, math.pi / 2)
    world.robot.battery.charge = 0.01
    for _ in range(60):
        world.step(0.6, 0.0)
    assert world.robot.battery.empty
    assert world.reading.speed == pytest.approx(0.0, abs=1e-6)
    world.place_robot(PLAN.charger.x, PLAN.charger.y, 0.0)
    for _ in range(30):
        world.step(0.0, 0.0)
    assert not world.robot.battery.low


def test_a_kidnapped_robot_is_elsewhere_and_its_odometry_does_not_know():
    world = World(PLAN, seed=1)
    before = world.reading.odom.tolist()
    world.kidnap(*world.place_of("r-5305"))
    assert world.truth().room == "r-5305"
    assert world.step(0.0, 0.0).odom.tolist() == before
    with pytest.raises(UnknownDoorError):
        world.place_of("r-9999")
    for x, y, why in ((0.0, 0.0, "no space"), (6.37, 22.0, "a wall"), (6.37, 23.0, "a wall")):
        with pytest.raises(NotFreeError, match=why):
            world.kidnap(x, y)


def test_a_robot_is_put_beside_itself():
    world = World(PLAN, seed=1)
    world.place_robot(7.57, 20.0, math.pi / 2)
    world.kidnap(*world.robot.beside(3.597, 0.2))
    truth = world.truth()
    assert (truth.x, truth.y) == (pytest.approx(7.37), pytest.approx(23.597))
    assert truth.theta == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("metres", [-1.5, 1.5])
def test_slipping_wheels_count_wrongly_for_a_while(metres):
    sound, slips = World(PLAN, seed=1), World(PLAN, seed=1)
    slips.robot.slip(metres, 0.0)
    for _ in range(150):
        wrong, right = slips.step(0.5, 0.0), sound.step(0.5, 0.0)
    assert slips.robot.slipping == pytest.approx(0.0)
    assert slips.truth() == sound.truth()
    assert math.hypot(*wrong.odom[:2]) - math.hypot(*right.odom[:2]) == pytest.approx(
        metres, abs=0.01
    )


def test_faults_survive_a_snapshot():
    world, again = (World(PLAN, 1, XAVIER.model_copy(update={"battery": WEAK})) for _ in range(2))
    world.robot.slip(2.0, 0.0)
    world.robot.camera.is_on = False
    world.robot.battery.charge = 0.4
    again.restore(world.snapshot())
    assert again.robot.slipping == 2.0
    assert not again.robot.camera.is_on
    assert again.robot.battery.charge == 0.4


def test_a_snapshot_of_before_there_were_faults_is_restored():
    world, again = (World(PLAN, 1, XAVIER.model_copy(update={"battery": WEAK})) for _ in range(2))
    old = world.snapshot()
    old |= old.pop("robots")["xavier"]
    del old["camera"], old["battery"], old["odometry"]["slipping"]
    again.restore(old)
    assert again.snapshot() == world.snapshot()


@pytest.mark.parametrize(
    "fields", [{}, {"x": 1.0}, {"room": "r-5303", "x": 1.0, "y": 2.0}, {"room": "a", "left": 1.0}]
)
def test_a_kidnapping_names_one_place(fields):
    with pytest.raises(ValidationError, match=r"expected (both x and y|a room, or x)"):
        Kidnap(**fields)


@pytest.mark.bus
async def test_faults_doors_and_plates_on_the_bus():
    async with (
        bus() as options,
        robot(options),
        Module("asker", options=options) as asker,
        asker.subscribe(DoorMoved) as moved,
    ):
        await asker.wait_for(Fault, ReadPlate, ReadBattery, MoveDoor, timeout=10)
        state = await asker.query(Fault(fault=Kidnap(room="r-5305")))
        assert state.room == "r-5305" == (await asker.query(WhereReally())).room
        plate = await asker.query(ReadPlate())
        assert plate == await asker.query(ReadPlate())
        assert (await asker.query(Fault(fault=Slip(metres=-3.6)))).slip == -3.6
        assert not (await asker.query(Fault(fault=CameraPower(on=False)))).camera_on
        dead = SonarFault(number=5, state="dead")
        stuck = SonarFault(number=7, state="stuck", metres=1.5)
        for fault in (stuck, dead):
            state = await asker.query(Fault(fault=fault))
        assert state.sonars == (dead, stuck)
        sound = SonarFault(number=5, state="sound")
        assert (await asker.query(Fault(fault=sound))).sonars == (stuck,)
        knocked = LaserOffset(metres=0.1)
        assert (await asker.query(Fault(fault=knocked))).laser == knocked
        for message, name in (
            (ReadPlate(), "camera_gone"),
            (Fault(fault=Kidnap(room="r-5304x")), "unknown_room"),
            (Fault(fault=Kidnap(x=0.0, y=0.0)), "not_free"),
        ):
            with pytest.raises(HandlerFailedError) as caught:
                await asker.query(message)
            assert caught.value.failure.name == name
        assert (await asker.query(ReadBattery())).charge == 1.0
        for is_open in (True, False, False, True):
            await asker.query(MoveDoor(room="r-5307", open=is_open))
        assert [(await moved.get()).open for _ in range(2)] == [False, True]


@pytest.mark.bus
async def test_a_fault_of_a_sensor_that_is_not_there_is_refused():
    world = World(PLAN, 1, MODERN)
    async with (
        bus() as options,
        robot(options, world=world),
        Module("asker", options=options) as asker,
    ):
        await asker.wait_for(Fault, timeout=10)
        with pytest.raises(HandlerFailedError) as caught:
            await asker.query(Fault(fault=SonarFault(number=0, state="dead")))
        assert caught.value.failure.name == "no_sensor"


@pytest.mark.bus
async def test_the_battery_is_told_by_the_hundredth():
    world = World(PLAN, 1, XAVIER.model_copy(update={"battery": WEAK}))
    world.place_robot(7.57, 19.0, 0.0)
    async with (
        bus(clock="sim") as options,
        robot(options, world=world),
        Module("asker", options=options) as asker,
        asker.subscribe(BatteryNews) as news,
    ):
        await asker.clock.wait_ready(10)
        await asker.clock.sleep(5.0)
        charges = [(await news.get()).state.charge for _ in range(6)]
    assert [round(charge, 2) for charge in charges] == [1.0, 0.99, 0.98, 0.97, 0.96, 0.95]
