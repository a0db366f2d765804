"""Does what a scenario says, each thing when its line of the conversation has come."""

from __future__ import annotations

from collections import Counter

from rogue.messages import ListRequests, PostRequest, RequestState
from rogue.scenarios._papers import Cue, Deed, Errand, Errs, Leaves, Scenario
from tca_bus import Module
from xavier_sim.messages import Fault, Kidnap, MovePerson


class Prompter:
    """Follows the conversation of a scenario."""

    def __init__(self, module: Module, scenario: Scenario) -> None:
        self._module = module
        self._cues = scenario.cues
        self._seen: Counter[Cue] = Counter()

    async def begin(self) -> None:
        """Do what is to be done at the start; once."""
        for cue in self._cues:
            if cue.after is None and not self._seen[cue]:
                await self._take(cue)

    async def see(self, text: str) -> None:
        """Do what was to come after a line like this."""
        for cue in self._cues:
            if cue.after is not None and cue.after in text and self._seen[cue] < cue.times:
                await self._take(cue)

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to be done."""
        return all(self._seen[cue] >= cue.times for cue in self._cues)

    async def failures(self) -> list[str]:
        """What went wrong with the posted requests, in sentences."""
        found = await self._module.query(ListRequests())
        wrong = [r for r in found if r.state is not RequestState.COMPLETED]
        return [f"request {r.id} is {r.state.value}: {r.reason}" for r in wrong]

    async def _take(self, cue: Cue) -> None:
        self._seen[cue] += 1
        await self._do(cue.deed)

    async def _do(self, deed: Deed) -> None:
        match deed:
            case Errand():
                await self._module.query(_request(deed))
            case Errs(room):
                await self._module.query(Fault(fault=Kidnap(room=room)))
            case Leaves(room, back):
                await self._module.query(MovePerson(room=room, present=back))


def _request(errand: Errand) -> PostRequest:
    return PostRequest(
        id=f"{errand.user}-{errand.item}",
        user=errand.user,
        item=errand.item,
        pickup=errand.pickup,
        deliver=errand.deliver,
        deadline=errand.deadline,
    )
