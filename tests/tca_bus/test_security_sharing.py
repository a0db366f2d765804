"""Shared variables, recordings and exception handlers behind a policy, over TLS."""

from __future__ import annotations

import asyncio
import io

import pytest
from mcap.reader import make_reader
from security_office import REALM, Note, Scan, careless, guarded, make_keys, with_central

from tca_bus import ConfigError, Guard, RefusedError, Router, TcaException, Variable
from tca_bus._access import audible
from tca_bus._policy import Policy
from tca_bus._recorder import Backlog, Recorder
from tca_bus._replayer import Replayer
from tca_bus._resource_messages import DeclareResource, UnlockResource
from tca_bus._selection import Selection
from tca_bus._wire import Payload
from tca_bus.testing import eventually

POLICY = {
    "modules": {
        "writer": {"write": ["batt*"], "read": ["*"], "send": ["note", "scan"]},
        "reader": {"read": ["battery"], "serve": ["note"]},
        "holder": {"lock": ["door*", "*@reader"]},
        "nobody": {},
        "tca": {"listen": ["*"], "watch": ["*"], "read": ["*"]},
    }
}

BATTERY = Variable("battery", float)
DOOR = Variable("door", str)


class Stuck(TcaException):
    pass


@pytest.fixture(scope="session")
def keys(tmp_path_factory):
    return make_keys(tmp_path_factory.mktemp("sharing") / "keys", *POLICY["modules"])


@pytest.mark.bus
async def test_write_without_the_right(keys):
    async with (
        with_central(keys, POLICY) as (office, _),
        office.module("writer") as writer,
        office.module("reader") as reader,
        careless(office.module("nobody")) as nobody,
    ):
        await writer.set(BATTERY, 0.5)
        with pytest.raises(RefusedError, match="to write 'door'"):
            await writer.set(DOOR, "open")
        for module in (reader, nobody):
            with pytest.raises(RefusedError, match="to write 'battery'"):
                await module.set(BATTERY, 0.1)
        assert await reader.get(BATTERY) == 0.5


@pytest.mark.bus
async def test_read_without_the_right(keys):
    async with with_central(keys, POLICY) as (office, _):
        nobody = careless(office.module("nobody"))
        async with (
            office.module("writer") as writer,
            office.module("reader") as reader,
            nobody,
            reader.watch(BATTERY) as sees,
            nobody.watch(BATTERY) as blind,
        ):
            await writer.set(BATTERY, 0.5)
            assert (await asyncio.wait_for(anext(sees), 10)).value == 0.5
            with pytest.raises(RefusedError, match="to read 'battery'"):
                await nobody.get(BATTERY)
            with pytest.raises(RefusedError, match="to read 'door'"):
                async with reader.watch(DOOR):
                    pass
            assert await nobody.variables() == []
            assert [state.name for state in await reader.variables()] == ["battery"]
            await nobody.core.session.settle(f"{REALM}/presence/**")
            assert blind._fresh is None
            look = nobody.core.session.ask
            key = f"{REALM}/variable/battery"
            assert await look(key, Payload(b"", ""), attachment=b"", timeout=5) is None


@pytest.mark.bus
async def test_a_recording_has_what_the_recorder_may_hear(keys, tmp_path):
    wanted = {"inform/note/writer", "broadcast/scan/writer"}
    stream, seen = io.BytesIO(), set()

    class Noting(Backlog):
        def push(self, passed):
            seen.add(passed.key)
            super().push(passed)

    async def note(message, context):
        pass

    async with (
        guarded(keys, POLICY) as office,
        office.module("writer") as writer,
        office.module("reader") as reader,
        office.module("tca-1") as tca,
    ):
        reader.serve(Note, note)
        await writer.wait_for(Note, timeout=10)
        recorder = Recorder(tca, tmp_path / "x.mcap", stream, Selection(), backlog=Noting())
        recording = asyncio.create_task(recorder.run())
        await eventually(lambda: seen, what="the beginning of the recording")
        await tca.core.session.settle(f"{REALM}/presence/**")
        await writer.inform(Note(text="n"))
        await writer.broadcast(Scan(text="s"))
        await eventually(lambda: wanted <= seen)
        recording.cancel()
        await asyncio.gather(recording, return_exceptions=True)
    stream.seek(0)
    assert wanted <= {channel.topic for _, channel, _ in make_reader(stream).iter_messages()}


@pytest.mark.bus
async def test_a_recording_of_what_may_not_be_heard_is_refused(keys, tmp_path):
    async with guarded(keys, POLICY) as office, office.module("nobody") as nobody:
        selection = Selection.parse(["scan"])
        recorder = Recorder(nobody, tmp_path / "x.mcap", io.BytesIO(), selection)
        with pytest.raises(RefusedError, match="listening to inform/scan"):
            await recorder.run()


@pytest.mark.bus
async def test_a_replay_in_the_names_of_others_is_refused(keys):
    async with guarded(keys, POLICY) as office, office.module("tca") as tca:
        with pytest.raises(RefusedError, match="in the names of others"):
            await Replayer(tca).run([])


@pytest.mark.bus
async def test_an_exception_handler_needs_the_right_to_serve(keys):
    async def handle(message, context):
        pass

    async with guarded(keys, POLICY) as office:
        async with office.module("reader") as reader:
            with pytest.raises(RefusedError, match="to serve 'unstick'"):
                reader.exception_handler(Stuck, name="unstick")(handle)
        before = office.module("reader")
        before.exception_handler(Stuck, name="unstick")(handle)
        with pytest.raises(RefusedError, match="to serve 'unstick'"):
            async with before:
                pass


@pytest.mark.bus
async def test_lock_without_the_right(keys):
    async with (
        with_central(keys, POLICY) as (office, _),
        office.module("holder") as holder,
        office.module("reader") as reader,
        careless(office.module("nobody")) as nobody,
    ):
        for module, name in ((nobody, "door"), (holder, "arm"), (reader, "door")):
            with pytest.raises(RefusedError, match=f"to lock '{name}'"):
                async with module.acquire(name, timeout=10):
                    pass
            with pytest.raises(RefusedError, match=f"to lock '{name}'"):
                async with module.lock(name, timeout=10):
                    pass
        async with holder.acquire("door", timeout=10):
            with pytest.raises(RefusedError, match="to lock 'door'"):
                await nobody.query(UnlockResource(name="door"), to="central")
            with pytest.raises(RefusedError, match="to lock 'door'"):
                await nobody.query(DeclareResource(name="door", capacity=9), to="central")


@pytest.mark.bus
async def test_a_module_locks_its_own_handlers_and_not_those_of_others(keys):
    async def note(message, context):
        pass

    async with (
        with_central(keys, POLICY) as (office, central),
        office.module("holder") as holder,
        office.module("reader") as reader,
        office.module("writer") as writer,
    ):
        reader.serve(Note, note)
        await eventually(lambda: central.tree.pools.provides("note"))
        with pytest.raises(RefusedError, match="to lock 'reader'"):
            async with writer.lock("reader/", timeout=10):
                pass
        for module in (reader, holder):
            async with module.lock("reader/", timeout=10):
                pass


@pytest.mark.bus
async def test_only_central_tells_of_holds(keys):
    async with guarded(keys, POLICY) as office, office.module("writer") as writer:
        with pytest.raises(RefusedError, match="only central may send"):
            await writer.broadcast_json("tca.hold", {})


def test_a_guarded_router_is_not_linked(keys):
    with pytest.raises(ConfigError, match="--link"):
        Router("tls/127.0.0.1:0", guard=Guard(keys), links=["tcp/127.0.0.1:1"])


def test_a_selection_shrinks_to_what_may_be_heard():
    policy = Policy.model_validate(POLICY)
    whole = Selection().within(audible(policy, "tca-9"))
    for key in ("inform/note/writer", "broadcast/scan/x", "task/x/1", "variable/door"):
        assert whole.includes(key)
    assert not Selection().within(audible(policy, "reader")).includes("broadcast/scan/writer")
    assert Selection().within(audible(policy, "reader")).includes("variable/battery")
    assert audible(policy, "stranger") == []
