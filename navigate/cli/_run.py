"""``navigate run``: the navigator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from navigate.keeping import StateFile
from navigate.maps import Floor, load_plan
from navigate.messages import LocalizerName
from navigate.navigator import Navigator
from navigate.position import DEFAULT_LOCALIZER, Picking, Start, make_localizer
from navigate.service import NavigateService
from tca_bus import configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options


async def run(
    *,
    map: Annotated[str | None, Parameter(env_var="NAVIGATE_MAP")] = None,  # noqa: A002 - the flag
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    localizer: LocalizerName = DEFAULT_LOCALIZER,
    policy: Picking = "voting",
    start: Start = "known",
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the navigator until it is stopped.

    Args:
        map: Floor plan file, or the name of one that comes with the package.
        seed: Of the particle filter's random numbers, 0 or more; nothing else draws any.
        localizer: What estimates the position: a POMDP over the topological map, a particle filter,
            or odometry alone.
        policy: How a robot that is lost picks its way to the goal on the POMDP's belief, when that
            is spread out: by vote, by the most likely state, or by the least expected cost.
        start: Where the robot is to begin with: where it was kept that it is, or else where the map
            says; or anywhere, so that it looks for itself. Only the POMDP can.
        data: Folder in which the position is kept for the next start.
        flags: Shared flags.
    """
    configure_logging("navigate", level=flags.level, json=flags.json)
    floor = Floor(load_plan(map))
    chosen = make_localizer(localizer, floor, seed=seed, policy=policy, start=start)
    kept = StateFile(data) if data else None
    service = NavigateService(
        Navigator(floor, localizer=chosen), bus_options(flags), kept, goes_on=start == "known"
    )
    await service.run()
