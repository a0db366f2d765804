"""The steps that were carried out, and how far the open one came."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rogue.memory._database import Database, Row
from rogue.memory._facts import write_room, write_things
from rogue.memory._holds import Hold, write_holds
from rogue.memory._requests import write_change, write_course
from rogue.messages import DeliveryRequest, StepView
from rogue.outcomes import Outcome, StepOutcome


@dataclass(frozen=True, slots=True)
class Step:
    """One operator that is carried out; ``requests`` are the ids of those that it serves."""

    number: int
    operator: str
    arguments: tuple[str, ...]
    requests: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PastStep:
    """A step that has ended, and what came of it."""

    operator: str
    arguments: tuple[str, ...]
    outcome: StepOutcome


@dataclass(frozen=True, slots=True)
class TimedStep:
    """A step that has ended: how long it took, in seconds, and where the robot was then."""

    operator: str
    seconds: float
    room: str | None
    is_done: bool


class KeptSteps:
    """The part of the store that holds steps and the outcomes of their effects."""

    _base: Database

    async def begin_step(
        self,
        operator: str,
        arguments: Sequence[str],
        requests: Iterable[DeliveryRequest],
        time: float,
    ) -> Step | None:
        """Write down a step before it starts, with the requests that it serves as they are then.

        Gives None, and nothing is begun, when all that there are have ended meanwhile.
        """
        served = list(requests)
        ids = tuple(request.id for request in served)
        async with self._base.transaction() as link:
            changes = [await write_change(link, request, None) for request in served]
            if changes and not any(changes):
                return None
            cursor = await link.execute(
                "INSERT INTO steps (operator, arguments, requests, state, started) "
                "VALUES (?, ?, ?, 'open', ?)",
                (operator, json.dumps(arguments), json.dumps(ids), time),
            )
            number = int(cursor.lastrowid or 0)
            pairs = [(name, number) for name in ids]
            await link.executemany("INSERT INTO served (request, step) VALUES (?, ?)", pairs)
        return Step(number, operator, tuple(arguments), ids)

    async def open_step(self) -> Step | None:
        """The step that was begun and not ended, if there is one."""
        rows = await self._base.rows(
            "SELECT number, operator, arguments, requests FROM steps WHERE state = 'open' "
            "ORDER BY number DESC LIMIT 1"
        )
        return _step(rows[0]) if rows else None

    async def end_step(
        self,
        step: Step,
        outcome: StepOutcome,
        time: float,
        *,
        changed: Iterable[DeliveryRequest] = (),
        holds: Iterable[Hold] = (),
    ) -> list[DeliveryRequest]:
        """Close a step together with what it changed in the world and for the requests.

        ``holds`` are the errands that are put off for it. Gives those of ``changed`` that had
        not ended already, by somebody else's hand.
        """
        async with self._base.transaction() as link:
            await link.execute(
                "UPDATE steps SET state = ?, outcome = ?, ended = ? WHERE number = ?",
                (outcome.kind, outcome.model_dump_json(), time, step.number),
            )
            await link.execute("DELETE FROM outcomes WHERE step = ?", (step.number,))
            await write_room(link, outcome.room)
            await write_things(link, outcome.placed, outcome.gone)
            await write_holds(link, holds)
            written = [r for r in changed if await write_change(link, r, r.reason)]
            for request in written:
                await write_course(link, request, time)
            return written

    async def steps_of(self, request_id: str) -> list[StepView]:
        """What was carried out for a request."""
        rows = await self._base.rows(
            "SELECT operator, arguments, state, started, ended, outcome FROM served "
            "JOIN steps ON steps.number = served.step WHERE served.request = ? ORDER BY number",
            request_id,
        )
        return [_view(row) for row in rows]

    async def past_of(self, request_id: str) -> list[PastStep]:
        """The steps that were ended for a request, the oldest first, and what came of each."""
        rows = await self._base.rows(
            "SELECT operator, arguments, outcome FROM served JOIN steps "
            "ON steps.number = served.step "
            "WHERE served.request = ? AND outcome IS NOT NULL ORDER BY number",
            request_id,
        )
        return [
            PastStep(
                str(operator), tuple(json.loads(args)), StepOutcome.model_validate_json(outcome)
            )
            for operator, args, outcome in rows
        ]

    async def last_ended(self, operator: str) -> float | None:
        """When a step of that operator ended last, None if none ever did."""
        found = await self._base.row("SELECT max(ended) FROM steps WHERE operator = ?", operator)
        return found[0] if found else None

    async def timed_steps(self, most: int) -> list[TimedStep]:
        """The latest steps that have ended, the oldest first."""
        rows = await self._base.rows(
            "SELECT operator, ended - started, json_extract(outcome, '$.room'), state FROM steps "
            "WHERE ended IS NOT NULL ORDER BY number DESC LIMIT ?",
            most,
        )
        return [
            TimedStep(str(operator), float(seconds), room, state == "done")
            for operator, seconds, room, state in rows[::-1]
        ]

    async def keep_outcome(self, step: Step, position: int, outcome: Outcome) -> None:
        """Keep what came of effect number ``position`` of an open step."""
        async with self._base.transaction() as link:
            await link.execute(
                "INSERT OR REPLACE INTO outcomes (step, position, outcome) VALUES (?, ?, ?)",
                (step.number, position, outcome.model_dump_json()),
            )

    async def outcomes(self, step: Step) -> dict[int, Outcome]:
        """What came of the effects of an open step so far, by their positions."""
        rows = await self._base.rows(
            "SELECT position, outcome FROM outcomes WHERE step = ?", step.number
        )
        return {int(position): Outcome.model_validate_json(text) for position, text in rows}


def _step(row: Row) -> Step:
    number, operator, arguments, requests = row
    return Step(int(number), operator, tuple(json.loads(arguments)), tuple(json.loads(requests)))


def _view(row: Row) -> StepView:
    operator, arguments, state, started, ended, outcome = row
    came_of_it = StepOutcome.model_validate_json(outcome) if outcome else None
    return StepView(
        operator=f"{operator} {' '.join(json.loads(arguments))}",
        state=state,
        started=started,
        ended=ended,
        outcome=came_of_it.reason if came_of_it else None,
        arrivals=came_of_it.arrivals if came_of_it else (),
    )
