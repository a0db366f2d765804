"""Whether a chaos run kept its promises: a pure function of what was seen."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from chaos_crew import DROPPED
from chaos_ledger import Deed, Entry
from chaos_plan import PlannedTask
from chaos_record import Record, Told

from tca_bus._protocol import ENDED


@dataclass(frozen=True)
class Promise:
    """What a policy for the loss of a module allows."""

    may_be_lost: bool
    may_be_tried_again: bool


PROMISES = {
    "fail": Promise(may_be_lost=True, may_be_tried_again=False),
    "resend": Promise(may_be_lost=False, may_be_tried_again=True),
    "hold": Promise(may_be_lost=False, may_be_tried_again=True),
}

CAUSED_BELOW = {"child_failed", "killed", DROPPED, "module_lost"}
"""What a goal may fail with when a child of it came to grief."""


def broken_promises(record: Record) -> list[str]:
    """Every promise that the run broke, in words; empty when it kept all."""
    return [
        *_unended(record),
        *_ended_otherwise(record),
        *_ended_twice(record),
        *_wrong_outcomes(record),
        *_attempts(record),
        *_unearned(record),
        *_overlaps(record),
    ]


def _unended(record: Record) -> Iterator[str]:
    for task in record.plan.tasks:
        if task.id not in record.acknowledged:
            yield f"{task.id} was never acknowledged"
        elif task.id not in record.told:
            yield f"{task.id} was acknowledged and did not end: {record.unended.get(task.id, '?')}"


def _ended_otherwise(record: Record) -> Iterator[str]:
    """The sender, the last state that central gives and the journal agree."""
    for id, told in record.told.items():
        final = record.final.get(id)
        if final is None:
            yield f"{id} is not known to central after its end"
        elif final.state != told.state:
            yield f"{id}: the sender was told {told.state}, central says {final.state}"
    for id, statuses in record.published.items():
        ends = {status.state for status in statuses if status.state in ENDED}
        if len(ends) > 1:
            yield f"{id} was published as {' and as '.join(sorted(ends))}"


def _ended_twice(record: Record) -> Iterator[str]:
    """The journal has one beginning and one end of each task, children included."""
    submitted = Counter(line.task for line in record.log if line.event == "submitted")
    ends = Counter(line.task for line in record.log if line.event in set(ENDED))
    for id, count in submitted.items():
        if count != 1:
            yield f"{id} was journaled as submitted {count} times"
        if ends[id] != 1:
            yield f"{id} ended {ends[id]} times in the journal"
    for id in record.acknowledged:
        if submitted[id] != 1:
            yield f"{id} was acknowledged but is not in the journal"


def _wrong_outcomes(record: Record) -> Iterator[str]:
    for task in record.plan.tasks:
        told = record.told.get(task.id)
        if told is not None and not _is_allowed(task, told):
            why = f"{told.state} {told.failure}".strip()
            yield f"{task.id} ({task.policy}) must not end as {why}: {task}"


def _is_allowed(task: PlannedTask, told: Told) -> bool:
    if told.state == "killed":
        return task.killed_after is not None
    if told.state == "failed":
        return told.failure in _allowed_failures(task)
    return not task.fails or (task.is_goal and task.lenient)


def _allowed_failures(task: PlannedTask) -> set[str]:
    allowed = {"module_lost"} if PROMISES[task.policy].may_be_lost else set()
    child_may_fail = task.fails or PROMISES[task.child_policy].may_be_lost
    if task.is_goal and not task.lenient and child_may_fail:
        allowed |= CAUSED_BELOW
    if not task.is_goal and task.fails:
        allowed.add(DROPPED)
    return allowed


def _attempts(record: Record) -> Iterator[str]:
    """Each attempt is handled at most once; a second one only where the policy says so."""
    begun = Counter((e.task, e.attempt) for e in record.deeds if e.deed is Deed.BEGUN)
    policies = _policies(record)
    for (id, attempt), count in begun.items():
        if count > 1:
            yield f"attempt {attempt} of {id} was handled {count} times"
        if attempt > 1 and not PROMISES[policies[id]].may_be_tried_again:
            yield f"{id} was handled a second time though its policy is {policies[id]}"


def _policies(record: Record) -> dict[str, str]:
    """The policy of each task and child, from the name of its message."""
    return {line.task: line.name.rpartition(".")[2] for line in record.log}


def _unearned(record: Record) -> Iterator[str]:
    """A command that succeeded was done, once, by the attempt that it names."""
    done = Counter((e.task, e.attempt) for e in record.deeds if e.deed is Deed.DONE)
    for task in record.plan.tasks:
        told = record.told.get(task.id)
        if told is None or told.state != "achieved" or task.is_goal:
            continue
        attempt = told.result.attempt
        if done[task.id, attempt] != 1:
            yield f"{task.id} succeeded at attempt {attempt}, which nobody did"


def _overlaps(record: Record) -> Iterator[str]:
    """No attempt begins while the handler of an older one runs."""
    tries: dict[str, list[Entry]] = defaultdict(list)
    for entry in record.deeds:
        tries[entry.task].append(entry)
    deaths = {struck.pid: struck.time for struck in record.struck}
    for id, entries in tries.items():
        running: dict[int, Entry] = {}
        for entry in entries:
            if entry.deed is not Deed.BEGUN:
                running.pop(entry.attempt, None)
                continue
            for older in running.values():
                if deaths.get(older.pid, float("inf")) > entry.time:
                    yield f"attempt {entry.attempt} of {id} began while {older.attempt} ran"
            running[entry.attempt] = entry
