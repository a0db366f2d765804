"""Random histories of holds, and what must hold in each of them."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from tca_bus import DeadlockError, RefusedError
from tca_bus._resource_messages import AcquireResources, HoldKind, HoldState
from tca_bus.resources import (
    Asked,
    Finished,
    Granted,
    Ledger,
    decode_resource_event,
    encode_resource_event,
)

THINGS = ("lift", "door", "charger")
MODULES = ("one", "two", "three")
PICK = st.integers(0, 10_000)
CAPACITIES = {"lift": 1, "door": 1, "charger": 2}
LIMITS = {"charger": 3}


class Histories(RuleBasedStateMachine):
    """Modules that ask, ask inside what they have, release and die."""

    def __init__(self):
        super().__init__()
        self.ledger = Ledger()
        self.time = 0.0
        self.serial = 0
        self.records = []
        self.asked = {}
        self.ended = set()
        self.dead = set()
        for name, capacity in CAPACITIES.items():
            self.happen(self.ledger.declare(0.0, name, capacity, LIMITS.get(name)))

    def happen(self, changes):
        for event in changes.records:
            self.records.append(event)
            match event:
                case Asked():
                    self.asked[event.id] = event
                case Granted():
                    self.check_turn(event.id)
                case Finished():
                    self.ended.add(event.id)

    def check_turn(self, id):
        """Those before it keep a place, unless one is granted inside what they wait for."""
        mine = self.asked[id].request
        if mine.holding:
            return
        before = [e for e in self.waiting_when_granted(id) if self.before(e, self.asked[id])]
        for name in mine.names:
            wanted = [event for event in before if name in event.request.names]
            claims = [event for event in wanted if not self.is_barred(name, event)]
            if mine.kind is not HoldKind.LEASE:
                assert not claims
                continue
            assert all(event.request.kind is HoldKind.LEASE for event in claims)
            taken = len(self.granted_leases(name, id)) + 1
            assert not claims or taken + len(claims) <= CAPACITIES[name]

    def is_barred(self, name, event):
        keeper = self.ledger.book.keeper(name)
        is_lease = event.request.kind is HoldKind.LEASE
        return keeper is not None and not (is_lease and keeper.passes == event.module)

    def granted_leases(self, name, id):
        granted = {event.id for event in self.records if isinstance(event, Granted)}
        held = [self.asked[each].request for each in granted - self.ended - {id}]
        return [r for r in held if name in r.names and r.kind is HoldKind.LEASE]

    def waiting_when_granted(self, id):
        granted = {event.id for event in self.records if isinstance(event, Granted)}
        gone = self.ended | granted | {id}
        return [event for each, event in self.asked.items() if each not in gone]

    def before(self, one, other):
        def key(event):
            lease = event.request.kind is HoldKind.LEASE
            return (lease, -event.request.priority if lease else 0, event.time)

        return key(one) < key(other)

    def now(self):
        self.time += 1.0
        return self.time

    def holds(self):
        return self.ledger.book.holds

    def held(self):
        return [hold for hold in self.holds().values() if hold.granted is not None]

    def waits_inside(self, hold):
        return any(
            hold.id in other.request.holding
            for other in self.holds().values()
            if other.granted is None
        )

    def moving(self):
        """The holders that do not wait for anything."""
        return [hold for hold in self.held() if not self.waits_inside(hold)]

    def alive(self):
        return [module for module in MODULES if module not in self.dead]

    @precondition(lambda self: self.alive())
    @rule(
        pick=PICK,
        names=st.sets(st.sampled_from(THINGS), min_size=1).map(lambda names: tuple(sorted(names))),
        kind=st.sampled_from([*[HoldKind.LEASE] * 4, HoldKind.LOCK, HoldKind.RESERVATION]),
        priority=st.integers(0, 2),
        inside=st.booleans(),
    )
    def ask(self, pick, names, kind, priority, inside):
        module = self.alive()[pick % len(self.alive())]
        own = [hold.id for hold in self.moving() if hold.module == module]
        self.serial += 1
        request = AcquireResources(
            id=f"h{self.serial}",
            names=names if kind is HoldKind.LEASE else names[:1],
            kind=kind,
            incarnation=f"{module}-1",
            priority=priority,
            holding=tuple(own) if inside else (),
        )
        before = set(self.holds())
        try:
            self.happen(self.ledger.ask(self.now(), module, request))
        except DeadlockError:
            assert request.holding
            assert set(self.holds()) == before
        except RefusedError:
            assert kind is not HoldKind.LEASE

    @precondition(lambda self: self.moving())
    @rule(pick=PICK)
    def release(self, pick):
        hold = self.moving()[pick % len(self.moving())]
        self.happen(self.ledger.finish(self.now(), hold.id))

    @precondition(lambda self: self.ledger.book.all_waiting())
    @rule(pick=PICK)
    def give_up(self, pick):
        waiting = self.ledger.book.all_waiting()
        self.happen(self.ledger.finish(self.now(), waiting[pick % len(waiting)].id))

    @precondition(lambda self: self.alive())
    @rule(pick=PICK)
    def die(self, pick):
        module = self.alive()[pick % len(self.alive())]
        self.dead.add(module)
        self.happen(self.ledger.holder_gone(self.now(), f"{module}-1"))

    @precondition(lambda self: self.dead)
    @rule()
    def come_back(self):
        self.dead.pop()

    @rule(name=st.sampled_from(THINGS))
    def unlock(self, name):
        self.happen(self.ledger.unlock(self.now(), name, "operator"))

    @invariant()
    def never_more_holders_than_places(self):
        for name, capacity in CAPACITIES.items():
            leases = [h for h in self.held() if h.is_lease and name in h.names]
            assert len(leases) <= capacity

    @invariant()
    def nobody_else_is_behind_a_lock_or_reservation(self):
        for keeper in (hold for hold in self.held() if not hold.is_lease):
            inside = [h for h in self.held() if keeper.names[0] in h.names and h is not keeper]
            assert all(h.is_lease and h.module == keeper.module for h in inside)

    @invariant()
    def no_hold_without_a_living_holder(self):
        assert not any(hold.module in self.dead for hold in self.holds().values())

    @invariant()
    def no_waiter_is_lost(self):
        assert set(self.holds()) == set(self.asked) - self.ended

    @invariant()
    def no_more_wait_than_may(self):
        for name, limit in LIMITS.items():
            waiting = [h for h in self.ledger.book.all_waiting() if h.is_lease and name in h.names]
            assert len(waiting) <= limit

    @invariant()
    def somebody_can_always_move(self):
        assert not self.holds() or self.moving()
        assert self.ledger.rings(()) == []

    def teardown(self):
        self.replay_gives_the_same_holds()
        self.all_come_to_an_end()

    def all_come_to_an_end(self):
        while self.holds():
            hold = self.moving()[0]
            self.happen(self.ledger.finish(self.now(), hold.id))
            assert self.ledger.status(hold.id).state is HoldState.ENDED

    def replay_gives_the_same_holds(self):
        events = [decode_resource_event(*encode_resource_event(event)) for event in self.records]
        again = Ledger()
        again.replay(events)
        assert again.settle(self.time).records == []
        assert shown(again) == shown(self.ledger)


def shown(ledger):
    return {id: ledger.status(id).model_dump(exclude={"sequence"}) for id in ledger.book.holds}


TestHolds = Histories.TestCase
TestHolds.settings = settings(max_examples=120, stateful_step_count=40, deadline=None)
