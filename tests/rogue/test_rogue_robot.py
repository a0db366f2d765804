"""The robot over the bus, with a bus that fails as told."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from rogue_fakes import FakeModule

from navigate.messages import NavigateToGoal, RoomLocation
from rogue.execution import AwaitCharge, BusRobot, Endurance, Locate, Urgency
from rogue.outcomes import Outcome
from tca_bus import (
    BusGoneError,
    Failure,
    HandlerFailedError,
    KilledError,
    NoHandlerError,
    TaskFailedError,
    TimedOutError,
)
from tca_bus.testing import ManualClock
from xavier_sim.messages import BatteryState, Say, Spoken

QUICK = Endurance(absence=0.2, interval=0.0, lost_times=3)
SAY = Say(text="Good morning.")
SPOKEN = Spoken(text="Good morning.", time=1.0)


class Handle:
    def __init__(self, result: object) -> None:
        self._result = result

    async def result(self) -> object:
        if isinstance(self._result, Exception):
            raise self._result
        return self._result


class ScriptedModule(FakeModule):
    """Each submission or query takes the next of ``script``: an error, or an outcome."""

    def __init__(self, *script: object) -> None:
        super().__init__()
        self.script = list(script)
        self.submitted: list[tuple[str, str]] = []
        self.killed: list[str] = []

    async def execute(self, message: object, *, id: str, **options: object) -> Handle:
        return self._submit("execute", id, options)

    async def expand(self, message: object, *, id: str, **options: object) -> Handle:
        return self._submit("expand", id, options)

    async def query(self, message: object) -> object:
        return self._next()

    async def kill(self, task_id: str, *, reason: str) -> object:
        self.killed.append(task_id)
        return self._next()

    def _submit(self, how: str, task_id: str, options: dict[str, object]) -> Handle:
        self.options = options
        self.submitted.append((how, task_id))
        return self._next()

    def _next(self) -> object:
        following = self.script.pop(0) if len(self.script) > 1 else self.script[0]
        if isinstance(following, Exception):
            raise following
        return following


def failure(name: str) -> Handle:
    return Handle(TaskFailedError("t", Failure(name=name, text=f"it was {name}")))


async def test_goals_are_expanded_and_commands_executed():
    module = ScriptedModule(Handle(SPOKEN))
    robot = BusRobot(module, QUICK)
    assert (await robot.perform("s-1.2", SAY)).value == SPOKEN.model_dump()
    await robot.perform("s-1.3", NavigateToGoal(x=1, y=2))
    assert module.submitted == [("execute", "s-1.2"), ("expand", "s-1.3")]


async def test_tasks_carry_the_priority_of_the_errand_and_drives_its_deadline():
    module = ScriptedModule(Handle(SPOKEN))
    robot = BusRobot(module, QUICK)
    urgency = Urgency(priority=8, deadline=module.clock.now() + 90.0)
    await robot.perform("s-1.2", SAY, urgency)
    assert module.options["priority"] == 8
    assert "within" not in module.options
    await robot.perform("s-1.3", NavigateToGoal(x=1, y=2), urgency)
    assert (module.options["priority"], module.options["within"]) == (8, 90.0)


async def test_a_task_is_killed_with_all_its_attempts_that_there_were():
    unknown = HandlerFailedError(Failure(name="unknown_task", text="there is no such task"))
    stopping, ended = SimpleNamespace(is_ended=False), SimpleNamespace(is_ended=True)
    module = ScriptedModule(stopping, ended, ended, unknown)
    await BusRobot(module, QUICK).kill("s-1.3", "nobody wants it any more")
    assert module.killed == ["s-1.3", "s-1.3", "s-1.3.r1", "s-1.3.r2"]


async def test_a_task_whose_module_died_is_begun_anew_under_the_next_id():
    module = ScriptedModule(failure("module_lost"), failure("module_lost"), Handle(SPOKEN))
    outcome = await BusRobot(module, QUICK).perform("s-1.2", SAY)
    assert not outcome.failed
    assert [task for _, task in module.submitted] == ["s-1.2", "s-1.2.r1", "s-1.2.r2"]


async def test_a_module_that_always_dies_is_given_up():
    outcome = await BusRobot(ScriptedModule(failure("module_lost")), QUICK).perform("s", SAY)
    assert outcome.failure == "module_lost"


async def test_what_is_away_for_a_moment_is_waited_for_under_the_same_id():
    away = [NoHandlerError("C_say"), BusGoneError("tcp/x:1"), TimedOutError("central", 10.0)]
    module = ScriptedModule(*away, Handle(SPOKEN))
    assert not (await BusRobot(module, QUICK).perform("s", SAY)).failed
    assert [task for _, task in module.submitted] == ["s"] * 4


@pytest.mark.parametrize(
    ("script", "name"),
    [
        (failure("no_answer"), "no_answer"),
        (Handle(KilledError("s", "by hand")), "killed"),
        (NoHandlerError("C_say"), "no_handler"),
        (BusGoneError("tcp/127.0.0.1:1"), "bus_gone"),
    ],
)
async def test_every_other_end_has_its_name(script: object, name: str):
    outcome = await BusRobot(ScriptedModule(script), QUICK).perform("s", SAY)
    assert outcome.failure == name
    assert outcome.text


async def test_rooms_are_asked_for_and_refusals_come_through():
    location = RoomLocation(room="r-5303", x=567.0, y=2316.5)
    robot = BusRobot(ScriptedModule(location), QUICK)
    assert (await robot.locate(Locate("r-5303"))).value == location.model_dump()
    refused = HandlerFailedError(Failure(name="unknown_room", text="there is no room"))
    robot = BusRobot(ScriptedModule(refused), QUICK)
    assert (await robot.locate(Locate("r-1"))).failure == "unknown_room"


def battery(charge: float, *, charging: bool) -> BatteryState:
    return BatteryState(charge=charge, low=True, charging=charging, charger=None, time=0.0)


class QuickClock(ManualClock):
    async def sleep_until(self, when: float) -> None:
        self.move_to(when)


async def charge(*states: BatteryState) -> tuple[Outcome, float]:
    module = ScriptedModule(*states)
    module.clock = QuickClock()
    outcome = await BusRobot(module, QUICK).await_charge(AwaitCharge(0.8))
    return outcome, module.clock.now()


async def test_the_robot_stands_at_the_charger_until_its_battery_is_full_enough():
    states = [battery(0.1, charging=False), *(battery(c, charging=True) for c in (0.5, 0.8))]
    outcome, seconds = await charge(*states)
    assert not outcome.failed
    assert seconds == 60.0


async def test_a_charger_that_gives_nothing_is_left():
    outcome, _ = await charge(battery(0.1, charging=False))
    assert outcome.failure == "not_charging"
