"""Long random histories of holds inside holds: somebody can always move."""

from __future__ import annotations

import random

from tca_bus import RefusedError
from tca_bus._resource_messages import AcquireResources, HoldKind
from tca_bus.resources import Ledger

CAPACITIES = {"lift": 1, "door": 1, "charger": 2}
KINDS = [HoldKind.LEASE] * 4 + [HoldKind.LOCK, HoldKind.RESERVATION]


class Crowd:
    """Three modules that ask inside whatever they have."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.ledger = Ledger()
        self.time = 0.0
        for name, capacity in CAPACITIES.items():
            self.ledger.declare(0.0, name, capacity, 3 if capacity > 1 else None)

    def moving(self):
        book = self.ledger.book
        return [h for h in book.holds.values() if h.granted is not None and not book.inside(h)]

    def ask(self):
        module = self.random.choice("abc")
        own = tuple(hold.id for hold in self.moving() if hold.module == module)
        kind = self.random.choice(KINDS)
        most = len(CAPACITIES) if kind is HoldKind.LEASE else 1
        request = AcquireResources(
            id=f"h{self.time:g}",
            kind=kind,
            names=tuple(self.random.sample(sorted(CAPACITIES), self.random.randint(1, most))),
            incarnation=module,
            priority=self.random.randint(0, 2),
            holding=own if self.random.random() < 0.5 else (),
        )
        try:
            self.ledger.ask(self.time, module, request)
        except RefusedError:
            assert request.id not in self.ledger.book.holds

    def step(self):
        self.time += 1.0
        chance = self.random.random()
        if chance < 0.6:
            self.ask()
        elif chance < 0.9 and self.moving():
            self.ledger.finish(self.time, self.random.choice(self.moving()).id)
        elif chance < 0.95:
            self.ledger.unlock(self.time, self.random.choice(sorted(CAPACITIES)), "operator")
        else:
            self.ledger.holder_gone(self.time, self.random.choice("abc"))


def test_somebody_can_always_move_and_all_come_to_an_end():
    for seed in range(200):
        crowd = Crowd(seed)
        for _ in range(60):
            crowd.step()
            assert not crowd.ledger.book.holds or crowd.moving(), f"seed {seed}"
        while crowd.ledger.book.holds:
            crowd.ledger.finish(crowd.time, crowd.moving()[0].id)
