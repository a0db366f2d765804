"""``tca central``: the process that keeps the task tree."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tca_bus._central import Central
from tca_bus._central_absences import LOST_AFTER
from tca_bus._logs import configure_logging
from tca_bus._policy_file import read_policy
from tca_bus._span_exporter import spans_from_environment
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags, bus_options


async def central(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    policy: Annotated[Path | None, Parameter(env_var="TCA_POLICY")] = None,
    lost_after: Annotated[float, Parameter(env_var="TCA_LOST_AFTER")] = LOST_AFTER,
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
    policy
        Policy file that says who may do what; without it central goes by the router's.
    lost_after
        Seconds for which a module may be out of reach before its tasks fail or are given to
        another. Make it longer than the links between routers may be cut.
    """
    configure_logging("central", level=flags.level, json=flags.json)
    options = bus_options(flags)
    read = None if policy is None else read_policy(policy)
    with spans_from_environment(options.realm) as spans:
        on_end = spans.export if spans else lambda _: None
        keeper = Central(options, data=data, lost_after=lost_after, on_end=on_end, policy=read)
        async with keeper as running:
            await running.serve_forever()
