"""Asking people: say what is wanted, then wait at the keyboard."""

from __future__ import annotations

from collections.abc import Sequence

from rogue import trace
from rogue.execution._effects import Part, Perform, Tell
from rogue.execution._patience import Patience
from rogue.outcomes import NOTHING, Outcome
from xavier_sim.messages import Ask, Say, Typed

YES = "y"
NO_ANSWER = "no_answer"


def ask(sentences: Sequence[str], question: Ask, patience: Patience) -> Part[Outcome]:
    """Say what is wanted and wait for an answer, again while nobody answers."""
    answer = NOTHING
    for _ in range(patience.asks):
        for sentence in sentences:
            yield from say(sentence)
        yield Tell("")
        answer = yield Perform(question)
        if answer.failure != NO_ANSWER:
            break
        yield Tell(trace.prompt_line(question.question, "(no answer)"))
    if answer.failed:
        yield Tell(trace.remark(answer.reason))
    else:
        yield Tell(trace.prompt_line(question.question, typed(answer)))
    return answer


def typed(answer: Outcome) -> str:
    """What was typed, of an answer that did not fail."""
    return Typed.model_validate(answer.value).answer


def say(sentence: str) -> Part[None]:
    """Say a sentence; one that cannot be said changes nothing."""
    yield Tell(trace.say_line(sentence))
    said = yield Perform(Say(text=sentence))
    if said.failed:
        yield Tell(trace.remark(said.reason))
