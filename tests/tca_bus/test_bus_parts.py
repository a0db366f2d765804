"""The small parts: options, keys, mailbox, subscription, answers, handlers, envelope."""

from __future__ import annotations

import asyncio
import threading
from itertools import pairwise

import pytest

import tca_bus
from tca_bus import (
    Broadcast,
    BusOptions,
    ClosedError,
    Command,
    ConfigError,
    InvalidMessageError,
    Module,
    Query,
    Router,
    near_matches,
    near_or_all,
)
from tca_bus._answers import AnswerCache
from tca_bus._bridge import Answer, Arrivals, Mailbox
from tca_bus._envelope import handled, new_envelope, new_stamp, read_envelope
from tca_bus._handlers import Handlers
from tca_bus._keys import Keys, parse_query, parse_task
from tca_bus._parts import _no_source
from tca_bus._presence import PresentModule
from tca_bus._subscription import Subscription
from tca_bus._wire import Payload
from tca_bus.testing import eventually


class Ask(Query[int]):
    """Ask for a number."""


class Do(Command[None]):
    """Do it."""


class Hear(Broadcast):
    """Something is said."""


async def handle(message, context):
    return 1


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("connect", "127.0.0.1:7447"),
        ("connect", "tcp/127.0.0.1"),
        ("realm", "a/b"),
        ("realm", "*"),
        ("realm", ""),
        ("connect_timeout", -1),
        ("clock", "sundial"),
        ("colour", "red"),
    ],
)
def test_a_bad_option_is_a_config_error_that_names_it(option, value):
    with pytest.raises(ConfigError) as caught:
        BusOptions(**{option: value})
    assert caught.value.option == option
    assert caught.value.value == value


@pytest.mark.parametrize("name", ["", "a/b", "two words", "*", "-x"])
def test_a_module_name_is_one_chunk_of_a_key(name):
    with pytest.raises(ConfigError, match="module name"):
        Module(name)


def test_a_router_endpoint_is_checked_before_anything_listens():
    with pytest.raises(ConfigError, match="listen endpoint"):
        Router("localhost:7447")


def test_keys_begin_with_the_realm_and_name_the_sender():
    keys = Keys("xavier")
    callee = PresentModule("navigate", "01", "host", 7, ())
    key = keys.query(callee, "navigateWhere", "rogue")
    assert key == "xavier/query/navigate/01/navigateWhere/rogue"
    address = parse_query(key)
    assert (address.name, address.caller) == ("navigateWhere", "rogue")
    assert keys.one_way("inform", "xavierDrive", "navigate") == "xavier/inform/xavierDrive/navigate"
    assert parse_task(keys.task("rogue", "*")) == ("rogue", "*")
    assert parse_task(keys.all_tasks()) == ("*", "*")
    with pytest.raises(ValueError, match="no query key"):
        parse_query("xavier/query/navigate/01/too/many/parts")


def test_a_message_name_is_one_chunk_of_a_key():
    class Odd(Query[int]):
        wire_name = "a/b"

    async def answer(message, context):
        return 1

    with pytest.raises(ConfigError, match="wire name is 'a/b'"):
        Handlers().add(Odd, answer)


def test_only_the_beginning_of_an_endless_name_is_looked_at():
    assert near_matches("a" * 100 + "b" * 10_000, ["a" * 100, "c"]) == ["a" * 100]


def test_what_would_be_right_is_near_matches_or_else_what_there_is():
    assert near_or_all("rom", ["room", "hall"]) == " Did you mean 'room'?"
    assert near_or_all("zz", ["room", "hall"]) == " There are: hall, room."
    many = [f"r-{number:02d}" for number in range(50)]
    assert near_or_all("zz", many) == " There are 50, from 'r-00' to 'r-49'."
    assert near_or_all("zz", []) == ""


async def post_from_a_thread(box, items):
    thread = threading.Thread(target=lambda: [box.post(item) for item in items])
    thread.start()
    await asyncio.to_thread(thread.join)


async def test_a_mailbox_hands_over_everything_in_order():
    got: list[int] = []
    box = Mailbox[int](got.append, size=10_000)
    await post_from_a_thread(box, range(5000))
    await eventually(lambda: len(got) == 5000)
    assert got == list(range(5000))
    assert box.dropped == 0


async def test_a_full_mailbox_drops_the_oldest_and_counts():
    got: list[int] = []
    box = Mailbox[int](got.append, size=10)
    thread = threading.Thread(target=lambda: [box.post(item) for item in range(100)])
    thread.start()
    # The loop stands still meanwhile, on purpose.
    thread.join()
    await eventually(lambda: len(got) == 10)
    assert got == list(range(90, 100))
    assert box.dropped == 90


async def test_boxes_that_share_their_arrivals_queue_no_more_turns_than_items():
    got: list[int] = []
    arrivals = Arrivals(batch=1)
    few = Mailbox[int](got.append, size=2, arrivals=arrivals)
    many = Mailbox[int](got.append, size=10, arrivals=arrivals)
    thread = threading.Thread(target=lambda: [few.post(1), *map(many.post, range(10, 1000))])
    thread.start()
    thread.join()
    assert len(arrivals._turns) == 11
    few.post(2)
    await eventually(lambda: len(got) == 12)
    assert got == [1, *range(990, 1000), 2]


async def test_the_loop_gets_its_turn_after_many_messages_in_few_items():
    got: list[int] = []

    def take(item: int) -> int:
        got.append(item)
        return 100

    box = Mailbox[int](take, size=10)
    thread = threading.Thread(target=lambda: [box.post(item) for item in range(6)])
    thread.start()
    thread.join()
    seen: list[int] = []
    while len(got) < 6:
        await asyncio.sleep(0)
        seen.append(len(got))
    assert max(after - before for before, after in pairwise([0, *seen])) == 2


async def test_an_item_that_cannot_be_consumed_does_not_hold_up_the_next(caplog):
    got: list[float] = []
    box = Mailbox[int](lambda item: got.append(1 / item), size=10)
    await post_from_a_thread(box, [0, 1, 2])
    await eventually(lambda: got == [1.0, 0.5])
    assert "ZeroDivisionError" in caplog.text


async def test_a_full_mailbox_that_refuses_keeps_what_it_has():
    got: list[int] = []
    refused: list[int] = []
    box = Mailbox[int](got.append, size=10, refuse=refused.append)
    thread = threading.Thread(target=lambda: [box.post(item) for item in range(12)])
    thread.start()
    thread.join()
    await eventually(lambda: len(got) == 10)
    assert got == list(range(10))
    assert refused == [10, 11]
    assert box.dropped == 2


async def test_a_subscription_is_bounded_and_ends_when_closed():
    subscription = Subscription[int]("numbers", _no_source, size=3)
    async with subscription:
        for number in range(5):
            subscription.push(number)
        assert subscription.dropped == 2
        assert await subscription.get() == 2
        assert subscription.waiting == 2
        subscription.close()
        assert [number async for number in subscription] == [3, 4]
    with pytest.raises(ClosedError):
        await subscription.get()
    with pytest.raises(ClosedError):
        await subscription.__aenter__()


def answer(size):
    return Answer(Payload(b"x" * size, ""), is_error=False)


def test_answers_are_kept_until_there_are_too_many_or_too_much():
    cache = AnswerCache(most_answers=2, most_bytes=100)
    cache.put(("a", "1"), answer(10))
    cache.put(("a", "2"), answer(10))
    assert cache.get(("a", "1")) == answer(10)
    cache.put(("a", "3"), answer(10))
    assert cache.get(("a", "2")) is None
    cache.put(("a", "4"), answer(95))
    assert cache.get(("a", "3")) is None
    assert len(cache) == 1


def test_a_message_has_one_handler_and_only_services_are_announced():
    handlers = Handlers()
    handlers.add(Ask, handle)
    handlers.add(Hear, handle)
    handlers.add(Do, handle, built_in=True)
    assert handlers.provided() == ("ask",)
    with pytest.raises(ConfigError, match="no handler in this module yet"):
        handlers.add(Ask, handle)
    with pytest.raises(ConfigError, match="at least 1"):
        Handlers().add(Do, handle, capacity=0)
    with pytest.raises(ConfigError, match="async function"):
        Handlers().add(Do, lambda message, context: None)


def test_a_handlers_card_has_schemas_and_summary():
    card = Handlers().add(Ask, handle).card()
    assert (card.name, card.message_class, card.revision) == ("ask", "query", 1)
    assert card.summary == "Ask for a number."
    assert card.reply_schema == {"type": "integer"}


def test_the_trace_goes_on_from_the_handled_message():
    first = new_envelope("01")
    trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
    token = handled.set(first.model_copy(update={"task": "rogue-1", "traceparent": trace}))
    try:
        second = new_envelope("01")
    finally:
        handled.reset(token)
    assert second.task == "rogue-1"
    assert second.id != first.id
    assert first.traceparent is None
    assert second.traceparent == trace
    assert read_envelope(second.model_dump_json().encode()) == second


def test_a_stamp_is_an_id_and_the_envelope_with_it():
    first, second = new_stamp("01"), new_stamp("01")
    assert first.id != second.id
    envelope = read_envelope(first.attachment)
    assert (envelope.id, envelope.sender) == (first.id, "01")
    assert (envelope.task, envelope.traceparent) == (None, None)
    trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
    inside = envelope.model_copy(update={"task": 'a "task"', "traceparent": trace})
    token = handled.set(inside)
    try:
        below = read_envelope(new_stamp("02").attachment)
    finally:
        handled.reset(token)
    assert (below.sender, below.task, below.traceparent) == ("02", 'a "task"', trace)


def test_an_attachment_that_is_none_is_invalid():
    assert read_envelope(None).id
    with pytest.raises(InvalidMessageError, match="attachment"):
        read_envelope(b"\xff\x00")


async def test_a_module_that_is_not_open_says_so():
    module = Module("rogue")
    with pytest.raises(ClosedError):
        module.modules()
    with pytest.raises(ClosedError):
        await module.query(Ask())
    with pytest.raises(ClosedError):
        module.start(asyncio.sleep(0), name="too early")


def test_the_package_exports_what_it_names():
    assert sorted(set(tca_bus.__all__)) == sorted(tca_bus.__all__)
    for name in tca_bus.__all__:
        assert hasattr(tca_bus, name)
