"""``tca router`` and ``tca central``: the two infrastructure processes."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tca_bus import Router, configure_logging
from tca_bus._central import Central
from tca_bus._span_exporter import spans_from_environment
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags, bus_options


async def router(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Run the Zenoh router, which all processes connect to.

    It listens at --connect; tcp/127.0.0.1:0 picks a free port, which the log names.
    """
    configure_logging("router", level=flags.level, json=flags.json)
    async with Router(flags.connect):
        await asyncio.get_running_loop().create_future()


async def central(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run central, which keeps the task tree and its journal.

    With OpenTelemetry's variables set, OTEL_TRACES_EXPORTER or OTEL_EXPORTER_OTLP_ENDPOINT,
    it exports a span for each task; that needs the extra 'otel'.

    Parameters
    ----------
    data
        Folder of the journal, central.db. Started on it again, central goes on where it was;
        without it the journal is in memory and ends with the process.
    """
    configure_logging("central", level=flags.level, json=flags.json)
    options = bus_options(flags)
    with spans_from_environment(options.realm) as spans:
        on_end = spans.export if spans else lambda _: None
        async with Central(options, data=data, on_end=on_end) as running:
            await running.serve_forever()
