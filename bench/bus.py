"""Our bus beside others, in one run, as a Markdown table.

``uv run --group bench python bench/bus.py [--rounds N] [--calls N] [--only NAME ...]``

Each contender has a caller in this process and a callee in another, with whatever it needs
between them. They are measured in turn, round by round, so that a busy machine is equally bad for
all; what counts are the ratios. A contender that this machine lacks is named and left out.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from contenders import CONTENDERS
from contenders.base import Place
from contenders.measure import Plan, measure
from contenders.processes import everything, route
from contenders.report import report

DEFAULT_SIZES = (64, 1024, 65536)

ONE_THREAD = (
    "(rx: (worker_threads: 1), acc: (handover: rx), app: (handover: rx), tx: (handover: rx), "
    "net: (handover: rx))"
)
"""Has Zenoh do all its work on one thread: quicker for a module, and never good for a router."""


async def run(names: list[str], plan: Plan) -> None:
    """Start everything, measure, print."""
    chosen = [CONTENDERS[name] for name in names]
    missing = {one.title: why for one in chosen if (why := one.missing()) is not None}
    present = [one for one in chosen if one.title not in missing]
    with tempfile.TemporaryDirectory() as data:
        async with everything(present, Path(data)) as clients:
            samples = await measure(clients, plan)
    print(report(samples, plan, missing))


def main() -> None:
    """Read the command line and run one of the roles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=10, help="rounds of all contenders")
    parser.add_argument("--calls", type=int, default=100, help="calls one at a time in a round")
    parser.add_argument("--sizes", type=int, nargs="+", default=DEFAULT_SIZES, help="bytes")
    parser.add_argument("--only", nargs="+", choices=CONTENDERS, default=list(CONTENDERS))
    parser.add_argument(
        "--one-thread", action="store_true", help="one Zenoh thread in callers and callees"
    )
    parser.add_argument("--route", metavar="ENDPOINT", help=argparse.SUPPRESS)
    parser.add_argument("--serve", nargs=4, help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if flags.one_thread:
        os.environ["ZENOH_RUNTIME"] = ONE_THREAD
    if flags.route:
        role = route(flags.route)
    elif flags.serve:
        name, router, port, data = flags.serve
        role = CONTENDERS[name].serve(Place(router, int(port), Path(data)))
    else:
        role = run(flags.only, Plan(flags.rounds, flags.calls, tuple(flags.sizes)))
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        runner.run(role)


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    try:
        import uvloop  # noqa: PLC0415 -- not there on every system
    except ImportError:
        return asyncio.new_event_loop
    return uvloop.new_event_loop


if __name__ == "__main__":
    main()
