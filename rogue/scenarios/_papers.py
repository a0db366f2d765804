"""The papers' scenarios: what happens after which line of the conversation."""

from __future__ import annotations

from dataclasses import dataclass

from rogue.planning import Rules

VERIFYING = "Verifying Location: "
SENDING = "SENDING COMMAND (TCAEXPANDGOAL"
PLACING = "Please place"
DELIVERED = "COMPLETED-ACTION (DELIVER-ITEM"

EPOCH = "1995-10-01T12:51:00"
"""Simulated local time at which the demonstrations start, as in Figure 6."""


@dataclass(frozen=True, slots=True)
class Errand:
    """A user posts a request."""

    user: str
    item: str
    pickup: str
    deliver: str
    deadline: str | None = None


@dataclass(frozen=True, slots=True)
class Errs:
    """The robot has come to the door of ``room`` and does not know."""

    room: str


@dataclass(frozen=True, slots=True)
class Leaves:
    """Whoever works in ``room`` goes out, or with ``back`` comes in again."""

    room: str
    back: bool = False


Deed = Errand | Errs | Leaves


@dataclass(frozen=True, slots=True)
class Cue:
    """What is done when: after the first ``times`` lines that contain ``after``.

    Without ``after`` it is done at the start.
    """

    deed: Deed
    after: str | None = None
    times: int = 1


@dataclass(frozen=True, slots=True)
class Scenario:
    """One of the papers' examples."""

    about: str
    rules: Rules
    cues: tuple[Cue, ...]


_MAIL = Errand("mitchell", "delivermail", "r-5303", "r-5313")
_FAX = Errand("jhm", "deliverfax", "r-5311", "r-5313")
_LETTERS = Errand("rich", "pickupmail", "r-5301", "r-5315")
_PARCEL = Errand("jhm", "deliverfax", "r-5409", "r-5420", deadline="+20m")

SCENARIOS = {
    "figure6": Scenario("one request", Rules.NONE, (Cue(_MAIL),)),
    "figure9": Scenario(
        "a second, more urgent request comes while the robot drives",
        Rules.Y1996,
        (Cue(_MAIL), Cue(_FAX, after=SENDING)),
    ),
    "figure11": Scenario(
        "a plan of which half is done is merged with another",
        Rules.WORKING,
        (Cue(_MAIL), Cue(Errand("simmons", "pickupbook", "r-5307", "r-5321"), after=PLACING)),
    ),
    "example1998": Scenario(
        "Figure 9's requests as in 1998, with pending goals and applicable operators",
        Rules.Y1998,
        (Cue(_MAIL), Cue(_FAX, after=SENDING)),
    ),
    "failure": Scenario(
        "navigation ends at the wrong door, and the planner plans on from there",
        Rules.Y1996,
        (Cue(_MAIL), Cue(Errs("r-5305"), after=f"{VERIFYING}R-5303", times=3)),
    ),
    "normal": Scenario(
        "a more important request, and a pressing one, interrupts one whose item is on the tray",
        Rules.WORKING,
        (Cue(_LETTERS), Cue(_PARCEL, after=PLACING)),
    ),
    "undone": Scenario(
        "the same, but nobody had put the item on the tray",
        Rules.WORKING,
        (
            Cue(_LETTERS),
            Cue(Leaves("r-5301"), after=PLACING),
            Cue(_PARCEL, after=PLACING),
            Cue(Leaves("r-5301", back=True), after=DELIVERED),
        ),
    ),
}
"""By name."""
