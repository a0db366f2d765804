"""The command line ``xavier``."""

from tca_bus.cli import add_commands, make_app, run_app

__all__ = ["app", "main"]

COMMANDS = {
    "run": ("_run:run", "Run the simulated robot until it is stopped."),
    "replay": (
        "_recording:replay",
        "Play a recorded robot to the navigator in place of the simulated one, to its end.",
    ),
    "verify": (
        "_recording:verify",
        "Simulate a recording again, and compare each sensor reading bit for bit.",
    ),
    "speech": ("_speech:speech", "Run the speech board and the keyboard until they are stopped."),
    "survey": (
        "_survey:survey",
        "Write the plan of a floor with the small errors of a survey, for a navigator.",
    ),
    "soak": (
        "_soak:soak",
        "Send the robot on random errands for hours, and say what came of them.",
    ),
    "door": ("_world:door", "Open or close the door of a room."),
    "doors": ("_world:doors", "Show how every door stands."),
    "where": (
        "_world:where",
        "Show where the robot really is; 'navigate where' shows where it believes to be.",
    ),
    "battery": ("_world:battery", "Show how full the battery is."),
    "plate": ("_world:plate", "Let the camera read the door plate that it sees best."),
    "person": (
        "_world:person",
        "Send the one who works in a room out, so that nobody answers there, or back in.",
    ),
    "fault": (
        "_faults:fault",
        "Let something go wrong with the robot at once, show what is wrong, or mend it.",
    ),
}
"""Where each command is and what it does; only the one that is called is imported."""

app = make_app("xavier", help="The simulated robot, the office round it, and its speech board.")
add_commands(app, "xavier_sim.cli", COMMANDS)


def main() -> None:
    """Run the command line."""
    run_app(app)
