"""Finger: what servers say, how they are asked, and what follows for a request."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rogue_fakes import FakeModule, reception

from rogue.errors import FingerError, MissingRoomError, RequestError, UnknownNameError
from rogue.memory import Store
from rogue.messages import DeliveryRequest, Filled, PostRequest
from rogue.requests import (
    FingerServer,
    Reception,
    finger,
    finger_server,
    load_directory,
    read_entries,
    read_plan,
)
from tca_bus import ConfigError

ROOMS = [f"r-53{number:02d}" for number in range(1, 16)]
REPLY = (
    "Login: tom             \t\t\tName: Tom Jones\r\n"
    "Directory: /usr/tom                 \tShell: /bin/tcsh\r\n"
    "Office: Wean Hall 5307, x8-2611\t\tHome Phone: 555-1234\r\n"
    "On since Mon Mar  4 09:00 (EST) on ttyp1\r\n"
    "No Mail.\r\n"
    "Plan:\r\n"
    "I may be in the lab. Pickup delivermail: 5309 please\r\n"
    "Pickup  pickupfax : r-5305\r\n"
    "Deadline: 45m\r\n"
)

Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


@asynccontextmanager
async def serving(serve: Serve) -> AsyncIterator[FingerServer]:
    async def handle(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await serve(reader, writer)
        writer.close()

    async with await asyncio.start_server(handle, "127.0.0.1", 0) as server:
        yield FingerServer("127.0.0.1", server.sockets[0].getsockname()[1])


def replies(known: dict[str, str], asked: list[str] | None = None) -> Serve:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        user = (await reader.readline()).decode().removesuffix("\r\n")
        if asked is not None:
            asked.append(user)
        writer.write(known.get(user, f"finger: {user}: no such user.\r\n").encode())
        await writer.drain()

    return serve


def test_a_plan_is_read_for_name_room_ends_and_deadline():
    plan = read_plan(REPLY, "tom")
    assert plan is not None
    assert (plan.name, plan.room, plan.deadline) == ("Tom Jones", "Wean Hall 5307, x8-2611", "45m")
    assert plan.ends == {("pickup", "pickupfax"): "r-5305"}


@pytest.mark.parametrize(
    "reply",
    [
        "finger: tom: no such user.\r\n",
        "Login name: tom       In real life: ???\r\n",
        "",
        "Login: tommy\t\t\tName: Tommy\r\nOffice: 5301\r\n",
        "Office: 53\x1b[2J07\r\n",
    ],
)
def test_what_says_nothing_of_the_user_is_nothing(reply):
    assert read_plan(reply, "tom") is None


def test_of_several_accounts_the_one_of_that_login_counts():
    plan = read_plan("Login: tommy   Name: Tommy\nOffice: 5301\n" + REPLY, "tom")
    assert plan is not None
    assert plan.name == "Tom Jones"
    assert plan.room == "Wean Hall 5307, x8-2611"


def test_the_users_own_word_for_their_room_counts_before_the_accounts():
    plan = read_plan("Login: tom\nOffice: 5301\nPlan:\nroom: 5311\n", "tom")
    assert plan is not None
    assert plan.room == "5311"


@given(st.binary(max_size=400))
def test_any_bytes_are_read_or_passed_over(noise: bytes):
    text = noise.decode("utf-8", errors="replace")
    plan = read_plan(text, "tom")
    told = [] if plan is None else [plan.name, plan.room, plan.deadline, *plan.ends.values()]
    assert all(one is None or one.isprintable() for one in told)
    framed = read_plan(f"{REPLY}\n{text}", "tom")
    assert framed is None or framed.ends["pickup", "pickupfax"]


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [("finger.cs", "finger.cs", 79), ("10.0.0.2:7979", "10.0.0.2", 7979), ("[::1]:79", "::1", 79)],
)
def test_an_address_is_a_host_and_perhaps_a_port(text, host, port):
    server = finger_server(text)
    assert (server.host, server.port) == (host, port)
    assert finger_server(str(server)) == server


@pytest.mark.parametrize("text", ["", "a b", "host:", "host:0", "host:70000", "::1", "tom@host"])
def test_what_is_no_address_is_refused(text):
    with pytest.raises(ConfigError, match="HOST or HOST:PORT"):
        finger_server(text)


async def test_the_server_is_sent_the_name_and_nothing_else():
    asked: list[str] = []
    async with serving(replies({"tom": REPLY}, asked)) as server:
        assert await finger("tom", server) == REPLY
        for name in ("tom@elsewhere", "/W tom", "tom\r\nroot", "", "-l"):
            assert await finger(name, server) is None
    assert asked == ["tom"]


async def test_a_server_that_never_answers_is_given_up():
    async def silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        del writer
        await reader.read()

    async with serving(silent) as server:
        with pytest.raises(FingerError, match=r"did not answer within 0\.05 s"):
            await finger("tom", server, patience=0.05)


async def test_a_server_that_says_too_much_is_not_listened_to():
    async with serving(replies({"tom": "Office: 5301\n" * 100})) as server:
        with pytest.raises(FingerError, match="more than 1000 bytes"):
            await finger("tom", server, most=1000)


async def test_a_server_that_is_not_there_is_named():
    async with serving(replies({})) as server:
        pass
    with pytest.raises(FingerError, match=f"{server} cannot be asked"):
        await finger("tom", server)


async def complete(desk: Reception, **fields: object) -> tuple[DeliveryRequest, list[str]]:
    values = {"id": "a", "user": "tom", "item": "delivermail", **fields}
    request, filled = await desk.complete(
        PostRequest.model_validate(values), rooms=ROOMS, now=1000.0
    )
    return request, [_told(one) for one in filled]


def _told(filled: Filled) -> str:
    return f"{filled.slot} {filled.value} {filled.source}"


async def test_whom_only_finger_knows_is_known_from_then_on(tmp_path: Path):
    async with Store(tmp_path) as store:
        async with serving(replies({"tom": REPLY})) as server:
            desk = reception(FakeModule(), store, load_directory(), server)
            request, filled = await complete(desk, user="Tom")
        assert (request.rank, request.deadline) == (2, 1000.0 + 2700)
        assert filled == ["pickup r-5303 directory", "deliver r-5307 finger", "deadline 45m finger"]
        directory = load_directory()
        desk = reception(FakeModule(), store, directory, server)
        await desk.load()
        assert directory.phrase("tom", "delivermail") == "Tom Jones's mail delivery"
        assert (await complete(desk))[1][1] == "deliver r-5307 finger"


async def test_whom_nobody_knows_is_refused_and_what_was_tried_is_said(tmp_path: Path):
    async with Store(tmp_path) as store:
        async with serving(replies({})) as server:
            desk = reception(FakeModule(), store, load_directory(), server)
            with pytest.raises(UnknownNameError, match=f"{server} does not know either"):
                await complete(desk)
        with pytest.raises(UnknownNameError, match="cannot be asked"):
            await complete(desk)


async def test_a_listed_person_has_an_account_of_their_own(tmp_path: Path):
    async with Store(tmp_path / "data") as store, serving(replies({"tj": "Office: 5311"})) as own:
        file = tmp_path / "people.yaml"
        file.write_text(
            f"services: {{}}\npeople: {{tom: {{name: Tom, rank: 3, finger: 'tj@{own}'}}}}\n"
            "items: {parcel: {phrase: parcel, rank: 1, to: user}}"
        )
        desk = reception(FakeModule(), store, load_directory(file))
        request, filled = await complete(desk, item="parcel", pickup="5301", deadline="5m")
        assert (request.deliver, request.rank) == ("r-5311", 4)
        assert filled == ["deliver r-5311 finger"]
        with pytest.raises(MissingRoomError, match="pickup: nobody knows the room") as caught:
            await complete(desk, item="parcel")
        question = "Which room shall I get Tom's parcel from?"
        assert caught.value.objection.question == question
        assert str(own) in str(caught.value)


def test_the_packages_directory_lists_a_visitor_whose_room_nobody_knows():
    visitor = read_entries().people["visitor"]
    assert visitor.room is None


async def test_a_listed_person_is_not_asked_about_in_vain(tmp_path: Path):
    asked: list[str] = []
    async with Store(tmp_path) as store, serving(replies({}, asked)) as server:
        desk = reception(FakeModule(), store, load_directory(), server)
        await complete(desk, user="mitchell")
        with pytest.raises(RequestError):
            await complete(desk, user="visitor")
    assert asked == ["visitor"]
