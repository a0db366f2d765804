"""The presence table: a lost router is not a lost module."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from tca_bus import Module, PresenceChange, PresentModule
from tca_bus._keys import Keys, parse_presence
from tca_bus._presence import LONGEST_RECONNECT, RECONNECT_GRACE, VANISH_GRACE, PresenceTable
from tca_bus._token_watch import Listing
from tca_bus.testing import bus, eventually


def module(name="navigate", incarnation="01", provides=("navigateToG",)):
    return PresentModule(name, incarnation, "host", 7, provides)


def test_a_token_is_a_module_until_it_has_been_gone_for_the_grace():
    table = PresenceTable()
    assert table.put(module(), now=0.0) == [PresenceChange(module(), appeared=True)]
    assert table.put(module(), now=0.0) == []
    table.delete(module(), now=10.0)
    assert table.state_of("01") is None
    assert table.expire(10.0 + VANISH_GRACE / 2) == []
    assert table.expire(10.0 + VANISH_GRACE) == [PresenceChange(module(), appeared=False)]
    assert table.state_of("01") is False
    assert table.modules() == []


def test_when_the_router_is_lost_nobody_is_lost_before_it_is_back():
    table = PresenceTable(own="me")
    table.put(module(), now=0.0)
    table.put(module("rogue", "me"), now=0.0)
    table.delete(module(), now=1.0)
    table.router_lost()
    assert table.expire(1e9) == []
    assert table.state_of("me") is True
    table.router_back(now=2e9)
    assert table.put(module(), now=0.0) == []
    assert table.expire(2e9 + RECONNECT_GRACE) == []
    assert table.state_of("01") is True


def test_who_does_not_come_back_with_the_router_is_lost():
    table = PresenceTable()
    table.put(module(), now=0.0)
    table.router_lost()
    table.router_back(now=5.0)
    assert table.next_expiry() == 5.0 + RECONNECT_GRACE
    assert table.expire(5.0 + RECONNECT_GRACE) == [PresenceChange(module(), appeared=False)]


def test_with_direct_links_only_those_whose_tokens_vanish_are_suspect():
    table = PresenceTable(own="me")
    table.put(module("a", "01"), now=0.0)
    table.put(module("b", "02"), now=0.0)
    table.delete(module("a", "01"), now=1.0)
    table.router_lost(is_direct=True)
    table.put(module("c", "03"), now=0.0)
    table.delete(module("c", "03"), now=2.0)
    assert [table.state_of(key) for key in ("01", "02", "03")] == [None, True, None]
    assert table.next_expiry() == float("inf")
    table.router_back(now=5.0)
    lost = table.expire(5.0 + RECONNECT_GRACE)
    assert [change.module.name for change in lost] == ["a", "c"]


def test_what_is_looked_up_follows_every_change():
    table = PresenceTable()
    assert table.named("navigate") is None
    table.put(module(incarnation="01"), now=0.0)
    assert table.named("navigate") == module(incarnation="01")
    assert table.providers("navigateToG") == [module(incarnation="01")]
    table.put(module(incarnation="02", provides=()), now=0.0)
    assert table.named("navigate") == module(incarnation="02", provides=())
    assert table.providers("navigateToG") == []
    table.delete(module(incarnation="02", provides=()), now=0.0)
    table.expire(VANISH_GRACE)
    assert table.named("navigate") == module(incarnation="01")
    assert table.providers("navigateToG") == [module(incarnation="01")]


def test_the_newest_incarnation_answers():
    table = PresenceTable()
    table.put(module(incarnation="01"), now=0.0)
    table.put(module(incarnation="02"), now=0.0)
    assert table.named("navigate") == module(incarnation="02")
    assert table.providers("navigateToG") == [module(incarnation="02")]
    assert table.has_provider("navigateToG")
    table.delete(module(incarnation="02"), now=0.0)
    assert not table.has_provider("navigateToG")


def test_an_incarnation_of_a_clock_that_was_set_back_is_asked_after_the_grace_of_the_dead_one():
    table = PresenceTable()
    table.put(module(incarnation="09"), now=0.0)
    table.delete(module(incarnation="09"), now=5.0)
    table.put(module(incarnation="01"), now=0.0)
    assert not table.has_provider("navigateToG")
    table.expire(5.0 + VANISH_GRACE)
    assert table.providers("navigateToG") == [module(incarnation="01")]


def test_a_token_that_its_module_replaced_may_vanish():
    table = PresenceTable()
    table.put(module(provides=()), now=0.0)
    changed = module(provides=("navigateToG",))
    assert table.put(changed, now=0.0) == [PresenceChange(changed, appeared=True)]
    table.delete(module(provides=()), now=0.0)
    assert table.state_of("01") is True


def test_a_certain_provider_comes_before_a_suspect():
    table = PresenceTable()
    table.put(module("a", "01"), now=0.0)
    table.put(module("b", "02"), now=0.0)
    table.delete(module("a", "01"), now=0.0)
    assert [entry.name for entry in table.providers("navigateToG")] == ["b", "a"]


def test_the_next_start_of_a_module_ends_the_wait_for_the_one_before():
    table = PresenceTable()
    table.put(module(incarnation="01"), now=0.0)
    table.delete(module(incarnation="01"), now=1.0)
    assert table.put(module(incarnation="02"), now=1.1) == [
        PresenceChange(module(incarnation="01"), appeared=False),
        PresenceChange(module(incarnation="02"), appeared=True),
    ]


def test_a_module_whose_next_start_is_there_is_lost_with_its_token():
    table = PresenceTable()
    table.put(module(incarnation="01"), now=0.0)
    table.put(module(incarnation="02"), now=0.0)
    table.delete(module(incarnation="01"), now=1.0)
    assert table.expire(1.0) == [PresenceChange(module(incarnation="01"), appeared=False)]


def test_while_others_come_back_with_the_router_nobody_is_given_up():
    table = PresenceTable()
    crowd = [module(f"crew-{number}", f"{number:02}") for number in range(20)]
    for one in crowd:
        table.put(one, now=0.0)
    table.router_lost()
    table.router_back(now=1.0)
    step = RECONNECT_GRACE / 2
    for number, one in enumerate(crowd[:-1]):
        now = 1.0 + step * (number + 1)
        assert table.put(one, now=now) == []
        assert table.expire(now) == []
    assert table.expire(now + RECONNECT_GRACE) == [PresenceChange(crowd[-1], appeared=False)]


def test_a_stream_of_returns_does_not_keep_the_lost_for_ever():
    table = PresenceTable()
    step = RECONNECT_GRACE / 2
    stream = [module("late", f"{n:03}") for n in range(1, 3 + int(LONGEST_RECONNECT / step))]
    for one in (module("gone", "000"), *stream):
        table.put(one, now=0.0)
    table.router_lost()
    table.router_back(now=0.0)
    lost = []
    for number, one in enumerate(stream):
        table.put(one, now=number * step)
        lost += table.expire(number * step)
    assert [change.module.name for change in lost] == ["gone"]


def test_who_was_listed_has_to_announce_itself():
    table = PresenceTable(own="me")
    listed = [module(incarnation="01"), module("rogue", "me")]
    assert [change.appeared for change in table.expect(listed, now=0.0)] == [True, True]
    assert (table.state_of("01"), table.state_of("me")) == (None, True)
    assert table.put(module(incarnation="01"), now=0.1) == []
    assert table.state_of("01") is True
    assert table.next_expiry() == float("inf")


@pytest.mark.bus
async def test_events_in_the_wrong_order_bury_nobody():
    async with (
        bus() as options,
        Module("watcher", options=options) as watcher,
        Module("other", options=options) as other,
        watcher.watch_modules() as changes,
    ):
        feed = watcher._open.core.presence
        await eventually(lambda: feed.table.state_of(other.incarnation))
        # All tokens are back already when the loss of the router is told.
        feed.transport_changed(False)
        feed.transport_changed(True)
        assert feed.table.state_of(other.incarnation) is None
        await eventually(lambda: feed.table.state_of(other.incarnation))
        assert {(await changes.get()).appeared for _ in range(2)} == {True}
        assert changes.waiting == 0


@pytest.mark.bus
async def test_a_router_that_does_not_answer_buries_nobody(monkeypatch):
    async with (
        bus() as options,
        Module("watcher", options=options) as watcher,
        Module("other", options=options) as other,
    ):
        feed = watcher._open.core.presence
        await eventually(lambda: feed.table.state_of(other.incarnation))
        asked = []

        def answer_nothing(timeout, done):
            asked.append(timeout)
            done(Listing(is_whole=False))

        with monkeypatch.context() as silent:
            silent.setattr(feed._tokens, "ask", answer_nothing)
            feed.transport_changed(False)
            feed.transport_changed(True)
            await eventually(lambda: len(asked) > 2)
            assert feed.table.state_of(other.incarnation) is None
        await eventually(lambda: feed.table.state_of(other.incarnation))


def test_the_key_of_a_token_gives_the_module_back():
    keys = Keys("xavier")
    for entry in (module(), module(provides=()), module(provides=("a.b", "C_say"))):
        assert parse_presence(keys.presence(entry)) == entry


@pytest.mark.parametrize("key", ["xavier/presence/x", "xavier/presence/a/01/h/zero/-", "x"])
def test_a_token_of_another_shape_is_refused_by_its_key(key):
    with pytest.raises(ValueError, match=f"'{key}' is no presence key: expected"):
        parse_presence(key)


class Tokens(RuleBasedStateMachine):
    """Any order of events: nobody is reported lost twice, nor while the router is away."""

    def __init__(self):
        super().__init__()
        self.table = PresenceTable()
        self.now = 0.0
        self.is_up = True
        self.known = set()

    @rule(who=st.sampled_from("abc"))
    def put(self, who):
        for change in self.table.put(module(who, who), self.now):
            assert change.appeared
            self.known.add(who)

    @rule(who=st.sampled_from("abc"))
    def delete(self, who):
        self.table.delete(module(who, who), self.now)

    @precondition(lambda self: self.is_up)
    @rule()
    def lose_router(self):
        self.table.router_lost()
        self.is_up = False

    @precondition(lambda self: not self.is_up)
    @rule()
    def regain_router(self):
        self.table.router_back(self.now)
        self.is_up = True

    @rule(seconds=st.floats(0.0, 5.0))
    def wait(self, seconds):
        self.now += seconds
        for change in self.table.expire(self.now):
            assert self.is_up
            self.known.remove(change.module.name)

    @invariant()
    def the_table_has_whom_it_announced(self):
        assert {entry.name for entry in self.table.modules()} == self.known


TestTokens = Tokens.TestCase
