"""Random errands for hours with any navigator, in one process, and what they came to."""

from xavier_sim.soak._contract import (
    Believed,
    BlamesDoor,
    DriveReport,
    DriveUnderWay,
    Failure,
    NavigatorCore,
    NavigatorFactory,
    Wheels,
)
from xavier_sim.soak._cost import Cost
from xavier_sim.soak._course import Course
from xavier_sim.soak._door_rates import DoorRates
from xavier_sim.soak._doors import DoorKeeper, DoorMove
from xavier_sim.soak._errands import Goal
from xavier_sim.soak._explaining import explain
from xavier_sim.soak._figure_rows import figure_rows, reason_rows
from xavier_sim.soak._jobs import ENDLESS, TIME_LIMIT, Job
from xavier_sim.soak._loading import NavigatorError, load_factory, navigator_names
from xavier_sim.soak._mishaps import FAULT_KINDS, FaultKind, possible_faults
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._postmortem import Company, PostMortem, RoomDoor, Stray
from xavier_sim.soak._report import report
from xavier_sim.soak._running import SoakRun, Standing
from xavier_sim.soak._soak import EPOCH, Soak
from xavier_sim.soak._summary import (
    Explained,
    Figures,
    Outcome,
    Rate,
    Spread,
    Summary,
    Totals,
    together,
)
from xavier_sim.soak._tally import Tally
from xavier_sim.soak._watch import LOOK_EVERY, Seen, Watch
from xavier_sim.soak._way import Way

__all__ = [
    "ENDLESS",
    "EPOCH",
    "FAULT_KINDS",
    "LOOK_EVERY",
    "TIME_LIMIT",
    "Believed",
    "BlamesDoor",
    "Company",
    "Cost",
    "Course",
    "DoorKeeper",
    "DoorMove",
    "DoorRates",
    "DriveReport",
    "DriveUnderWay",
    "Explained",
    "Failure",
    "FaultKind",
    "Figures",
    "Goal",
    "Job",
    "NavigatorCore",
    "NavigatorError",
    "NavigatorFactory",
    "Outcome",
    "PostMortem",
    "Rate",
    "RoomDoor",
    "Seen",
    "Soak",
    "SoakOptions",
    "SoakRun",
    "Spread",
    "Standing",
    "Stray",
    "Summary",
    "Tally",
    "Totals",
    "Watch",
    "Way",
    "Wheels",
    "explain",
    "figure_rows",
    "load_factory",
    "navigator_names",
    "possible_faults",
    "reason_rows",
    "report",
    "together",
]
