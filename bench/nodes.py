"""What a node of the task tree costs, from ten nodes to a hundred thousand in one tree.

``uv run python bench/nodes.py [--sizes N ...] [--at-once N]``

A goal's handler makes so many commands below it, some at once, as a module would; central keeps
its journal in a file. The cost of a node is the time from the goal's sending to its end, divided;
it ought not to grow with the tree. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
import asyncio
import tempfile
import time
from pathlib import Path

import uvloop

from tca_bus import Command, Constraint, Context, Goal, Module, Query, TaskContext
from tca_bus.testing import bus, central

DEFAULT_SIZES = (10, 100, 1000, 10_000, 100_000)
LONGEST = 3600.0
HEADING = """| nodes | seconds | µs a node | ratio |
|------:|--------:|----------:|------:|"""


class Step(Command[None]):
    """Do nothing."""


class Tree(Goal[int]):
    """Make so many steps below."""

    nodes: int
    at_once: int


class Ready(Query[bool]):
    """Whether the module is there."""


async def expand(goal: Tree, context: TaskContext) -> int:
    """Make the steps, ``at_once`` at a time."""
    left = iter(range(goal.nodes))

    async def maker() -> None:
        for _ in left:
            await context.execute(Step(), constraints=Constraint.NONE, timeout=LONGEST)

    async with asyncio.TaskGroup() as group:
        for _ in range(goal.at_once):
            group.create_task(maker())
    return goal.nodes


async def step(_message: Step, _: TaskContext) -> None:
    """Do nothing."""


async def ready(_message: Ready, _: Context) -> bool:
    """Say so."""
    return True


async def run(sizes: list[int], at_once: int) -> None:
    """Measure each size on the same central."""
    with tempfile.TemporaryDirectory() as data:
        async with bus() as options, central(options, data=Path(data)):
            worker = Module("worker", options=options)
            worker.serve(Tree, expand)
            worker.serve(Step, step, capacity=at_once)
            async with worker, Module("boss", options=options) as boss:
                await boss.wait_for(Tree, Step, "tca.submit", timeout=30.0)
                print(HEADING)
                first = 0.0
                for size in sizes:
                    seconds = await measure(boss, size, at_once)
                    first = first or seconds / size
                    ratio = seconds / size / first
                    cost = f"{seconds / size * 1e6:,.0f} | {ratio:.2f}"
                    print(f"| {size:,} | {seconds:.2f} | {cost} |")


async def measure(boss: Module, nodes: int, at_once: int) -> float:
    """Seconds from the sending of a goal with so many children to its end."""
    begun = time.perf_counter()
    handle = await boss.expand(Tree(nodes=nodes, at_once=at_once))
    await handle.result(timeout=LONGEST)
    return time.perf_counter() - begun


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=DEFAULT_SIZES)
    parser.add_argument("--at-once", type=int, default=10, help="children under way at a time")
    flags = parser.parse_args()
    uvloop.run(run(flags.sizes, flags.at_once))


if __name__ == "__main__":
    main()
