"""The ``rogue`` command."""

from tca_bus.cli import add_commands, make_app, run_app

__all__ = ["app", "main"]

COMMANDS = {
    "up": (
        "_up:up",
        "Run the whole office: router, central, robot, speech, navigator and planner.",
    ),
    "demo": (
        "_demo:demo",
        "Play one of the papers' scenarios in an office of its own, as fast as the machine can.",
    ),
    "day": (
        "_day:day",
        "Play a day with many users in an office of its own, and check how every request ended.",
    ),
    "request": ("_requests:request", "Ask the robot for an errand."),
    "requests": ("_requests:requests", "List the requests, the oldest first."),
    "show": ("_requests:show", "Show one request with the steps that were carried out for it."),
    "cancel": ("_requests:cancel", "Take a request back, at whatever stage it is."),
    "plan": (
        "_plan:plan",
        "Show the plan that is being carried out, or the last one: goals, operators, steps.",
    ),
    "trace": ("_trace:trace", "Print the conversation, as Figure 6 of the paper shows it."),
    "why": ("_requests:why", "Say why a request stands where it does."),
    "solve": (
        "_solve:solve",
        "Plan with PRODIGY: a domain and a problem, in its own language or both in PDDL.",
    ),
    "agent": (
        "_agent:agent",
        "Run the ROGUE agent: it accepts requests, plans, and has the robot carry the plans out.",
    ),
}
"""Where each command is and what it does; only the one that is called is imported."""

app = make_app("rogue", help="ROGUE plans errands for many users and has Xavier run them.")
add_commands(app, "rogue.cli", COMMANDS)


def main() -> None:
    """Run the command line."""
    run_app(app)
