"""The command that plays a whole day with many users."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from navigate.messages import Rooms
from rogue.cli._flags import ROBOT, RobotFlags
from rogue.cli._folders import make_folder
from rogue.memory import FILE_NAME, Difference, first_difference
from rogue.office import OfficeOptions
from rogue.requests import Directory, load_directory
from rogue.scenarios import (
    DayPlan,
    DayRecord,
    DayRun,
    Staff,
    counts,
    differences,
    faults,
    make_day,
    stage,
    verification,
)
from rogue.times import show_time
from tca_bus import ConfigError, TcaError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note, show_table

EPOCH = "1996-03-04T09:00:00"


class DayFailedError(TcaError):
    """A request did not end as it should, or the day went otherwise when it was played again."""


async def day(
    *,
    users: Annotated[int, Parameter(validator=Number(gte=1, lte=12))] = 10,
    requests: Annotated[int, Parameter(validator=Number(gte=1, lte=90))] = 60,
    hours: Annotated[float, Parameter(validator=Number(gt=0, lte=24))] = 2.0,
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 1,
    kills: Annotated[int, Parameter(validator=Number(gte=0, lte=100))] = 0,
    twice: Annotated[bool, Parameter(negative=())] = False,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    robot: RobotFlags = ROBOT,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Play a day with many users in an office of its own, and check how every request ended.

    Users post errands, urgent and impossible ones among them, take some back, doors are closed
    and opened, and one person in five does not answer. The same seed makes the same day. Prints
    how the requests of each kind ended and why; exit code 1 if one ended as it should not.

    Parameters
    ----------
    users
        How many people post requests.
    requests
        How many they post.
    hours
        Simulated hours in which they post them.
    seed
        Of the script and of everything random in the simulated world, 0 or more.
    kills
        Play the day once more, killing the planner so many times; it must end the same.
    twice
        Play the same day once more; all that the planner did and said must be the same to the tick.
    data
        Folder for what is kept, and for the logs; a temporary one if not given.
    robot
        What robot it is, and what it meets in the corridors.
    """
    numbers = {"users": users, "requests": requests, "hours": hours, "seed": seed}
    with tempfile.TemporaryDirectory(prefix="rogue-day-") as temporary:
        days = _Days(make_folder(data or Path(temporary)), numbers, robot, flags)
        first = await days.play()
        if twice:
            await days.repeat(first)
        if kills:
            await days.kill(first, kills)
    if flags.json:
        emit_json(days.report | {"wrong": days.wrong})
    if days.wrong:
        raise DayFailedError("; ".join(days.wrong))
    if not flags.json:
        emit("Every request ended as it should.")


_Played = tuple[DayPlan, DayRecord]


class _Days:
    """A day, and the same day again; ``wrong`` says what went otherwise than it should."""

    def __init__(
        self, folder: Path, numbers: dict[str, Any], robot: RobotFlags, flags: BusFlags
    ) -> None:
        self._folder, self._numbers, self._robot, self._flags = folder, numbers, robot, flags
        self.wrong: list[str] = []
        self.report: dict[str, Any] = {**numbers}

    async def play(self) -> _Played:
        """Play it undisturbed."""
        plan, record = await self._play("undisturbed")
        self.wrong += faults(plan, record)
        self.report["undisturbed"] = _document(plan, record)
        _show(plan, record, self._flags)
        return plan, record

    async def repeat(self, first: _Played) -> None:
        """Play it again; it must be the same to the tick."""
        _, again = await self._play("again")
        unlike = await _unlike(self._folder, first[1], again)
        self.wrong += unlike
        self.report["repeated"] = not unlike
        if not (unlike or self._flags.json):
            emit("The day was the same when it was played again, to the tick.\n")

    async def kill(self, first: _Played, kills: int) -> None:
        """Play it again and kill the planner so many times; it must end the same."""
        plan, again = await self._play("killed", kills=kills)
        self.wrong += faults(plan, again) + differences(plan, first[1], again)
        self.report |= {"killed": _document(plan, again), "kills": again.kills}
        _show(plan, again, self._flags)

    async def _play(self, name: str, *, kills: int = 0) -> _Played:
        folder = self._folder / name
        if (make_folder(folder) / FILE_NAME).exists():
            raise ConfigError("--data", str(folder), "a folder in which no office has run yet")
        console = sys.stderr if self._flags.verbose else None
        options = self._options(folder)
        async with stage(options, realm=self._flags.realm, console=console) as office:
            rooms = [one.room for one in await office.module.query(Rooms(), timeout=30.0)]
            plan = make_day(staff(load_directory()), rooms=rooms, **self._numbers)
            return plan, await DayRun(office, plan, kills=kills, progress=note).play()

    def _options(self, folder: Path) -> OfficeOptions:
        return OfficeOptions(
            data=folder,
            seed=self._numbers["seed"],
            speed="max",
            silence=0.0,
            epoch=EPOCH,
            log_level=self._flags.level,
            **vars(self._robot),
        )


async def _unlike(folder: Path, record: DayRecord, again: DayRecord) -> list[str]:
    """In what a day was another when it was played again, in words."""
    stores = (folder / name / FILE_NAME for name in ("undisturbed", "again"))
    if (found := await first_difference(*stores)) is not None:
        return [_told_apart(found)]
    return [] if record == again else ["played again, the world went another way"]


def _told_apart(difference: Difference) -> str:
    time = difference.time
    when = "" if time is None else f" at {show_time(time)}, {time:.1f} s"
    one, other = difference.one or "nothing", difference.other or "nothing"
    return f"played again, the day differs first in {difference.table}{when}: {one}, then {other}"


def staff(directory: Directory) -> Staff:
    """The people directory as the script needs it."""
    rooms = {user: person.room for user, person in directory.people.items() if person.room}
    errands = ((user, item) for user in rooms for item in directory.items)
    ends = {errand: _ends(directory, *errand) for errand in errands}
    return Staff(rooms=rooms, ends={errand: two for errand, two in ends.items() if two})


def _ends(directory: Directory, user: str, item: str) -> tuple[str, str] | None:
    """The two rooms of an errand; None where it has none, or only one."""
    pickup = directory.usual("pickup", user, item)
    deliver = directory.usual("deliver", user, item)
    if pickup is None or deliver is None or pickup.value == deliver.value:
        return None
    return pickup.value, deliver.value


def _show(plan: DayPlan, record: DayRecord, flags: BusFlags) -> None:
    if flags.json:
        return
    rows = [
        (kind.value, count, outcome)
        for kind, outcomes in sorted(counts(plan, record).items())
        for outcome, count in sorted(outcomes.items())
    ]
    show_table(("kind", "requests", "ended"), rows)
    emit("")
    reasons = [
        (post.id, post.kind.value, record.outcome(post.id), record.reason(post.id))
        for post in plan.posts
        if record.reason(post.id)
    ]
    show_table(("id", "kind", "ended", "reason"), reasons)
    killed = f", the planner killed {record.kills} times" if record.kills else ""
    emit(
        f"\nSimulated {record.seconds / 3600.0:.2f} h, driven {record.metres:.0f} m, "
        f"{len(record.handovers)} items handed over{killed}."
    )
    emit(f"{_verified(verification(record))}\n")


def _verified(found: Mapping[str, int]) -> str:
    """How arrivals were verified, in a sentence."""
    return (
        f"Arrivals: {found['belief']} made sure of by belief alone, {found['camera']} by the door "
        f"plate, {found['person']} by a person, {found['unsure']} not at all; "
        f"{found['elsewhere']} were at another room."
    )


def _document(plan: DayPlan, record: DayRecord) -> dict[str, Any]:
    return {
        "seconds": round(record.seconds, 1),
        "metres": round(record.metres, 1),
        "arrivals": verification(record),
        "requests": [
            {
                "id": post.id,
                "kind": post.kind.value,
                "ended": record.outcome(post.id),
                "reason": record.reason(post.id) or None,
            }
            for post in plan.posts
        ],
    }
