"""The story of a request: how it came to stand where it does, from what was recorded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rogue.explain._decision import Decision, DecisionKind
from rogue.explain._sentences import in_words, put_off, sentence, verified
from rogue.explain._words import plain
from rogue.times import show_time

if TYPE_CHECKING:
    from rogue.messages import DeliveryRequest, Filled, StepView

_SOURCES = {
    "directory": "from the people directory",
    "finger": "from the user's finger server",
    "default": "by default",
    "answer": "as somebody answered",
}


@dataclass(frozen=True, slots=True)
class Entry:
    """One event of a story.

    Attributes:
        time: Seconds since the epoch; None for what is so now.
        kind: ``posted``, ``filled``, a `DecisionKind`, ``begun``, ``done``, ``failed``,
            ``noted``, ``ended``, ``forgotten`` or ``now``.
        sentence: For people.
        rule: Name of the rule that decided, empty where none did.
        over: What else could have been chosen.
    """

    time: float | None
    kind: str
    sentence: str
    rule: str = ""
    over: tuple[str, ...] = ()


_Event = tuple[float, Entry]
"""An entry with its place among those of the same time."""


@dataclass(frozen=True, kw_only=True)
class Record:
    """All that is known of a request.

    Attributes:
        request: As it stands.
        filled: What its user left out.
        decisions: What was decided about it, the oldest first.
        forgotten: How many decisions are not kept any more.
        steps: What was carried out for it.
        notes: Times and sentences.
        hold: Until when it is put off, and why; None if it is not.
        others: The open requests.
    """

    request: DeliveryRequest
    filled: Sequence[Filled] = ()
    decisions: Sequence[Decision] = ()
    forgotten: int = 0
    steps: Sequence[StepView] = ()
    notes: Sequence[tuple[float, str]] = ()
    hold: tuple[float, str] | None = None
    others: Sequence[DeliveryRequest] = ()


def story(record: Record, *, everything: bool = False) -> list[Entry]:
    """Return the story of a request, the oldest event first, and how it stands now.

    With ``everything`` also the planner's routine choices.
    """
    request = record.request
    events = [(-2.0, Entry(request.posted, "posted", _posted(request)))]
    events += [(-1.0, Entry(request.posted, "filled", _filled(one))) for one in record.filled]
    events += _decided(record.decisions, everything=everything)
    events += _carried_out(record.steps, record.decisions)
    events += [
        (float(len(record.decisions)), Entry(time, "noted", _closed(_capital(text))))
        for time, text in record.notes
        if text != request.reason
    ]
    events.sort(key=lambda event: (event[1].time or 0.0, event[0]))
    entries = [entry for _, entry in events]
    if record.forgotten:
        entries.insert(1, _forgotten(record.forgotten))
    return [*entries, _standing(record)]


def _decided(decisions: Sequence[Decision], *, everything: bool) -> list[_Event]:
    events: list[_Event] = []
    is_planned = False
    for at, one in enumerate(decisions):
        if everything or not one.is_routine:
            said = sentence(one, again=is_planned)
            events.append((float(at), Entry(one.time, one.kind.value, said, one.rule, one.over)))
        is_planned = is_planned or one.kind is DecisionKind.PLANNED
    return events


def _carried_out(steps: Sequence[StepView], decisions: Sequence[Decision]) -> list[_Event]:
    """What became of each step, told behind the decision for it."""
    events: list[_Event] = []
    left = [
        (at, one.chosen.strip("<>")) for at, one in enumerate(decisions)
        if one.kind is DecisionKind.STEP
    ]  # fmt: skip
    for step in steps:
        own = next((one for one in left if one[1] == step.operator), None)
        if own is not None:
            left = left[left.index(own) + 1 :]
        at = own[0] + 0.5 if own else float(len(decisions))
        events += [(at, entry) for entry in _step(step, is_told=own is not None)]
    return events


def told(entries: Iterable[Entry]) -> list[str]:
    """Return a story as lines, each begun with its time."""
    return [
        entry.sentence if entry.time is None else f"{show_time(entry.time)}: {entry.sentence}"
        for entry in entries
    ]


def _posted(request: DeliveryRequest) -> str:
    return (
        f"{request.user} asked for {request.item} from {request.pickup} to {request.deliver} "
        f"by {show_time(request.deadline)}; it ranks {request.rank}."
    )


def _filled(one: Filled) -> str:
    value = one.value
    return f"The {one.slot} was left out; it is {value}, {_SOURCES.get(one.source, one.source)}."


def _step(step: StepView, *, is_told: bool) -> list[Entry]:
    """What became of a step; that it was begun only where no decision tells of it."""
    words = _capital(in_words(f"<{step.operator}>"))
    if step.ended is None:
        return [Entry(step.started, "begun", f"{words} is under way.")]
    begun = [] if is_told else [Entry(step.started, "begun", f"{words} was begun.")]
    if step.state == "done":
        return [*begun, Entry(step.ended, "done", f"{words} was done{verified(step.arrivals)}.")]
    reason = f": {step.outcome}" if step.outcome else ""
    reason += verified(step.arrivals)
    return [*begun, Entry(step.ended, "failed", _closed(f"{words} did not succeed{reason}"))]


def _forgotten(count: int) -> Entry:
    noun = "choice was" if count == 1 else "choices were"
    return Entry(None, "forgotten", f"({count} older {noun} not kept.)")


def _standing(record: Record) -> Entry:
    request = record.request
    match request.state:
        case "completed":
            return Entry(request.finished, "ended", "It was delivered.")
        case "failed":
            return Entry(request.finished, "ended", _closed(f"It failed: {request.reason}"))
        case "canceled":
            return Entry(request.finished, "ended", _closed(f"It is canceled: {request.reason}"))
    return Entry(None, "now", _now(record))


def _now(record: Record) -> str:
    request = record.request
    if request.closing is not None:
        end = f"It will be {request.closing.state.value} ({request.closing.reason})"
        return f"{end} when its item is in {request.destination}."
    warning = f" {_closed(_capital(request.warning))}" if request.warning else ""
    if record.hold is not None:
        until, reason = record.hold
        return put_off("It waits", until, reason) + warning
    if request.state == "underway":
        return f"It is being served.{warning}"
    ahead = [f"{one.id} (rank {one.rank})" for one in record.others if _is_ahead(one, request)]
    begun = "It was begun and put aside" if request.state == "suspended" else "It waits"
    if not ahead:
        return f"{begun}; nothing is being done before it.{warning}"
    return f"{begun} while the robot serves {', '.join(ahead)}.{warning}"


def _is_ahead(other: DeliveryRequest, request: DeliveryRequest) -> bool:
    return other.state == "underway" and other.id != request.id


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _closed(text: str) -> str:
    text = plain(text)
    return text if text.endswith((".", "!", "?")) else f"{text}."
