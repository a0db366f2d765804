"""The command line ``navigate``."""

from tca_bus.cli import add_commands, make_app, run_app

__all__ = ["app", "main"]

COMMANDS = {
    "run": ("_run:run", "Run the navigator until it is stopped."),
    "plan": (
        "_plan:plan",
        "Show the best route between two rooms, as the navigator knows the floor now.",
    ),
    "stop": ("_stop:stop", 'Stop the robot now. The drive under way fails with "cancelled".'),
    "where": ("_where:where", "Show where the robot believes to be."),
}
"""Where each command is and what it does; only the one that is called is imported."""

app = make_app("navigate", help="Find the way, know the place, drive the robot.")
add_commands(app, "navigate.cli", COMMANDS)


def main() -> None:
    """Run the command line."""
    run_app(app)
