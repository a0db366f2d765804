"""What the control rules know besides the search: who asked, how urgently, and how far it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from rogue.errands._priority import Claim, Metric, RankSum, measure
from rogue.errands._tour import Distance, OpenErrand, Travel
from rogue.prodigy import SearchView

NEARBY = 12.0
"""Metres of detour that less urgent errands may cost the urgent ones, all together."""

MOMENT = 30.0
"""Seconds for which what was decided holds if nothing else changes, whoever asks again."""

MARGIN = 6.0
"""How much less urgent than the most urgent an errand may be without being put off for it."""


def key_of(user: object, item: object) -> str:
    """How an errand is called in a tour."""
    return f"{user} {item}"


def thing_of(key: str) -> tuple[str, str]:
    """User and item of an errand in a tour."""
    user, _, item = key.partition(" ")
    return user, item


@dataclass(kw_only=True)
class Agenda:
    """Everything that the rules ask about beyond the state of the search.

    Attributes:
        travel: Distances, speed, tray, and what a detour costs.
        metric: Gives priorities.
        now: The time, in seconds since the epoch.
        nearby: Metres; see `NEARBY`.
        margin: Priority; see `MARGIN`.
    """

    travel: Travel
    metric: Metric = field(default_factory=RankSum)
    now: Callable[[], float] = float
    nearby: float = NEARBY
    margin: float = MARGIN
    _claims: dict[str, Claim] = field(default_factory=dict)

    @staticmethod
    def plain(distance: Distance) -> Agenda:
        """One in which all errands are alike."""
        return Agenda(travel=Travel(distance=distance))

    def put(self, claim: Claim) -> None:
        """Take note of an errand's claim; of one that is noted already, the new one."""
        self._claims[key_of(claim.user, claim.item)] = claim

    def drop(self, user: str, item: str) -> None:
        """Forget an errand."""
        self._claims.pop(key_of(user, item), None)

    def moment(self) -> float:
        """The time of a decision: the start of the `MOMENT` that it is now."""
        return self.now() // MOMENT * MOMENT

    def priority(self, user: str, item: str) -> float:
        """How urgent an errand is now.

        Raises:
            MetricError: The metric raises, or gives no number.
        """
        return self.priority_of(self._claims.get(key_of(user, item)) or Claim(user=user, item=item))

    def priority_of(self, claim: Claim) -> float:
        """How urgent an errand with such a claim is now; errors as `priority`."""
        return measure(self.metric, claim, self.moment())

    def errands(self, view: SearchView) -> tuple[OpenErrand, ...]:
        """The errands that the search has as goals and that are not done, the oldest first.

        Which of them the search had first does not count: another search finds the same order.
        """
        rooms = _rooms(view, "item-at")
        targets = _rooms(view, "bound-for")
        carried = view.state.tuples("robot-has-item")
        found = []
        for goal in view.goals():
            if goal.predicate in GOALS and not view.state.holds(goal):
                user, item = map(str, goal.args)
                key = key_of(user, item)
                found.append(
                    OpenErrand(
                        key=key,
                        pickup=rooms.get(key, ""),
                        deliver=targets.get(key, ""),
                        rank=round(self.priority(user, item), 2),
                        deadline=self._deadline(key),
                        carried=goal.args in carried,
                    )
                )
        complete = [e for e in found if e.deliver and (e.carried or e.pickup)]
        return tuple(sorted(complete, key=lambda e: (self._posted(e.key), e.key)))

    def travel_beside(self, view: SearchView, errands: Iterable[OpenErrand]) -> Travel:
        """How the robot gets about with what is on the tray for none of these errands.

        That takes its places on the tray as long as its own errand waits for somebody. One place
        is left in any case, for a tour to be made at all.
        """
        if self.travel.capacity is None:
            return self.travel
        own = {thing_of(errand.key) for errand in errands}
        others = [args for args in view.state.tuples("robot-has-item") if args not in own]
        return replace(self.travel, capacity=max(1, self.travel.capacity - len(others)))

    def _posted(self, key: str) -> float:
        claim = self._claims.get(key)
        return claim.posted if claim else 0.0

    def _deadline(self, key: str) -> float:
        claim = self._claims.get(key)
        return claim.deadline if claim else math.inf


GOALS = ("has-item", "item-returned")
"""The goals that stand for an errand."""


def robot_room(view: SearchView) -> str | None:
    """Return the room at which the robot is, None if it is at none."""
    rooms = sorted(str(args[0]) for args in view.state.tuples("robot-in-room"))
    return rooms[0] if rooms else None


def _rooms(view: SearchView, predicate: str) -> dict[str, str]:
    return {key_of(u, i): str(room) for u, i, room in view.state.tuples(predicate)}
