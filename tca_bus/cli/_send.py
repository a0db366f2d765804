"""``tca query``, ``tca inform`` and ``tca broadcast``: messages by hand."""

from __future__ import annotations

from tca_bus import NoHandlerError
from tca_bus.cli._client import joined, provided
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit_json, note
from tca_bus.cli._payload import JsonText, check_class, check_payload, parse_payload


async def query(
    name: str,
    json: JsonText = "{}",
    /,
    *,
    to: str | None = None,
    timeout: float = 10.0,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Ask the module that handles a query and print its answer as JSON.

    Parameters
    ----------
    name
        Wire name of the query; 'tca messages' lists them.
    json
        Its fields as a JSON object; - reads it from standard input.
    to
        Name of the module to ask, where several handle it.
    timeout
        Wall seconds to wait for the answer.
    """
    data = parse_payload(name, json)
    async with joined(flags) as module:
        if to is None and not name.startswith("tca."):
            check_class(await provided(module, name), name, "query")
        emit_json(await module.query_json(name, data, to=to, timeout=timeout))


async def inform(name: str, json: JsonText = "{}", /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Tell the modules that handle an inform.

    Parameters
    ----------
    name
        Wire name of the inform; 'tca messages' lists them.
    json
        Its fields as a JSON object; - reads it from standard input.
    """
    data = parse_payload(name, json)
    async with joined(flags) as module:
        known = await provided(module, name)
        check_class(known, name, "inform")
        check_payload(known, name, data)
        await module.inform_json(name, data)


async def broadcast(
    name: str, json: JsonText = "{}", /, *, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Tell everybody who listens; that nobody does is no error.

    Parameters
    ----------
    name
        Wire name of the broadcast.
    json
        Its fields as a JSON object; - reads it from standard input.
    """
    data = parse_payload(name, json)
    async with joined(flags) as module:
        try:
            known = await provided(module, name)
        except NoHandlerError as error:
            note(f"sent, but {error}")
        else:
            check_class(known, name, "broadcast")
            check_payload(known, name, data)
        await module.broadcast_json(name, data)
