"""Who is let in at all, and what those are told who are not."""

from __future__ import annotations

import asyncio
import datetime as dt
import os
import shutil
import socket
import sys

import pytest
from security_office import REALM, Add, Drive, Note, Scan, Sum, careless, guarded, make_keys

from tca_bus import BusGoneError, BusOptions, ConfigError, Module, RefusedError, Router
from tca_bus._authority import Authority
from tca_bus._central import Central
from tca_bus._keyring import Keyring
from tca_bus._limits import ENVELOPE_BYTES
from tca_bus._policy import Policy
from tca_bus._router import Guard
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus

NAMES = ("server", "asker", "robot")
POLICY = {
    "modules": {
        "server": {"serve": ["add", "note", "drive"], "listen": ["scan"]},
        "asker": {"send": ["add", "note", "drive", "scan"]},
    },
    "limits": {"add": {"bytes": 1000}, "drive": {"bytes": 1000}, "note@asker": {"hertz": 0.5}},
}


@pytest.fixture(scope="session")
def keys(tmp_path_factory):
    folder = tmp_path_factory.mktemp("joining") / "keys"
    return make_keys(folder, *NAMES, passwords=("central", *NAMES))


@pytest.fixture(scope="session")
def other_keys(tmp_path_factory):
    return make_keys(tmp_path_factory.mktemp("other") / "keys", *NAMES, passwords=NAMES)


@pytest.fixture
async def office(keys):
    async with guarded(keys, POLICY) as office:
        yield office


async def assert_shut_out(module, *words):
    """What a module is told that is not let in; one that gives up waiting is told otherwise."""
    with pytest.raises(RefusedError, match="joining the bus at") as caught:
        async with module:
            pytest.fail("it was let in")
    for word in words:
        assert word in str(caught.value)


async def test_without_a_certificate(office):
    plain = office.module("asker", connect=office.router.endpoint.replace("tls/", "tcp/"))
    await assert_shut_out(
        Module("asker", options=plain.options.model_copy(update={"keys": None})),
        "closes the door",
        "--keys",
    )


async def test_with_a_user_where_a_certificate_is_wanted(office, keys):
    user = office.module("asker", user="asker", password="x")
    await assert_shut_out(user, "wants a certificate")


async def test_with_keys_of_another_authority(office, other_keys):
    stranger = office.module("asker", keys=other_keys)
    await assert_shut_out(stranger, "the router's certificate is not accepted", "authority.pem")


async def test_with_a_certificate_of_another_authority(office, keys, other_keys, tmp_path):
    shutil.copytree(other_keys, tmp_path / "keys")
    shutil.copy(keys / "authority.pem", tmp_path / "keys" / "authority.pem")
    stranger = office.module("asker", keys=tmp_path / "keys")
    await assert_shut_out(stranger, "does not accept certificate", "asker/certificate.pem")


async def test_with_a_certificate_that_is_out_of_date(office, keys, tmp_path, monkeypatch):
    shutil.copytree(keys, tmp_path / "keys")
    monkeypatch.setattr("tca_bus._authority.BACKDATED", dt.timedelta(days=2))
    Authority(tmp_path / "keys").renew(["asker"], days=-1)
    late = office.module("asker", keys=tmp_path / "keys")
    await assert_shut_out(late, "does not accept certificate", "expired", "'tca keys renew'")


@pytest.mark.skipif(sys.platform != "linux", reason="needs a second loopback address")
async def test_at_a_host_that_the_router_is_not_certified_for(keys):
    async with guarded(keys, POLICY, endpoint="tls/127.0.0.2:0") as office:
        await assert_shut_out(office.module("asker"), "'tca keys make --host'", "mismatch")


async def test_under_the_name_of_another(office, keys, tmp_path):
    shutil.copytree(keys, tmp_path / "keys")
    modules = tmp_path / "keys" / "modules"
    shutil.rmtree(modules / "server")
    shutil.copytree(modules / "asker", modules / "server")
    await assert_shut_out(
        office.module("server", keys=tmp_path / "keys"), "take this name", "'modules'"
    )


async def test_under_a_name_that_the_policy_does_not_list(office):
    await assert_shut_out(office.module("robot"), "does not let it take this name")
    await assert_shut_out(office.module("robot-12"), "does not let it take this name")


async def test_on_another_realm_nothing_is_heard(office):
    foreign = careless(office.module("asker", realm="other"))
    async with foreign, office.module("server") as server:
        assert [m.name for m in server.modules()] == ["server"]
        assert [m.name for m in foreign.modules()] == ["asker"]


async def test_on_another_realm_one_is_told_why_nothing_is_heard(office, caplog):
    async with office.module("asker", realm="other"):
        pass
    assert "tells no policy for realm 'other'" in caplog.text


async def test_a_tool_that_adds_a_number_to_its_name_joins(office):
    async with office.module("asker-4711") as tool, office.module("server") as server:
        await eventually(lambda: len(server.modules()) == 2)
        assert tool.permissions.policy == office.policy


async def test_a_router_with_keys_and_no_policy_lets_in_and_allows(keys):
    async with Router("tls/127.0.0.1:0", guard=Guard(keys)) as router:
        options = BusOptions(connect=router.endpoint, keys=keys)
        async with Module("server", options=options) as server:
            assert server.permissions.policy is None

            @server.handler(Add)
            async def add(message, context):
                return Sum(value=message.a + message.b)

            async with Module("robot-1", options=options) as robot:
                await robot.wait_for(Add, timeout=10)
                assert await robot.query(Add(a=1, b=2)) == Sum(value=3)


async def test_passwords_are_enough_where_nobody_listens_in(keys):
    async with guarded(keys, POLICY, endpoint="tcp/127.0.0.1:0") as office:
        async with office.module("server") as server, office.module("asker") as asker:

            @server.handler(Add)
            async def add(message, context):
                return Sum(value=message.a + message.b)

            await asker.wait_for(Add, timeout=10)
            assert await asker.query(Add(a=1, b=2)) == Sum(value=3)
            with pytest.raises(RefusedError, match="send 'add'"):
                await server.query(Add(a=1, b=2))
        password = Keyring(keys).read_password("asker")
        typed = office.module("asker", keys=None, user="asker", password=password)
        async with typed:
            pass
        wrong = office.module("asker", keys=None, user="asker", password="wrong")
        await assert_shut_out(wrong, "user 'asker'", "another password")
        await assert_shut_out(office.module("asker", keys=None), "wants user and password")
        await assert_shut_out(
            office.module("server", keys=None, user="asker", password=password), "take this name"
        )


async def test_passwords_over_an_encrypted_link(keys):
    async with guarded(keys, POLICY, auth="password") as office:
        async with office.module(
            "asker", user="asker", password=Keyring(keys).read_password("asker")
        ):
            pass
        await assert_shut_out(office.module("asker", user="asker", password="wrong"))


async def test_a_user_at_a_router_that_knows_none_is_told(keys):
    async with bus() as options:
        given = options.model_copy(update={"keys": keys, "connect_timeout": 10.0})
        await assert_shut_out(Module("asker", options=given), "asks for none")


async def test_nobody_there_is_no_refusal(keys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        for protocol in ("tcp", "tls"):
            endpoint = f"{protocol}/127.0.0.1:{taken.getsockname()[1]}"
            options = BusOptions(connect=endpoint, keys=keys, connect_timeout=0.2)
            with pytest.raises(BusGoneError):
                async with Module("asker", options=options):
                    pass


async def test_who_listens_and_says_nothing_is_no_refusal(keys):
    with socket.socket() as mute:
        mute.bind(("127.0.0.1", 0))
        mute.listen()
        endpoint = f"tcp/127.0.0.1:{mute.getsockname()[1]}"
        with pytest.raises(BusGoneError):
            async with Module("asker", options=BusOptions(connect=endpoint, connect_timeout=0.2)):
                pass


async def test_a_message_that_is_too_big_is_refused_before_it_is_sent(office):
    async with office.module("server") as server, office.module("asker") as asker:

        @server.handler(Add)
        async def add(message, context):
            return Sum(value=0)

        await asker.wait_for(Add, timeout=10)
        with pytest.raises(RefusedError, match=r"bytes, and the policy allows 1000 \(limits\.add"):
            await asker.query_json("add", {"a": 1, "b": 2, "c": "x" * 1000})
        with pytest.raises(RefusedError, match=r"allows 1000 \(limits\.drive"):
            await asker.execute(Drive(where="x" * 1000))


async def test_the_router_stops_what_is_too_big_from_a_careless_module(office):
    async with careless(office.module("asker")) as asker, office.module("server") as server:
        seen = []

        @server.handler(Note)
        async def note(message, context):
            seen.append(message.text)

        @server.handler(Add)
        async def add(message, context):
            seen.append("add")
            return Sum(value=0)

        await asker.wait_for(Add, timeout=10)
        with pytest.raises(Exception, match="add"):
            await asker.query_json("add", {"a": 1, "b": "x" * (1001 + ENVELOPE_BYTES)}, timeout=3)
        assert seen == []


async def test_central_stops_a_task_that_is_too_big_from_a_careless_module(office):
    async with Central(office.options()), careless(office.module("asker")) as asker:
        with pytest.raises(RefusedError, match=r"allows 1000 \(limits\.drive"):
            await asker.execute(Drive(where="x" * 1000))


async def test_a_message_that_comes_too_soon_is_refused(office):
    async with office.module("server") as server, office.module("asker") as asker:
        seen = []

        @server.handler(Note)
        async def note(message, context):
            seen.append(message.text)

        await asker.wait_for(Note, timeout=10)
        await asker.inform(Note(text="first"))
        with pytest.raises(RefusedError, match=r"0\.5 per second \(limits\.note@asker"):
            await asker.inform(Note(text="second"))
        await eventually(lambda: seen == ["first"])


async def test_the_router_thins_out_what_comes_too_soon_from_a_careless_module(office):
    async with office.module("server") as server, careless(office.module("asker")) as asker:
        seen = []

        @server.handler(Note)
        async def note(message, context):
            seen.append(message.text)

        @server.handler(Scan)
        async def scan(message, context):
            seen.append("end")

        await asker.wait_for(Note, timeout=10)
        for number in range(50):
            await asker.inform(Note(text=str(number)))
        await asker.broadcast(Scan())
        await eventually(lambda: "end" in seen)
        assert len(seen) < 25


async def test_a_module_that_a_new_policy_leaves_out_ends_with_the_reason(keys):
    async with Router("tls/127.0.0.1:0", guard=Guard(keys, parsed(POLICY), REALM)) as router:
        options = BusOptions(connect=router.endpoint, realm=REALM, keys=keys)
        server = Module("server", options=options)
        serving = asyncio.create_task(serve(server))
        await eventually(lambda: server.permissions.policy is not None)
    without = {"modules": {"asker": {"send": ["note"]}}}
    asker = Module("asker", options=options)
    async with Router(router.endpoint, guard=Guard(keys, parsed(without), REALM)), asker:
        assert asker.permissions.policy == parsed(without)
        with pytest.raises(RefusedError, match="take this name"):
            await asyncio.wait_for(serving, 30)


async def serve(module):
    async with module:
        await module.serve_forever()


def parsed(policy):
    return Policy.model_validate(policy)


async def test_a_router_needs_its_keys(keys, tmp_path):
    with pytest.raises(ConfigError, match="private"):
        async with Router("tls/127.0.0.1:0", guard=Guard(tmp_path)):
            pass
    with pytest.raises(ConfigError, match="--auth"):
        async with Router("tcp/127.0.0.1:0", guard=Guard(keys, auth="certificate")):
            pass


async def run(*words, **environment):
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "tca_bus", *words),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "TCA_REALM": REALM, **environment},
    )
    out, err = await process.communicate()
    return process.returncode, out.decode(), err.decode()


@pytest.mark.slow
@pytest.mark.process
async def test_commands_end_with_the_exit_code_of_a_refusal(keys, other_keys, tmp_path):
    shutil.copytree(keys, tmp_path / "keys")
    Authority(tmp_path / "keys").add_module("tca")
    shutil.copytree(other_keys, tmp_path / "other")
    Authority(tmp_path / "other").add_module("tca")
    policy = {"modules": {**POLICY["modules"], "tca": {"watch": ["*"]}}}
    async with (
        guarded(keys, policy) as office,
        Central(office.options()),
        office.module("server") as server,
    ):

        @server.handler(Drive)
        async def drive(message, context):
            return "done"

        at = {"TCA_CONNECT": office.router.endpoint, "TCA_KEYS": str(tmp_path / "keys")}
        code, out, err = await run("modules", **at)
        assert (code, "server" in out) == (0, True), err
        code, _, err = await run("command", "drive", '{"where": "x"}', **at)
        assert (code, "send 'drive'" in err) == (7, True)
        strange = at | {"TCA_KEYS": str(tmp_path / "other")}
        code, _, err = await run("modules", **strange)
        assert (code, "not accepted" in err) == (7, True)
        code, _, err = await run("central", **at | {"TCA_KEYS": str(tmp_path / "other")})
        assert code == 7
