"""When the world is quiet enough for time to go on: pure rules."""

from __future__ import annotations

import pytest

from tca_bus import AwaitTime, Settled
from xavier_sim.running._quiet import ASK_AGAIN, Quiet
from xavier_sim.running._simulated_time import HOLD_LIMIT


def here(_incarnation):
    return True


def wait(name, until=None):
    return AwaitTime(module=name, incarnation=name, until=until, moves=False)


def answer(name, number=0):
    return Settled(module=name, incarnation=name, number=number)


@pytest.fixture
def quiet():
    """Two modules follow the time, and all is quiet."""
    quiet = Quiet()
    quiet.take(answer("a"))
    quiet.take(answer("b"))
    return quiet


def test_nobody_is_asked_while_nothing_happens(quiet):
    assert quiet.is_quiet
    assert quiet.question(0.0, here) is None


def test_time_waits_until_all_have_taken_what_happened(quiet):
    quiet.stir()
    assert not quiet.is_quiet
    assert quiet.question(0.0, here) == 1
    assert quiet.question(0.1, here) is None
    quiet.take(answer("a", 1))
    assert not quiet.is_quiet
    quiet.take(answer("b", 1))
    assert quiet.is_quiet


def test_an_answer_to_an_earlier_question_does_not_count(quiet):
    quiet.stir()
    quiet.question(0.0, here)
    quiet.stir()
    assert quiet.question(0.1, here) == 2
    quiet.take(answer("a", 1))
    quiet.take(answer("b", 2))
    assert not quiet.is_quiet
    quiet.take(answer("a", 2))
    assert quiet.is_quiet


def test_what_somebody_waits_for_stirs_only_when_it_is_new(quiet):
    quiet.hear(wait("a", 5.0))
    assert quiet.question(0.0, here) == 1
    quiet.take(answer("a", 1))
    quiet.take(answer("b", 1))
    quiet.hear(wait("a", 5.0))
    assert quiet.is_quiet
    quiet.hear(wait("a"))
    assert not quiet.is_quiet


def test_a_question_is_repeated_that_was_not_answered_by_all(quiet):
    quiet.stir()
    assert quiet.question(0.0, here) == 1
    quiet.take(answer("b", 1))
    assert quiet.question(ASK_AGAIN, here) == 1


def test_who_is_gone_or_does_not_answer_is_not_waited_for(quiet):
    quiet.stir()
    quiet.question(0.0, here)
    assert quiet.question(0.1, lambda one: one == "a") is None
    assert not quiet.is_quiet
    assert quiet.give_up(HOLD_LIMIT - 0.1) == []
    assert quiet.give_up(HOLD_LIMIT) == ["a"]
    assert quiet.is_quiet
    quiet.stir()
    assert quiet.question(HOLD_LIMIT, here) is None
    assert quiet.is_quiet
