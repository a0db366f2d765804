"""Messages that the rogue module serves: requests of users, and what became of them.

Times are seconds since the epoch on the module's clock; rooms, users and items are names in
lower case as in the papers (``r-5303``, ``mitchell``, ``delivermail``).
"""

from __future__ import annotations

import enum
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from rogue.outcomes import Arrival
from rogue.prodigy import GoalTree
from tca_bus import Broadcast, Query

REQUEST_ID_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
"""A request's id, made by whoever posts it."""

NAME_LENGTH = 64
"""Characters of the longest name of a user, item or room."""

End = Literal["pickup", "deliver"]
"""One of the two ends of an errand, as the field of `PostRequest` that names its room."""


class RequestState(enum.StrEnum):
    """Where a request stands."""

    QUEUED = "queued"
    """Accepted; nothing was done for it yet."""
    UNDERWAY = "underway"
    """The robot has begun to serve it."""
    SUSPENDED = "suspended"
    """Begun, and put aside for a more urgent one."""
    COMPLETED = "completed"
    """The item was delivered."""
    FAILED = "failed"
    """It could not be done; the reason says why."""
    CANCELED = "canceled"
    """Somebody took it back."""

    @property
    def is_final(self) -> bool:
        """Whether a request in this state stays there."""
        return self in FINAL_STATES


FINAL_STATES = frozenset({RequestState.COMPLETED, RequestState.FAILED, RequestState.CANCELED})
"""The states that never change again."""


class Closing(BaseModel):
    """How a request will end once what the robot carries for it is where it shall be.

    ``state`` is failed or canceled, ``since`` when that was decided.
    """

    model_config = ConfigDict(frozen=True)

    state: RequestState
    reason: str
    since: float


class DeliveryRequest(BaseModel):
    """One errand of one user, as `rogue requests --json` shows it.

    ``rank`` is PersonRank + TaskRank; ``finished`` and ``reason`` stay None until it has ended.
    ``then`` says where the item goes once it is on the tray: to ``deliver``, or back to
    ``pickup``. A request that was taken back, or missed its deadline, while its item was on the
    tray has ``closing`` and stays open until the item is there. ``warning`` says what is to be
    feared for an open request, such as that its deadline cannot be met any more.
    """

    model_config = ConfigDict(frozen=True)

    id: str
    user: str
    item: str
    pickup: str
    deliver: str
    state: RequestState
    rank: int
    posted: float
    deadline: float
    finished: float | None = None
    reason: str | None = None
    then: Literal["deliver", "back"] = "deliver"
    closing: Closing | None = None
    warning: str | None = None

    @property
    def destination(self) -> str:
        """The room to which the item goes from the tray."""
        return self.pickup if self.then == "back" else self.deliver


Source = Literal["directory", "finger", "default", "answer"]
"""Who knew what a user left out: the people directory, the user's finger server, a default, or
the user, in answer to a question."""


class Filled(BaseModel):
    """What a user left out of a request, by the field of `PostRequest`, and who knew it."""

    model_config = ConfigDict(frozen=True)

    slot: Literal["pickup", "deliver", "deadline"]
    value: str
    source: Source


class PostRequest(Query[DeliveryRequest]):
    """Ask for an errand. Posted twice with one id it is one request.

    What is missing is filled in from the people directory, a finger server, and defaults; with
    ``ask`` the person is asked on the robot's keyboard for what nobody knows, which may take
    minutes: post again under the same id if the answer does not come in time. ``deadline`` is a
    time as people write it: ISO 8601, ``HH:MM``, or from now on: ``+30m``, ``1h``. ``again``
    wants an errand that is open already once more, ``anyway`` one that cannot be done in time.
    Answered only after the request is on disk. Refused as one of `Refusal`, with `Objection` as
    data.
    """

    wire_name = "rogueRequest"

    id: str = Field(pattern=REQUEST_ID_PATTERN)
    user: str = Field(min_length=1, max_length=NAME_LENGTH)
    item: str = Field(min_length=1, max_length=NAME_LENGTH)
    pickup: str | None = Field(default=None, max_length=NAME_LENGTH)
    deliver: str | None = Field(default=None, max_length=NAME_LENGTH)
    deadline: str | None = Field(default=None, max_length=NAME_LENGTH)
    why: str | None = Field(default=None, max_length=1000)
    ask: bool = False
    again: bool = False
    anyway: bool = False


class Refusal(enum.StrEnum):
    """Why a message of this module was refused: the names of its failures on the bus."""

    UNKNOWN_USER = "unknown_user"
    """The people directory has nobody of that name."""
    UNKNOWN_ITEM = "unknown_item"
    """Nothing of that name is carried."""
    UNKNOWN_ROOM = "unknown_room"
    """The map has no such room."""
    SAME_ROOM = "same_room"
    """Pickup and delivery are one place."""
    BAD_DEADLINE = "bad_deadline"
    """The deadline cannot be read, or has passed."""
    ID_TAKEN = "id_taken"
    """Another request has this id."""
    MISSING_ROOM = "missing_room"
    """Nobody knows where the item is, or where it shall go."""
    DUPLICATE = "duplicate"
    """The same errand is open already, under another id."""
    TOO_LATE = "too_late"
    """With all that was accepted before, it cannot be done by its deadline."""
    BAD_TIME = "bad_time"
    """A time that has passed cannot be read."""
    UNKNOWN_REQUEST = "unknown_request"
    """No request has this id."""
    NOT_READY = "not_ready"
    """The navigator, who knows the rooms, is not there."""


class Objection(BaseModel):
    """What is wrong with a message: the data of a `Refusal`.

    ``field`` is the message's, ``value`` what it held, ``expected`` what would be right;
    ``other`` is the id of an open request for the same errand; ``question`` is what to ask the
    user for a room that nobody knows; ``earliest`` is when an errand can be done.
    """

    model_config = ConfigDict(frozen=True)

    field: str
    value: str | None
    expected: str
    other: str | None = None
    question: str | None = None
    earliest: float | None = None


class ListRequests(Query[list[DeliveryRequest]]):
    """Ask for all requests, the oldest first; with ``open_only`` for those not yet ended.

    ``states`` and ``user`` leave out the others, ``most`` all but the latest.
    """

    wire_name = "rogueRequests"

    open_only: bool = False
    states: tuple[RequestState, ...] = ()
    user: str | None = Field(default=None, min_length=1, max_length=NAME_LENGTH)
    most: int | None = Field(default=None, ge=1)


class StepView(BaseModel):
    """One executed operator: when, and what came of it; ``arrivals`` as in `StepOutcome`."""

    model_config = ConfigDict(frozen=True)

    operator: str
    state: str
    started: float
    ended: float | None
    outcome: str | None
    arrivals: tuple[Arrival, ...] = ()


class RequestDetails(BaseModel):
    """A request with what was done for it."""

    model_config = ConfigDict(frozen=True)

    request: DeliveryRequest
    why: str | None
    filled: list[Filled]
    on_tray: bool
    steps: list[StepView]


class ShowRequest(Query[RequestDetails]):
    """Ask for one request in full."""

    wire_name = "rogueShow"

    id: str = Field(pattern=REQUEST_ID_PATTERN)


class CancelRequest(Query[DeliveryRequest]):
    """Take a request back, at whatever stage. One that has ended already stays as it is.

    ``item`` says what happens with an item that is on the tray: it goes ``back`` to where it
    came from, or is delivered all the same, and the request is open until that is done; or the
    robot is to ``keep`` it.
    """

    wire_name = "rogueCancel"

    id: str = Field(pattern=REQUEST_ID_PATTERN)
    reason: str = Field(default="canceled by its user", min_length=1, max_length=400)
    item: Literal["back", "deliver", "keep"] = "back"


class RequestChanged(Broadcast):
    """A request is new or has changed its state."""

    wire_name = "rogueRequestChanged"

    request: DeliveryRequest


class TraceLine(Broadcast):
    """One line of the conversation as the paper's Figure 6 prints it; ``seq`` counts from 1."""

    wire_name = "rogueTraceLine"

    seq: int
    time: float
    text: str


class ReadTrace(Query[list[TraceLine]]):
    """Ask for the trace lines after line ``after``, at most ``most`` of them.

    With ``since`` only for those that were said since: a time as people write it, ISO 8601 or
    ``HH:MM``, or so long ago: ``30m``, ``1h``.
    """

    wire_name = "rogueTrace"

    after: int = Field(default=0, ge=0)
    since: str | None = Field(default=None, max_length=64)
    most: int = Field(default=1000, ge=1, le=10_000)


class MonitorView(BaseModel):
    """Something that is watched, ``door r-5303`` say, for the sake of some open requests."""

    model_config = ConfigDict(frozen=True)

    watches: str
    requests: list[str]


class PlanView(BaseModel):
    """The search as it stands: the node lines printed so far, the steps executed, its goal tree.

    ``tree`` has the newest part of a very large tree. ``monitors`` are those that are on, since
    pending plans depend on what they watch.
    """

    model_config = ConfigDict(frozen=True)

    planning: bool
    nodes: list[str]
    executed: list[str]
    tree: GoalTree = GoalTree()
    monitors: list[MonitorView] = []


class ShowPlan(Query[PlanView]):
    """Ask for the search tree of the run that goes on, or of the last one."""

    wire_name = "roguePlan"


class WhyEntry(BaseModel):
    """One event of a request's story.

    ``time`` is None for what is so now; ``kind`` is that of `rogue.explain.Entry`; ``rule`` is
    the control rule that decided, or the planner's default, and ``over`` what else it could
    have chosen.
    """

    model_config = ConfigDict(frozen=True)

    time: float | None
    kind: str
    sentence: str
    rule: str = ""
    over: tuple[str, ...] = ()


class WhyReport(BaseModel):
    """What led a request to where it is, the oldest first: as lines with times, and as data."""

    model_config = ConfigDict(frozen=True)

    id: str
    sentences: list[str]
    entries: list[WhyEntry] = []


class Why(Query[WhyReport]):
    """Ask why a request stands where it does; with ``everything``, for each choice of the planner.

    Of each request the newest decisions are kept, the planner's routine choices least long.
    """

    wire_name = "rogueWhy"

    id: str = Field(pattern=REQUEST_ID_PATTERN)
    everything: bool = False
