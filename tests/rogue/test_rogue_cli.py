"""The commands of users, as processes, against an agent's desk on a real bus."""

from __future__ import annotations

import asyncio
import json
import os
import sys
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from command_line import run_command
from rogue_fakes import prospects, reception

from rogue.cli import app
from rogue.conversation import Conversation
from rogue.memory import Facts, Store
from rogue.messages import RequestState
from rogue.requests import Desk, RequestBook, load_directory
from tca_bus import BusOptions, Context, Module
from tca_bus.testing import bus, central, eventually
from xavier_sim.messages import Ask, Typed

pytestmark = [pytest.mark.bus, pytest.mark.process]

ROOMS = {f"r-53{number:02d}": (0.0, float(number)) for number in range(1, 16)}


@dataclass
class Agent:
    options: BusOptions
    store: Store
    book: RequestBook
    conversation: Conversation

    async def start(self, *words: str) -> asyncio.subprocess.Process:
        return await start(self.options, *words)

    async def run(self, *words: str) -> tuple[int, str, str]:
        """Run a command to its end, here; one that is `start`ed is a process of its own."""
        return await here(self.options, *words)

    async def end(self, name: str, state: RequestState, reason: str | None) -> None:
        request = self.book.find(name)
        assert request is not None
        done = self.book.as_ended(request, state, reason, Facts())
        await self.store.change_request(done)
        await self.book.took_effect(done)


async def start(
    options: BusOptions,
    *words: str,
    stdin: int | None = None,
    stderr: int = asyncio.subprocess.PIPE,
) -> asyncio.subprocess.Process:
    environment = {**os.environ, "TCA_CONNECT": options.connect, "TCA_REALM": options.realm}
    return await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rogue",
        *words,
        stdin=stdin,
        stdout=asyncio.subprocess.PIPE,
        stderr=stderr,
        env=environment,
    )


async def here(options: BusOptions, *words: str) -> tuple[int, str, str]:
    where = {"TCA_CONNECT": options.connect, "TCA_REALM": options.realm}
    ran = await run_command(app, *words, **where)
    return ran.code, ran.out, ran.err


async def ended(process: asyncio.subprocess.Process) -> tuple[int, str, str]:
    out, err = await process.communicate()
    return process.returncode or 0, out.decode(), err.decode()


def desk(module: Module, store: Store) -> RequestBook:
    directory = load_directory()
    book = RequestBook(module, store, directory)

    async def rooms() -> dict[str, tuple[float, float]]:
        return ROOMS

    ready = reception(module, store, directory), prospects(module, store, book)
    Desk(module, store, book, *ready).open(rooms)
    return book


@pytest.fixture
async def agent(tmp_path: Path) -> AsyncIterator[Agent]:
    async with bus() as options, Store(tmp_path) as store:
        module = Module("rogue", options=options)
        book = desk(module, store)
        async with module:
            yield Agent(options, store, book, Conversation(module, store))


async def test_a_request_is_posted_listed_and_shown(agent: Agent):
    code, out, err = await agent.run(
        "request", "delivermail", "--user", "mitchell", "--id", "mail", "--json"
    )
    assert code == 0, err
    posted = json.loads(out)
    assert (posted["pickup"], posted["deliver"], posted["state"]) == ("r-5303", "r-5313", "queued")
    listed, shown = await agent.run("requests", "--json"), await agent.run("show", "mail", "--json")
    assert json.loads(listed[1]) == [posted]
    assert json.loads(shown[1])["request"] == posted
    code, out, err = await agent.run("cancel", "mail", "--json")
    assert code == 0, err
    canceled = json.loads(out)
    assert (canceled["id"], canceled["state"]) == ("mail", "canceled")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("delivermail", "--user", "mitchel"), "there is no user 'mitchel'. Did you mean"),
        (("delivermail", "--user", "mitchell", "--from", "r-5330"), "no room 'r-5330'. Did you"),
        (("delivermail", "--user", "mitchell", "--from", "attic"), "no room 'attic'. There are"),
        (("delivermail", "--user", "mitchell", "--id", "a b"), "id: string should match pattern"),
    ],
)
async def test_what_is_wrong_is_said_in_one_line(agent: Agent, words, said):
    code, out, err = await agent.run("request", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert said in err
    assert len(err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("state", "reason", "code"),
    [
        (RequestState.COMPLETED, None, 0),
        (RequestState.FAILED, "cannot get to r-5313, door_blocked", 1),
        (RequestState.CANCELED, "not needed", 6),
    ],
)
async def test_wait_ends_with_the_request(agent: Agent, state, reason, code):
    words = ("request", "delivermail", "--user", "mitchell", "--id", "mail", "--wait")
    asking = asyncio.create_task(agent.run(*words), name="asking")
    await eventually(lambda: agent.book.find("mail"), what="the request")
    await agent.end("mail", state, reason)
    found, out, err = await asking
    assert found == code, err
    assert out.splitlines()[-1].startswith("mail: delivermail for mitchell, r-5303 to r-5313: ")
    assert state.value in out
    assert (reason or "") in out


async def test_what_is_declined_has_a_code_of_its_own_and_says_why_in_json(agent: Agent):
    words = ("request", "delivermail", "--user", "mitchell", "--json")
    assert (await agent.run(*words, "--id", "a"))[0] == 0
    code, out, err = await agent.run(*words, "--id", "b")
    assert code == 7
    assert "is open already, as request 'a'" in err
    refused = json.loads(out)
    assert (refused["refused"], refused["field"], refused["other"]) == ("duplicate", "id", "a")
    assert (await agent.run(*words, "--id", "b", "--again"))[0] == 0
    code, out, _ = await agent.run("requests", "--user", "mitchell", "--limit", "1", "--json")
    assert [one["id"] for one in json.loads(out)] == ["b"]


async def test_a_deadline_that_cannot_be_met_is_declined_with_the_earliest_time(agent: Agent):
    words = ("request", "delivermail", "--user", "mitchell", "--deadline", "5s", "--id", "a")
    code, out, err = await agent.run(*words, "--json")
    assert code == 7
    assert "is the earliest; name a later one, or --anyway" in err
    refused = json.loads(out)
    assert (refused["refused"], refused["field"]) == ("too_late", "deadline")
    assert refused["earliest"] > time.time() - 60.0
    assert (await agent.run(*words, "--anyway"))[0] == 0


async def test_without_a_terminal_the_robot_asks_for_what_nobody_knows(agent: Agent):
    async def answer(question: Ask, context: Context) -> Typed:
        del context
        return Typed(answer="5307" if question.about == "deliver" else "", time=0.0)

    speech = Module("speech", options=agent.options)
    speech.serve(Ask, answer)
    async with central(agent.options), speech:
        code, out, err = await agent.run("request", "delivermail", "--user", "visitor", "--json")
    assert code == 0, err
    assert "On the robot's keyboard, visitor is asked: Which room" in err
    assert json.loads(out)["deliver"] == "r-5307"


async def test_the_trace_is_printed_from_its_beginning(agent: Agent):
    await agent.conversation.tell_all(["Listening for incoming requests...", "", "  2 n2 (done)"])
    code, out, _ = await agent.run("trace")
    assert (code, out) == (0, "Listening for incoming requests...\n\n  2 n2 (done)\n")
    follower = await agent.start("trace", "--follow", "--after", "2")
    assert follower.stdout is not None
    assert await follower.stdout.readline() == b"  2 n2 (done)\n"
    await agent.conversation.tell("  4 n4 <*finish*>")
    assert await follower.stdout.readline() == b"  4 n4 <*finish*>\n"
    follower.terminate()
    assert await follower.wait() == 0


async def test_without_an_agent_nobody_handles_it():
    async with bus() as options:
        code, _, err = await here(options, "requests")
    assert code == 3
    assert "rogueRequests" in err


async def test_without_a_router_it_says_how_to_start_one():
    options = BusOptions(connect="tcp/127.0.0.1:1")
    code, _, err = await ended(await start(options, "requests"))
    assert code == 5
    assert "tca router" in err


async def test_an_unknown_request_is_bad_usage(agent: Agent):
    code, _, err = await agent.run("cancel", "nothing")
    assert code == 2
    assert "there is no request 'nothing'" in err


@pytest.mark.parametrize("words", [("show", ""), ("why", ""), ("trace", "--after", "-1")])
async def test_what_no_message_can_hold_is_bad_usage(agent: Agent, words):
    code, out, err = await agent.run(*words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert "Traceback" not in err


async def test_in_a_terminal_the_user_is_asked_for_what_nobody_knows(agent: Agent):
    terminal, side = os.openpty()
    words = ("request", "delivermail", "--user", "visitor", "--json")
    process = await start(agent.options, *words, stdin=side, stderr=side)
    os.close(side)
    try:
        shown = b""
        while b"Which room shall I take the visitor's mail delivery to? " not in shown:
            shown += await asyncio.to_thread(os.read, terminal, 1000)
        os.write(terminal, b"5307\n")
        assert process.stdout is not None
        out = await process.stdout.read()
        assert await process.wait() == 0
    finally:
        os.close(terminal)
    assert json.loads(out)["deliver"] == "r-5307"
