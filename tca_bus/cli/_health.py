"""``tca status`` and ``tca doctor``: is everything there, and if not, what to do."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tca_bus import TaskStatus, TcaError
from tca_bus._protocol import ListTasks
from tca_bus._readiness import missing
from tca_bus.cli._client import Seen, joined, look_around
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, show_table

CENTRAL = {"central": "tca central"}

OFFICE = {
    **CENTRAL,
    "xavier": "xavier run",
    "speech": "xavier speech",
    "navigate": "navigate run",
    "rogue": "rogue agent",
}
"""The modules of the office and the commands that start them one by one.

They are expected where one of them is there, or nobody serves anything but central: other robots
have others.
"""

STUCK_SECONDS = 300.0
"""A task that has waited for so long is worth a word."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at; ``advice`` says what to do when it is not well."""

    what: str
    ok: bool
    text: str
    advice: str = ""


async def status(*, flags: BusFlags = DEFAULT_FLAGS) -> int:
    """Show in a few lines whether the office is up: exit code 0 if so, 1 if something is amiss."""
    seen, tasks = await _look(flags)
    expected = _expected(seen)
    names = [*expected, *sorted({one.module.name for one in seen} - set(expected))]
    states = {one.module.name: one.state for one in seen}
    rows = [(name, states.get(name, "missing")) for name in names]
    if flags.json:
        emit_json({"router": flags.connect, "modules": dict(rows), "tasks": len(tasks)})
    else:
        show_table(("module", "state"), [("router", "ready"), *rows])
        emit(f"{len(tasks)} task nodes are alive")
    return 0 if all(state == "ready" for _, state in rows) else 1


async def doctor(*, flags: BusFlags = DEFAULT_FLAGS) -> int:
    """Look for what is amiss and say what to do about it: exit code 1 if there is something."""
    seen, tasks = await _look(flags)
    findings = [
        Finding("router", ok=True, text=f"reached at {flags.connect}"),
        *_missing(seen),
        *_ailing(seen),
        *_unmet(seen),
        *_stuck(tasks),
    ]
    if flags.json:
        emit_json([_facts(finding) for finding in findings])
    else:
        for finding in findings:
            _show(finding)
    return 0 if all(finding.ok for finding in findings) else 1


async def _look(flags: BusFlags) -> tuple[list[Seen], list[TaskStatus]]:

    async with joined(flags) as module:
        seen = await look_around(module)
        try:
            tasks = await module.query(ListTasks(), to="central", timeout=2.0)
        except TcaError:
            # That central is missing or hung is among the findings.
            tasks = []
    return seen, tasks


def _expected(seen: Sequence[Seen]) -> dict[str, str]:
    """The modules that should be there, and the commands that start them."""
    others = {one.module.name for one in seen if one.module.provides} - set(CENTRAL)
    return CENTRAL if others and others.isdisjoint(OFFICE) else OFFICE


def _missing(seen: Sequence[Seen]) -> Iterator[Finding]:
    present = [one.module.name for one in seen]
    for name, start in _expected(seen).items():
        if name not in present:
            whole = "" if name in CENTRAL else ", or the whole office with 'rogue up'"
            advice = f"start it with '{start}'{whole}"
            yield Finding(name, ok=False, text="is not there", advice=advice)
        elif present.count(name) > 1:
            pids = ", ".join(str(one.module.pid) for one in seen if one.module.name == name)
            advice = f"one is enough; stop one of the processes {pids}"
            yield Finding(name, ok=False, text="is there more than once", advice=advice)


def _ailing(seen: Sequence[Seen]) -> Iterator[Finding]:
    for one in seen:
        name, pid = one.module.name, one.module.pid
        if one.card is None:
            advice = f"its event loop hangs; 'kill -9 {pid}' ends it; then start it again"
            yield Finding(name, ok=False, text="does not answer", advice=advice)
            continue
        losses = [f"{count} of {queue}" for queue, count in one.card.dropped.items()]
        losses += [f"{one.card.invalid} that were no valid message"] * bool(one.card.invalid)
        if losses:
            advice = "it was too slow, or somebody sends nonsense; its log says what"
            yield Finding(name, ok=False, text=f"lost {', '.join(losses)}", advice=advice)
        else:
            yield Finding(name, ok=True, text=f"ready, process {pid} on {one.module.host}")


def _unmet(seen: Sequence[Seen]) -> Iterator[Finding]:
    offered = {name for one in seen for name in (one.module.name, *one.module.resources)}
    for one in seen:
        for resource in missing(one.module.requires, offered):
            text = f"requires {resource!r}, which no module provides"
            advice = f"start a module that provides {resource!r}"
            yield Finding(one.module.name, ok=False, text=text, advice=advice)


def _stuck(tasks: Sequence[TaskStatus]) -> Iterator[Finding]:
    old = [t for t in tasks if t.waiting_for and time.time() - t.created > STUCK_SECONDS]
    for task in old:
        text = f"{task.name} {task.id} waits for {task.waiting_for}"
        yield Finding("task", ok=False, text=text, advice=f"'tca kill {task.id}' ends it")
    if not old:
        yield Finding("tasks", ok=True, text=f"{len(tasks)} nodes alive, none waits for long")


def _facts(finding: Finding) -> dict[str, Any]:
    facts = {"what": finding.what, "ok": finding.ok, "text": finding.text}
    return {**facts, "advice": finding.advice}


def _show(finding: Finding) -> None:
    emit(f"{'ok' if finding.ok else '!!'}  {finding.what}: {finding.text}")
    if finding.advice:
        emit(f"      {finding.advice}")
