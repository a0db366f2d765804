"""Whether a day went as it should: a pure function of the script and of what was seen."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rogue.messages import DeliveryRequest, Refusal, RequestState
from rogue.outcomes import LAYERS
from rogue.scenarios._day_plan import DayPlan, Kind, Post


@dataclass(frozen=True, slots=True)
class Handover:
    """Somebody put an item on the tray or took it off; ``at`` is seconds from the start."""

    at: float
    action: str
    user: str
    item: str
    room: str


@dataclass(frozen=True, slots=True)
class Verified:
    """The robot came somewhere on its way to ``goal``: where, and which layer made sure.

    Both are None where nothing did.
    """

    goal: str
    room: str | None
    by: str | None


@dataclass(slots=True)
class DayRecord:
    """What was seen of a day.

    Attributes:
        refused: name of the refusal of a request that was not accepted, and its sentence.
        ended: every accepted request as it stands at the end.
        handovers: all of them, as they came.
        arrivals: all of them.
        begun: simulated seconds since the epoch at the start.
        seconds: simulated seconds that it took.
        metres: driven.
        kills: how often the planner was killed.
    """

    refused: dict[str, tuple[str, str]] = field(default_factory=dict)
    ended: dict[str, DeliveryRequest] = field(default_factory=dict)
    handovers: list[Handover] = field(default_factory=list)
    arrivals: list[Verified] = field(default_factory=list)
    begun: float = 0.0
    seconds: float = 0.0
    metres: float = 0.0
    kills: int = 0

    def outcome(self, request_id: str) -> str:
        """The state in which a request ended, ``refused`` if it was not accepted."""
        if request_id in self.refused:
            return f"refused: {self.refused[request_id][0]}"
        ended = self.ended.get(request_id)
        return ended.state.value if ended else "unknown"

    def reason(self, request_id: str) -> str:
        """Why it ended so."""
        if request_id in self.refused:
            return self.refused[request_id][1]
        ended = self.ended.get(request_id)
        return (ended.reason or "") if ended else ""


def faults(plan: DayPlan, record: DayRecord) -> list[str]:
    """Everything that went wrong, in words; empty when all went as it should."""
    return [
        *_unfit_ends(plan, record),
        *_missing_reasons(plan, record),
        *_wrong_hands(plan, record),
        *_left_on_tray(record),
    ]


def differences(plan: DayPlan, one: DayRecord, other: DayRecord) -> list[str]:
    """The requests that ended otherwise in another run of the same script, in words."""
    return [
        f"{post.id} ({post.kind}): {one.outcome(post.id)}, and then {other.outcome(post.id)}"
        f" ({other.reason(post.id) or 'no reason'})"
        for post in plan.posts
        if one.outcome(post.id) != other.outcome(post.id)
    ]


def counts(plan: DayPlan, record: DayRecord) -> Mapping[Kind, Counter[str]]:
    """How the requests of each kind ended."""
    found: dict[Kind, Counter[str]] = defaultdict(Counter)
    for post in plan.posts:
        found[post.kind][record.outcome(post.id)] += 1
    return found


def verification(record: DayRecord) -> dict[str, int]:
    """How many arrivals each layer made sure of, how many none, and how many were elsewhere."""
    by = Counter(one.by for one in record.arrivals)
    elsewhere = sum(one.room not in (one.goal, None) for one in record.arrivals)
    return {**{name: by[name] for name in LAYERS}, "unsure": by[None], "elsewhere": elsewhere}


def _unfit_ends(plan: DayPlan, record: DayRecord) -> Iterator[str]:
    for post in plan.posts:
        outcome, allowed = record.outcome(post.id), _allowed(plan, post, record)
        if outcome not in allowed:
            expected = " or ".join(sorted(allowed))
            reason = record.reason(post.id) or "no reason"
            yield f"{post.id} ({post.kind}) is {outcome}: {reason}; expected {expected}"


def _allowed(plan: DayPlan, post: Post, record: DayRecord) -> set[str]:
    too_late = "refused: too_late"
    completed, failed = RequestState.COMPLETED.value, RequestState.FAILED.value
    match post.kind:
        case Kind.MISNAMED:
            return {f"refused: {Refusal.UNKNOWN_ROOM.value}"}
        case Kind.HURRIED:
            return {too_late}
        case Kind.UNREACHABLE:
            return {failed}
        case Kind.CANCELED:
            canceled = {RequestState.CANCELED.value, too_late}
            return canceled | (_ended_before(plan, post, record))
    may_fail = {failed} if _meets_silence(plan, post) or post.kind is Kind.URGENT else set()
    return {completed, *may_fail} | ({too_late} if post.kind is Kind.URGENT else set())


def _ended_before(plan: DayPlan, post: Post, record: DayRecord) -> set[str]:
    """What is right for a request that was over before its user took it back."""
    ended, back = record.ended.get(post.id), plan.taken_back(post.id)
    can_fail = {RequestState.FAILED.value} if _meets_silence(plan, post) else set()
    if ended is None or back is None or ended.finished is None or back.at is None:
        return can_fail
    in_time = ended.finished - record.begun <= back.at
    return {RequestState.COMPLETED.value, *can_fail} if in_time else set()


def _meets_silence(plan: DayPlan, post: Post) -> bool:
    return bool({post.pickup, post.deliver} & plan.silent)


def _missing_reasons(plan: DayPlan, record: DayRecord) -> Iterator[str]:
    silent_ends = {RequestState.COMPLETED.value}
    for post in plan.posts:
        outcome = record.outcome(post.id)
        if outcome not in silent_ends and not record.reason(post.id):
            yield f"{post.id} is {outcome} without a reason"


def _wrong_hands(plan: DayPlan, record: DayRecord) -> Iterator[str]:
    """Each item is put on the tray where it lay, once, and taken where it belongs, once."""
    posts = {(post.user, post.item): post for post in plan.posts}
    for thing, story in _stories(record.handovers).items():
        post = posts.get(thing)
        if post is None:
            yield f"nobody had asked for {thing[1]} of {thing[0]}"
            continue
        yield from _wrong_story(post, story, record.outcome(post.id))
    for post in plan.posts:
        story = _stories(record.handovers).get((post.user, post.item), [])
        is_completed = record.outcome(post.id) == RequestState.COMPLETED.value
        if is_completed and [one.action for one in story] != ["placed", "taken"]:
            yield f"{post.id} is completed, but was handed over so: {_told(story)}"


def _wrong_story(post: Post, story: Sequence[Handover], outcome: str) -> Iterator[str]:
    actions = [one.action for one in story]
    if actions not in (["placed"], ["placed", "taken"]):
        yield f"{post.id}: the item was handed over so: {_told(story)}"
    if story[0].room != post.pickup:
        yield f"{post.id}: put on the tray at {story[0].room}, it lay at {post.pickup}"
    if len(story) > 1 and story[1].room not in _places(post, outcome):
        yield f"{post.id} ({outcome}): taken at {story[1].room}"


def _places(post: Post, outcome: str) -> set[str]:
    is_completed = outcome == RequestState.COMPLETED.value
    return {post.deliver} if is_completed else {post.deliver, post.pickup}


def _stories(handovers: Sequence[Handover]) -> dict[tuple[str, str], list[Handover]]:
    stories: dict[tuple[str, str], list[Handover]] = defaultdict(list)
    for one in handovers:
        stories[one.user, one.item].append(one)
    return stories


def _told(story: Sequence[Handover]) -> str:
    return ", ".join(f"{one.action} at {one.room}" for one in story) or "not at all"


def _left_on_tray(record: DayRecord) -> Iterator[str]:
    """What stays on the tray is said in the reason of its request."""
    reasons = {(one.user, one.item): one.reason or "" for one in record.ended.values()}
    for thing, story in _stories(record.handovers).items():
        if story[-1].action == "placed" and "tray" not in reasons.get(thing, ""):
            yield f"{thing[1]} of {thing[0]} was left on the tray, and nobody was told"
