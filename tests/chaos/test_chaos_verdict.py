"""The verdict on a chaos run notices each broken promise."""

from __future__ import annotations

from dataclasses import replace

import pytest
from chaos_crew import DROPPED, Effect
from chaos_ledger import Deed, Entry, Ledger
from chaos_plan import Plan, PlannedTask
from chaos_record import Record, Struck, Told
from chaos_verdict import broken_promises

from tca_bus import Constraint, TaskStatus
from tca_bus._protocol import LogEntry

TASK = PlannedTask(
    id="t",
    policy="fail",
    child_policy="fail",
    work=0.1,
    fails=False,
    children=0,
    lenient=False,
    killed_after=None,
    constraints=Constraint.NONE,
)


def status(state):
    return TaskStatus(
        id="t",
        name="lift.fail",
        task_class="command",
        sender="chief",
        parent=None,
        state=state,
        handling="handled",
        planning="planned",
        achievement="achieved",
        existence="terminated",
        created=0.0,
        sequence=9,
    )


def line(event, *, policy="fail"):
    return LogEntry(number=1, time=0.0, task="t", name=f"lift.{policy}", event=event, text="")


def deed(what, *, attempt=1, pid=1, time=0.0):
    return Entry(what, "t", attempt, "crew-0", pid, time)


def good(**changes):
    """A run of one task in which all went well."""
    record = Record(Plan(1, ("crew-0",), (replace(TASK, **changes),), ()))
    record.acknowledged["t"] = status("active")
    record.told["t"] = Told("achieved", result=Effect(module="crew-0", attempt=1))
    record.final["t"] = status("achieved")
    record.log = [line("submitted"), line("achieved")]
    record.deeds = [deed(Deed.BEGUN), deed(Deed.DONE)]
    return record


def failed(record, name):
    record.told["t"] = Told("failed", name)
    record.final["t"] = status("failed")
    record.log[-1] = line("failed")
    return record


def test_a_good_run_breaks_nothing():
    assert broken_promises(good()) == []
    assert broken_promises(failed(good(), "module_lost")) == []
    assert broken_promises(failed(good(fails=True), DROPPED)) == []


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda r: r.acknowledged.clear(), "never acknowledged"),
        (lambda r: r.told.clear(), "did not end"),
        (lambda r: r.final.clear(), "not known to central"),
        (lambda r: r.final.update(t=status("failed")), "central says failed"),
        (lambda r: r.log.append(line("achieved")), "ended 2 times"),
        (lambda r: r.log.pop(), "ended 0 times"),
        (lambda r: r.log.append(line("submitted")), "submitted 2 times"),
        (lambda r: failed(r, "invalid_answer"), "must not end as failed"),
        (lambda r: r.deeds.append(deed(Deed.BEGUN)), "handled 2 times"),
        (lambda r: r.deeds.append(deed(Deed.BEGUN, attempt=2)), "though its policy is fail"),
        (lambda r: r.deeds.pop(), "which nobody did"),
        (
            lambda r: r.published.update(t=[status("achieved"), status("killed")]),
            "published as achieved and as killed",
        ),
    ],
)
def test_a_broken_promise_is_named(spoil, words):
    record = good()
    spoil(record)
    assert any(words in broken for broken in broken_promises(record))


def test_an_attempt_may_begin_only_when_the_older_one_is_over():
    record = good(policy="resend")
    record.log = [line(entry.event, policy="resend") for entry in record.log]
    record.deeds = [
        deed(Deed.BEGUN, pid=1, time=1.0),
        deed(Deed.BEGUN, attempt=2, pid=2, time=3.0),
        deed(Deed.DONE, attempt=2, pid=2, time=4.0),
    ]
    record.told["t"] = Told("achieved", result=Effect(module="crew-0", attempt=2))
    assert broken_promises(record) == ["attempt 2 of t began while 1 ran"]
    record.struck = [Struck("crew-0", 1, 2.0)]
    assert broken_promises(record) == []


def test_the_ledger_gives_back_what_was_noted(tmp_path):
    ledger = Ledger(tmp_path / "ledger")
    assert list(ledger.entries()) == []
    ledger.note(Deed.BEGUN, "t", 1, "crew-0")
    ledger.note(Deed.DONE, "t", 1, "crew-0")
    assert [entry.deed for entry in ledger.entries()] == [Deed.BEGUN, Deed.DONE]
