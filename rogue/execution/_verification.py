"""Verifying where the robot stands: layer after layer, cheap to costly, until sure enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rogue import trace
from rogue.execution._effects import Part, Tell
from rogue.execution._layers import Bystander, DoorPlate, Doubt, Layer, NavigatorBelief
from rogue.execution._patience import Patience
from rogue.execution._whereabouts import Whereabouts
from rogue.outcomes import Arrival

SURE = 0.98
"""How probable a place must be before the robot acts on being there."""


@dataclass(frozen=True, slots=True)
class Verification:
    """The layers in their order, and how sure is sure enough.

    Any object that is like a `Layer` may stand in ``layers``. Layers are taken to err
    independently of each other, so their order does not matter to what is found, only to what
    it costs. With ``looks_again`` the robot also asks itself whether it is still there before
    anything is handed over.
    """

    layers: Sequence[Layer]
    sure: float = SURE
    looks_again: bool = True

    def place(self, room: str | None, patience: Patience) -> Part[Arrival]:
        """Where the robot stands, and which layer made sure of it.

        ``room`` is where it should be, None if it is lost.
        """
        known = Whereabouts()
        for number, layer in enumerate(self.layers):
            evidence = yield from layer.look(Doubt(room, patience))
            if evidence is None:
                continue
            known = known.updated(evidence)
            if number:
                yield from _tell(known)
            found = known.likeliest()
            if found is not None and found[1] >= self.sure:
                return Arrival(room=found[0], by=layer.name, sure=round(found[1], 4))
        return Arrival()


def layered(
    *, sure: float = SURE, camera: bool = True, people: bool = True, navigator: bool = True
) -> Verification:
    """Cheap to costly: the navigator's belief, the door plate, and a person last."""
    layers: list[Layer] = []
    if navigator:
        layers.append(NavigatorBelief())
    if camera:
        layers.append(DoorPlate(heeds_belief=navigator))
    if people:
        layers.append(Bystander())
    return Verification(tuple(layers), sure)


def as_published() -> Verification:
    """Always ask a person, as in Figure 6; the navigator is believed where nobody answers."""
    return Verification((Bystander(), NavigatorBelief()), sure=0.9, looks_again=False)


def _tell(known: Whereabouts) -> Part[None]:
    found = known.likeliest()
    if found is not None:
        yield Tell(trace.remark(f"Taken together: {found[0].upper()} ({found[1]:.3f})."))
