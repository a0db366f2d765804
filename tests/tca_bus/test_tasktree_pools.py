"""Random histories of providers, groups, gates and waiting nodes, beside a plain model."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from tca_bus.tasktree import Gate, HandlerResource
from tca_bus.tasktree._pools import Pools

NAMES = ("grasp", "wave", "drive")
SENDERS = ("a", "b")
PICK = st.integers(0, 10_000)
GROUPS = st.sampled_from(
    [
        (),
        (HandlerResource("arm", 1, ("grasp", "wave")),),
        (HandlerResource("arm", 2, ("grasp", "wave")), HandlerResource("", 2, NAMES)),
        (HandlerResource("arm", 1, ("grasp", "wave"), pending=2),),
    ]
)


class Histories(RuleBasedStateMachine):
    """Each step is followed by all assignments and drops that it allows, as the tree does it."""

    def __init__(self):
        super().__init__()
        self.pools = Pools()
        self.serial = 0
        self.waiting = {}
        self.working = {}
        self.present = {}
        self.gates = {}
        self.priority_of = {}

    def settle(self):
        while True:
            choice = self.pools.assign()
            if choice is not None:
                self.check_choice(choice)
                self.assign(choice)
                continue
            excess = self.pools.overflow()
            if excess is None:
                return
            self.check_drop(excess)
            self.pools.drop(excess.id, excess.resource)
            del self.waiting[excess.id]

    def assign(self, choice):
        name, _ = self.waiting.pop(choice.id)
        self.pools.occupy(choice.id, name, choice.module, choice.incarnation)
        self.working[choice.id] = (name, choice.incarnation)

    def check_choice(self, choice):
        """Nobody of as high a priority who came before could have had the place."""
        name, sender = self.waiting[choice.id]
        assert self.may_take(choice.incarnation, name, sender)
        for other, (wanted, source) in self.waiting.items():
            if self.before(other, choice.id):
                assert not self.may_take(choice.incarnation, wanted, source)

    def check_drop(self, excess):
        lowest = min(self.priority_of[id] for id in self.waiting)
        shared = self.waiting[excess.id][0]
        same = [id for id, (name, _) in self.waiting.items() if name == shared]
        assert self.priority_of[excess.id] == min(self.priority_of[id] for id in same)
        assert self.priority_of[excess.id] >= lowest

    def before(self, one, other):
        def key(id):
            return (-self.priority_of[id], self.pools._queues[self.waiting[id][0]].key(id)[1])

        return key(one) < key(other)

    def may_take(self, incarnation, name, sender):
        module, groups, _ = self.present[incarnation]
        for resource, capacity, members in self.resources_of(groups):
            if name not in members:
                continue
            gate = self.gates.get(f"{module}/{resource}")
            if gate is not None and gate.only != sender:
                return False
            if capacity is not None and self.load(incarnation, members) >= capacity:
                return False
        return True

    def resources_of(self, groups):
        grouped = {name for group in groups if group.name for name in group.messages}
        own = next((group.capacity for group in groups if group.name == ""), None)
        yield ("", own, NAMES)
        for name in NAMES:
            if name not in grouped:
                yield (name, 1, (name,))
        for group in groups:
            if group.name:
                yield (group.name, group.capacity, group.messages)

    def load(self, incarnation, members):
        return sum(
            name in members and holder == incarnation for name, holder in self.working.values()
        )

    @rule(pick=PICK, priority=st.integers(0, 2), sender=st.sampled_from(SENDERS))
    def wait(self, pick, priority, sender):
        self.serial += 1
        id, name = f"n{self.serial}", NAMES[pick % len(NAMES)]
        self.waiting[id] = (name, sender)
        self.priority_of[id] = priority
        self.pools.wait(id, name, priority, sender=sender)
        self.settle()

    @rule(module=st.sampled_from(["m", "n"]), groups=GROUPS, limit=st.sampled_from([None, 1, 3]))
    def appear(self, module, groups, limit):
        if any(known == module for known, _, _ in self.present.values()):
            return
        self.serial += 1
        incarnation = f"{module}{self.serial}"
        self.present[incarnation] = (module, groups, limit)
        limits = {} if limit is None else {"drive": limit}
        self.pools.appear(
            module, incarnation, dict.fromkeys(NAMES, 1), resources=groups, limits=limits
        )
        self.settle()

    @precondition(lambda self: self.present)
    @rule(pick=PICK)
    def lose(self, pick):
        incarnation = list(self.present)[pick % len(self.present)]
        del self.present[incarnation]
        _, ids = self.pools.lose(incarnation)
        assert set(ids) == {id for id, (_, who) in self.working.items() if who == incarnation}
        for id in ids:
            del self.working[id]
        self.settle()

    @precondition(lambda self: self.working)
    @rule(pick=PICK)
    def finish(self, pick):
        id = list(self.working)[pick % len(self.working)]
        name, incarnation = self.working.pop(id)
        self.pools.release(id, name, incarnation)
        self.settle()

    @precondition(lambda self: self.waiting)
    @rule(pick=PICK)
    def forget(self, pick):
        id = list(self.waiting)[pick % len(self.waiting)]
        del self.waiting[id]
        self.pools.forget(id)
        self.settle()

    @precondition(lambda self: self.waiting)
    @rule(pick=PICK, priority=st.integers(0, 2))
    def reprioritise(self, pick, priority):
        id = list(self.waiting)[pick % len(self.waiting)]
        self.priority_of[id] = priority
        self.pools.reprioritise(id, priority)
        self.settle()

    @rule(
        resource=st.sampled_from(["m/arm", "m/drive", "n/", "n/arm"]),
        only=st.sampled_from([None, *SENDERS]),
        held=st.booleans(),
    )
    def hold(self, resource, only, held):
        gate = Gate("somebody", only) if held else None
        self.gates = {k: v for k, v in self.gates.items() if k != resource}
        if gate is not None:
            self.gates[resource] = gate
        self.pools.set_gate(resource, gate)
        self.settle()

    @invariant()
    def never_more_holders_than_capacity(self):
        for incarnation, (_, groups, _) in self.present.items():
            for _, capacity, members in self.resources_of(groups):
                if capacity is not None:
                    assert self.load(incarnation, members) <= capacity

    @invariant()
    def nobody_waits_for_what_is_free(self):
        for name, sender in self.waiting.values():
            assert not any(self.may_take(each, name, sender) for each in self.present)

    @invariant()
    def no_waiter_is_lost(self):
        assert set(self.pools._waiting) == set(self.waiting)

    @invariant()
    def no_limit_is_exceeded_at_every_module(self):
        drives = sum(name == "drive" for name, _ in self.waiting.values())
        limits = [limit for _, _, limit in self.present.values()]
        if limits and None not in limits:
            assert drives <= max(limits)


TestPools = Histories.TestCase
TestPools.settings = settings(max_examples=80, stateful_step_count=40, deadline=None)
