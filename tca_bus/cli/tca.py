"""The ``tca`` command: the two infrastructure processes, and looking at what runs on the bus."""

from __future__ import annotations

from typing import NoReturn

from tca_bus.cli._app import add_commands, make_app
from tca_bus.cli._run import run_app

app = make_app(
    "tca",
    help="TCA on Zenoh: run the bus, look at its modules and tasks, and send messages by hand.",
)

GROUPS = {
    "Processes": {
        "router": ("_serve_router:router", "Run the Zenoh router, which all processes connect to."),
        "central": (
            "_serve_central:central",
            "Run central, which keeps the task tree and its journal.",
        ),
    },
    "Who is there": {
        "modules": (
            "_modules:modules",
            "List the modules on the bus: name, process, host, state, and what they handle.",
        ),
        "messages": (
            "_modules:messages",
            "List the messages that modules handle, or show the JSON schemas of one.",
        ),
        "status": (
            "_health:status",
            (
                "Show in a few lines whether the office is up: exit code 0 if so, "
                "1 if something is amiss."
            ),
        ),
        "doctor": (
            "_health:doctor",
            (
                "Look for what is amiss and say what to do about it: exit code 1 if there is "
                "something."
            ),
        ),
    },
    "Messages": {
        "query": (
            "_send:query",
            "Ask the module that handles a query and print its answer as JSON.",
        ),
        "inform": ("_send:inform", "Tell the modules that handle an inform."),
        "broadcast": (
            "_send:broadcast",
            "Tell everybody who listens; that nobody does is no error.",
        ),
        "var": (
            "_variables:var",
            "Read, set and follow the variables that all modules share.",
        ),
    },
    "Tasks": {
        "goal": ("_tasks:goal", "Send a goal and wait for its result; Ctrl-C kills it."),
        "command": ("_tasks:command", "Send a command and wait for its result; Ctrl-C kills it."),
        "tree": (
            "_tree:tree",
            "Show the task tree: what runs, what it waits for, and what ended last.",
        ),
        "kill": ("_tasks:kill", "Kill a task and all below it."),
        "suspend": (
            "_steer:suspend",
            "Give nothing at or below a task to a handler any more; handlers that run go on.",
        ),
        "resume": ("_steer:resume", "Let a suspended task go on."),
        "retry": (
            "_steer:retry",
            "Stop what runs of a living task and below it, and have it handled again.",
        ),
        "prioritize": (
            "_steer:prioritize",
            "Change the priority of a task and put what waits in order again.",
        ),
        "log": ("_history:log", "Show what happened to tasks, in the grammar of TCA's own log."),
        "tap": (
            "_tap:tap_message",
            "Print each message that comes to a condition, until interrupted.",
        ),
    },
    "Resources": {
        "resources": (
            "_resources:resources",
            "List all resources: who holds them, who waits and why, what was dropped.",
        ),
        "reserve": (
            "_resources:reserve",
            "Reserve a resource for one module until it is unlocked.",
        ),
        "lock": (
            "_resources:lock",
            "Lock a resource: nobody's messages and leases pass until it is unlocked.",
        ),
        "unlock": (
            "_resources:unlock",
            "Take a resource from whoever holds it: a lock or reservation, else all leases of it.",
        ),
    },
    "Recordings": {
        "record": (
            "_record:record",
            "Record what passes on the realm into an MCAP file, until Ctrl-C.",
        ),
        "replay": (
            "_record:replay",
            "Replay a recording on the realm, whichever it was recorded on.",
        ),
    },
    "Who may do what": {
        "policy": (
            "_policy:policy",
            "Show what a policy file allows, or ask it: exit code 0 for yes, 7 for no.",
        ),
        "keys": (
            "_keys:keys_app",
            "Make, renew and list the keys with which modules join a guarded router.",
        ),
    },
}
"""Where each command is and what it does, under the headings of the help."""

for group, commands in GROUPS.items():
    add_commands(app, "tca_bus.cli", commands, group=group)


def main() -> NoReturn:
    """Run ``tca``."""
    run_app(app)
