"""Leases, reservations and locks: turns, limits, ends and rings, one event at a time."""

from __future__ import annotations

import pytest

from tca_bus import DeadlockError, RefusedError
from tca_bus._resource_messages import AcquireResources, HoldKind, HoldState
from tca_bus.resources import (
    Clause,
    Ledger,
    NoTasks,
    decode_resource_event,
    encode_resource_event,
    find_ring,
)
from tca_bus.tasktree import Gate


class Office:
    """A ledger, and short words for what happens to it."""

    def __init__(self, tasks=None):
        self.ledger = Ledger(tasks)
        self.time = 0.0
        self.records = []
        self.gates = {}

    def note(self, changes):
        self.records += changes.records
        self.gates.update(changes.gates)
        return changes

    def tick(self):
        self.time += 1.0
        return self.time

    def ask(self, id, *names, module="m", kind=HoldKind.LEASE, incarnation="m1", **facts):
        request = AcquireResources(id=id, names=names, kind=kind, incarnation=incarnation, **facts)
        self.note(self.ledger.ask(self.tick(), module, request))
        return self.state(id)

    def end(self, *ids):
        for id in ids:
            self.note(self.ledger.finish(self.tick(), id))

    def state(self, id):
        return self.ledger.status(id).state

    def held(self):
        return {id for id, hold in self.ledger.book.holds.items() if hold.granted is not None}


LOCK, RESERVATION = HoldKind.LOCK, HoldKind.RESERVATION


class Working(NoTasks):
    """A task tree in which these tasks are in these resources, and wait for these."""

    def __init__(self, **attending):
        self.inside = {name.replace("_", "/"): set(tasks) for name, tasks in attending.items()}
        self.waits = {}
        self.with_hold = {}

    def attending(self, resource):
        return self.inside.get(resource, ())

    def awaited(self, task):
        return self.waits.get(task, ())

    def awaited_with(self, hold):
        return self.with_hold.get(hold, ())


def test_a_thing_has_one_place_and_is_first_come_first_served():
    here = Office()
    assert here.ask("a", "lift") is HoldState.HELD
    assert here.ask("b", "lift") is HoldState.WAITING
    assert here.ask("c", "lift") is HoldState.WAITING
    assert here.ledger.status("b").waiting_for == "lift, which m has"
    here.end("a")
    assert here.held() == {"b"}
    here.end("b")
    assert here.held() == {"c"}


def test_a_higher_priority_goes_first():
    here = Office()
    here.ask("a", "lift")
    here.ask("b", "lift")
    here.ask("c", "lift", priority=1)
    here.end("a")
    assert here.held() == {"c"}


def test_a_declared_thing_has_more_places():
    here = Office()
    here.ledger.declare(0.0, "chargers", 2, None)
    for id in "abc":
        here.ask(id, "chargers")
    assert here.held() == {"a", "b"}
    here.note(here.ledger.declare(1.0, "chargers", 3, None))
    assert here.held() == {"a", "b", "c"}
    here.ledger.declare(2.0, "chargers", 1, None)
    here.ask("d", "chargers")
    here.end("a", "b")
    assert here.state("d") is HoldState.WAITING
    here.end("c")
    assert here.held() == {"d"}


def test_several_things_are_taken_at_once_or_not_at_all():
    here = Office()
    here.ask("a", "lift")
    here.ask("b", "lift", "door")
    assert here.held() == {"a"}
    assert here.ask("c", "door") is HoldState.WAITING
    here.end("a")
    assert here.held() == {"b"}


def test_who_waits_for_several_is_not_overtaken_at_any_of_them():
    here = Office()
    here.ask("a", "lift")
    here.ask("both", "lift", "door")
    for number in range(5):
        assert here.ask(f"later{number}", "door") is HoldState.WAITING
    assert here.ask("other", "charger") is HoldState.HELD
    here.end("a")
    assert "both" in here.held()


def test_asked_again_under_its_id_it_is_one_hold():
    here = Office()
    here.ask("a", "lift")
    before = len(here.records)
    assert here.ask("a", "lift") is HoldState.HELD
    assert len(here.records) == before
    with pytest.raises(RefusedError, match="another hold"):
        here.ask("a", "door")
    here.end("a")
    assert here.ask("a", "lift") is HoldState.ENDED


def test_a_release_that_overtakes_its_hold_is_remembered():
    here = Office()
    here.ledger.forget(0.0, "a", "m")
    assert here.ask("a", "lift") is HoldState.ENDED
    assert here.held() == set()


def test_leases_end_with_their_holders_life():
    here = Office()
    here.ask("a", "lift", incarnation="m1")
    here.ask("b", "lift", module="n", incarnation="n1")
    here.ask("c", "lift", incarnation="m1")
    here.note(here.ledger.holder_gone(here.tick(), "m1"))
    assert here.held() == {"b"}
    assert here.ledger.status("a").failure.name == "holder_lost"
    assert here.ledger.status("c").state is HoldState.ENDED


def test_a_lease_of_a_task_ends_with_the_task_not_with_its_module():
    here = Office()
    here.ask("a", "lift", task="t", attempt=1)
    here.ask("b", "lift", module="n", incarnation="n1")
    here.note(here.ledger.holder_gone(here.tick(), "m1"))
    assert here.held() == {"a"}
    here.note(here.ledger.task_moved(here.tick(), "t", 1))
    assert here.held() == {"a"}
    here.note(here.ledger.task_moved(here.tick(), "t", None))
    assert here.held() == {"b"}


def test_a_lease_of_a_try_ends_when_the_task_is_handled_again():
    here = Office()
    here.ask("a", "lift", task="t", attempt=1)
    here.note(here.ledger.task_moved(here.tick(), "t", 2))
    assert here.ledger.status("a").failure.name == "task_ended"


def test_of_too_many_waiting_the_oldest_is_dropped_and_told_why():
    here = Office()
    here.ledger.declare(0.0, "lift", 1, 2)
    for id in "abc":
        here.ask(id, "lift")
    here.ask("d", "lift", priority=1)
    failure = here.ledger.status("b").failure
    assert failure.name == "pending_limit"
    assert failure.data == {"resource": "lift", "limit": 2}
    assert here.ledger.book.dropped["lift"] == 1
    here.end("a")
    assert here.held() == {"d"}


def test_a_lock_keeps_everybody_out_and_comes_before_those_who_wait():
    here = Office()
    here.ask("a", "lift", module="n")
    here.ask("b", "lift")
    assert here.ask("lock", "lift", kind=LOCK) is HoldState.WAITING
    here.end("a")
    assert here.held() == {"lock"}
    assert here.ask("c", "lift") is HoldState.WAITING
    here.end("lock")
    assert here.held() == {"b"}


def test_a_reservation_lets_only_the_reserver_in():
    here = Office()
    here.ask("r", "lift", kind=RESERVATION)
    assert here.ask("theirs", "lift", module="n", incarnation="n1") is HoldState.WAITING
    assert here.ask("mine", "lift") is HoldState.HELD
    here.end("r", "mine")
    assert here.held() == {"theirs"}


def test_a_second_reservation_by_the_same_module_is_refused():
    here = Office()
    here.ask("r", "robot/arm", kind=RESERVATION)
    with pytest.raises(RefusedError, match=r"who has a reservation of it already \(r\)"):
        here.ask("again", "robot/arm", kind=RESERVATION)
    assert here.ask("other", "robot/arm", kind=RESERVATION, module="n") is HoldState.WAITING


def test_a_lock_of_handlers_shuts_the_gate_at_once_and_begins_when_they_are_done():
    tasks = Working(robot_arm={"t1"})
    here = Office(tasks)
    assert here.ask("lock", "robot/arm", kind=LOCK) is HoldState.WAITING
    assert here.gates["robot/arm"] == Gate("lock", None, "m, who waits for a lock")
    assert here.ledger.status("lock").waiting_for == "robot/arm, which task t1 has"
    tasks.inside.clear()
    here.note(here.ledger.settle(here.tick()))
    assert here.state("lock") is HoldState.HELD
    here.end("lock")
    assert here.gates["robot/arm"] is None


def test_a_handler_may_lock_its_own_resource():
    here = Office(Working(robot_arm={"t1"}))
    assert here.ask("lock", "robot/arm", kind=LOCK, task="t1", attempt=1) is HoldState.HELD


def test_a_reservation_of_handlers_opens_the_gate_for_its_module():
    here = Office()
    here.ask("r", "robot/", kind=RESERVATION, passes="boss")
    assert here.gates["robot/"].only == "boss"


def test_leases_are_of_things_only():
    here = Office()
    with pytest.raises(RefusedError, match="reserve or lock it instead"):
        here.ask("a", "robot/arm")
    with pytest.raises(RefusedError, match="of one resource"):
        here.ask("a", "lift", "door", kind=LOCK)
    with pytest.raises(RefusedError, match="twice"):
        here.ask("a", "lift", "lift")


def test_unlocking_ends_the_lock_first_and_the_leases_else():
    here = Office()
    here.ask("a", "lift", "door")
    here.note(here.ledger.unlock(here.tick(), "door", "operator"))
    assert here.held() == set()
    assert here.ledger.status("a").failure.text == "unlocked by operator"
    here.ask("lock", "lift", kind=LOCK)
    here.ask("b", "lift")
    here.note(here.ledger.unlock(here.tick(), "lift", "operator"))
    assert here.held() == {"b"}


def test_an_inner_lease_that_closes_a_ring_is_refused_with_its_members():
    here = Office()
    here.ask("a", "lift", module="one")
    here.ask("b", "door", module="two")
    assert here.ask("a2", "door", module="one", holding=("a",)) is HoldState.WAITING
    with pytest.raises(DeadlockError) as caught:
        here.ask("b2", "lift", module="two", holding=("b",))
    assert set(caught.value.members) == {
        "two, waiting for lift",
        "one, holding lift",
        "one, waiting for door",
        "two, holding door",
    }
    here.end("b")
    assert here.held() == {"a", "a2"}


def test_a_second_place_breaks_the_ring():
    here = Office()
    here.ledger.declare(0.0, "lift", 2, None)
    here.ask("a", "lift", module="one")
    here.ask("free", "lift", module="three")
    here.ask("b", "door", module="two")
    here.ask("a2", "door", module="one", holding=("a",))
    assert here.ask("b2", "lift", module="two", holding=("b",)) is HoldState.WAITING
    here.end("free")
    assert "b2" in here.held()


def test_asking_inside_for_what_one_has_already_is_a_ring():
    here = Office()
    here.ask("a", "lift")
    with pytest.raises(DeadlockError):
        here.ask("again", "lift", holding=("a",))


def test_a_claim_gives_way_where_nobody_would_move():
    here = Office()
    here.ask("outer", "door")
    here.ask("both", "door", "lift", module="other")
    assert here.ask("inner", "lift", holding=("outer",)) is HoldState.HELD
    here.end("inner", "outer")
    assert here.held() == {"both"}


def test_a_handler_that_waits_for_a_task_that_needs_its_lease_is_a_ring():
    tasks = Working()
    here = Office(tasks)
    here.ask("a", "lift", task="parent", attempt=1)
    here.ask("b", "lift", task="child", attempt=1, module="n", incarnation="n1")
    assert here.ledger.rings(["parent"]) == []
    tasks.waits["parent"] = tasks.with_hold["a"] = {"child"}
    rings = here.ledger.rings(["parent"])
    assert [set(ring) for ring in rings] == [{("hold", "a"), ("hold", "b"), ("task", "child")}]
    assert "m, waiting for lift" not in here.ledger.words(rings[0])


def test_a_ring_needs_all_ways_out_to_be_shut():
    waits = {
        ("task", "a"): [Clause(1, frozenset({("task", "b"), ("task", "free")}))],
        ("task", "b"): [Clause(1, frozenset({("task", "a")}))],
    }
    assert find_ring(("task", "a"), lambda member: waits.get(member, ())) is None
    waits["task", "a"] = [Clause(2, frozenset({("task", "b"), ("task", "free")}))]
    ring = find_ring(("task", "a"), lambda member: waits.get(member, ()))
    assert ring == [("task", "a"), ("task", "b")]


def test_who_waits_behind_a_ring_is_told_of_the_ring():
    waits = {
        ("task", "behind"): [Clause(1, frozenset({("task", "a")}))],
        ("task", "a"): [Clause(1, frozenset({("task", "b")}))],
        ("task", "b"): [Clause(1, frozenset({("task", "a")}))],
    }
    ring = find_ring(("task", "behind"), lambda member: waits.get(member, ()))
    assert ring == [("task", "a"), ("task", "b")]


def test_the_records_replayed_give_the_same_holds():
    here = Office()
    here.note(here.ledger.declare(0.0, "lift", 1, 5))
    here.ask("a", "lift")
    here.ask("b", "lift", "door", priority=2)
    here.ask("lock", "robot/arm", kind=LOCK)
    here.ask("c", "lift")
    here.end("a")
    events = [decode_resource_event(*encode_resource_event(event)) for event in here.records]
    again = Ledger(generation=1)
    again.replay(events)
    changes = again.settle(here.tick())
    assert changes.records == []
    assert changes.gates == {"robot/arm": Gate("lock", None, "m, who has a lock")}
    for id in ("b", "lock", "c"):
        old, new = here.ledger.status(id), again.status(id)
        assert new.sequence > old.sequence
        assert new.model_copy(update={"sequence": 0}) == old.model_copy(update={"sequence": 0})


def test_a_lock_that_a_reservation_bars_does_not_keep_the_reserver_out():
    here = Office()
    here.ask("r", "lift", kind=RESERVATION)
    here.ask("lock", "lift", module="n", kind=LOCK)
    assert here.ask("mine", "lift", "door") is HoldState.HELD


def test_a_reservation_inside_a_lease_does_not_wait_for_who_waits_for_the_lease():
    here = Office()
    here.ask("mine", "door")
    here.ask("lock", "door", module="n", kind=LOCK)
    assert here.ask("r", "door", kind=RESERVATION, holding=("mine",)) is HoldState.HELD


def test_a_ring_behind_a_reservation_is_seen_before_it_ends():
    here = Office()
    here.ask("a", "door", module="one")
    here.ask("b", "lift", module="two")
    here.ask("r", "lift", kind=RESERVATION, module="two")
    here.ask("b2", "door", module="two", holding=("b",))
    with pytest.raises(DeadlockError):
        here.ask("a2", "lift", module="one", holding=("a",))


def test_a_drop_lets_those_pass_that_waited_behind_its_claim():
    here = Office()
    here.ledger.declare(0.0, "lift", 1, 1)
    here.ask("a", "lift")
    here.ask("both", "lift", "door")
    here.ask("c", "door")
    assert here.state("c") is HoldState.WAITING
    here.ask("d", "lift")
    assert here.ledger.status("both").failure.name == "pending_limit"
    assert here.state("c") is HoldState.HELD
