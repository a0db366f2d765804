"""The ``rogue`` command."""

from rogue.cli._agent import agent
from rogue.cli._demo import demo
from rogue.cli._requests import cancel, request, requests, show, why
from rogue.cli._solve import solve
from rogue.cli._trace import plan, trace
from rogue.cli._up import up
from tca_bus.cli import make_app, run_app

__all__ = ["app", "main"]

app = make_app("rogue", help="ROGUE plans errands for many users and has Xavier run them.")
for command in (up, demo, request, requests, show, cancel, plan, trace, why, solve, agent):
    app.command(command)


def main() -> None:
    """Run the command line."""
    run_app(app)
