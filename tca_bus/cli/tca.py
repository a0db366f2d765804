"""The ``tca`` command: the two infrastructure processes, and looking at what runs on the bus."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

from tca_bus.cli._app import make_app
from tca_bus.cli._health import doctor, status
from tca_bus.cli._history import log
from tca_bus.cli._modules import messages, modules
from tca_bus.cli._record import record, replay
from tca_bus.cli._run import run_app
from tca_bus.cli._send import broadcast, inform, query
from tca_bus.cli._servers import central, router
from tca_bus.cli._steer import prioritize, resume, retry, suspend
from tca_bus.cli._tasks import command, goal, kill
from tca_bus.cli._tree import tree
from tca_bus.cli._variables import var

app = make_app(
    "tca",
    help="TCA on Zenoh: run the bus, look at its modules and tasks, and send messages by hand.",
)

GROUPS: dict[str, tuple[Callable[..., Any], ...]] = {
    "Processes": (router, central),
    "Who is there": (modules, messages, status, doctor),
    "Messages": (query, inform, broadcast),
    "Tasks": (goal, command, tree, kill, suspend, resume, retry, prioritize, log),
    "Recordings": (record, replay),
}

for group, functions in GROUPS.items():
    for function in functions:
        app.command(function, group=group)
var.group = "Messages"
app.command(var)


def main() -> NoReturn:
    """Run ``tca``."""
    run_app(app)
