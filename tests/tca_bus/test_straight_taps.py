"""Taps on queries, informs and broadcasts, which do not pass central."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import pytest
from pydantic import BaseModel

from tca_bus import (
    BusOptions,
    Command,
    ConfigError,
    Inform,
    Module,
    Query,
    RefusedError,
    TapCondition,
    TapNotice,
    TaskContext,
    TaskError,
    catch,
    tap,
)
from tca_bus._keys import Keys, parse_presence
from tca_bus._presence import PresentModule, TapWord
from tca_bus._tapping import TellTap
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


class Place(BaseModel):
    """Where something is."""

    x: float


class Where(Query[Place]):
    """Ask for the place."""

    who: str = "xavier"


class Spoke(Inform):
    """Something was said."""

    text: str


class Heard(Inform):
    """A listener with the fields of the reply."""

    x: float


class Noted(TapNotice, Inform):
    """A listener that is told everything."""


class Allow(TapNotice, Command[None]):
    """Say whether a message may be handled."""


@pytest.fixture
async def options() -> AsyncIterator[BusOptions]:
    async with bus() as options, central(options):
        yield options


@pytest.fixture
async def robot(options: BusOptions) -> AsyncIterator[Module]:
    module = Module("robot", options=options)

    @module.handler(Where)
    async def where(question: Where, _: Any) -> Place:
        if question.who == "nobody":
            raise TaskError("unknown", "no such robot")
        return Place(x=4.5)

    @module.handler(Spoke)
    async def spoke(_: Spoke, __: Any) -> None:
        pass

    async with module:
        yield module


class Listener:
    """A module that taps and notes."""

    def __init__(self, options: BusOptions) -> None:
        self.module = Module("listener", options=options)
        self.heard: list[Any] = []
        self.allows = True
        self.module.serve(Heard, self.note)
        self.module.serve(Noted, self.note)
        self.module.serve(Allow, self.allow)

    async def note(self, message: Any, _: Any) -> None:
        self.heard.append(message)

    async def allow(self, notice: Allow, _: TaskContext) -> None:
        self.heard.append(notice)
        if not self.allows:
            raise TaskError("not_now", "the floor is wet")


@pytest.fixture
async def listener(options: BusOptions, robot: Module) -> AsyncIterator[Listener]:
    listener = Listener(options)
    async with listener.module as module:
        await module.wait_for(Where, Spoke, Heard, Noted, Allow, timeout=10.0)
        await robot.wait_for(Heard, timeout=10.0)
        yield listener


async def tapped(module: Module, by: str = "listener", *, times: int = 1) -> None:
    """Wait until a module knows of so many taps."""
    await eventually(lambda: times == sum(len(m.taps) for m in module.modules() if m.name == by))


async def test_a_reply_is_given_to_the_listener(robot: Module, listener: Listener):
    await listener.module.attach(tap("AfterReplied", Heard), to=Where)
    await tapped(robot)
    assert (await listener.module.query(Where())).x == 4.5
    await eventually(lambda: listener.heard == [Heard(x=4.5)])


async def test_what_is_sent_and_what_failed_is_told(robot: Module, listener: Listener):
    await listener.module.attach(tap("WhenSent", Noted), to=Spoke)
    await listener.module.attach(tap("AfterHandled", Noted), to=Where)
    await tapped(robot, times=2)
    await robot.inform(Spoke(text="hello"))
    await eventually(lambda: len(listener.heard) == 1)
    with pytest.raises(Exception, match="no such robot"):
        await listener.module.query(Where(who="nobody"))
    await eventually(lambda: len(listener.heard) == 2)
    sent, handled = listener.heard
    assert (sent.message, sent.data, sent.sender) == ("spoke", {"text": "hello"}, "robot")
    assert handled.failure["name"] == "unknown"


async def test_a_blocking_tap_lets_pass_or_refuses(robot: Module, listener: Listener):
    allow = tap("BeforeHandling", Allow, on_failure="fail")
    async with await listener.module.attach(allow, to=Where):
        await tapped(robot)
        assert (await robot.query(Where())).x == 4.5
        listener.allows = False
        with pytest.raises(RefusedError, match="the floor is wet"):
            await robot.query(Where())
        assert len(listener.heard) == 2
    await eventually(lambda: not any(m.taps for m in robot.modules()))
    assert (await robot.query(Where())).x == 4.5


async def test_a_tapper_that_is_gone_holds_nothing(
    robot: Module, options: BusOptions, listener: Listener
):
    other = Listener(options)
    other.module = Module("other", options=options)
    async with other.module as module:
        await module.attach(tap("BeforeHandling", Allow), to=Where)
        await tapped(robot, by="other")
    assert (await robot.query(Where(), timeout=10.0)).x == 4.5


async def test_of_a_message_only_those_are_believed_who_have_part_in_it(
    robot: Module, options: BusOptions, listener: Listener
):
    await listener.module.attach(tap("AfterHandled", Noted), to=Where)
    await listener.module.attach(tap("WhenSent", Noted), to=Spoke)
    handled = TapNotice(
        condition=TapCondition.AFTER_HANDLED, message="where", data={}, sender="user"
    )
    sent = TapNotice(condition=TapCondition.WHEN_SENT, message="spoke", data={}, sender="robot")
    async with Module("liar", options=options) as liar:
        await liar.wait_for(Where, Spoke, Noted, timeout=10.0)
        with pytest.raises(RefusedError, match="only by who handles it"):
            await liar.query(TellTap(notice=handled), to="listener")
        with pytest.raises(RefusedError, match="only by its sender"):
            await liar.query(TellTap(notice=sent), to="listener")
    assert listener.heard == []
    await robot.query(TellTap(notice=sent), to="listener")
    await eventually(lambda: len(listener.heard) == 1)


async def test_what_cannot_be_tapped_so_is_refused(listener: Listener):
    with pytest.raises(ConfigError, match="AfterReplied"):
        await listener.module.attach(tap("WhenAchieved", Allow), to=Where)
    with pytest.raises(ConfigError, match="another message"):
        await listener.module.attach(tap("WhenSent", Spoke), to=Spoke)
    with pytest.raises(ConfigError, match="a tap"):
        await listener.module.attach(catch(by="x"), to=Where)


def test_a_token_names_the_taps_of_its_module():
    taps = (TapWord("WhenSent", "*"), TapWord("BeforeHandling", "whereAmI", fails=True))
    module = PresentModule("a", "1", "host", 7, ("x",), number=3, taps=taps)
    assert parse_presence(Keys("xavier").presence(module)) == module
