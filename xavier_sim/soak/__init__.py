"""Random errands for hours with any navigator, in one process, and what they came to."""

from xavier_sim.soak._contract import (
    Believed,
    DriveReport,
    DriveUnderWay,
    Failure,
    NavigatorCore,
    NavigatorFactory,
    Wheels,
)
from xavier_sim.soak._jobs import Job, Way
from xavier_sim.soak._loading import NavigatorError, load_factory, navigator_names
from xavier_sim.soak._mishaps import FAULT_KINDS, FaultKind
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._report import report
from xavier_sim.soak._running import SoakRun
from xavier_sim.soak._soak import Soak
from xavier_sim.soak._summary import Rate, Spread, Summary

__all__ = [
    "FAULT_KINDS",
    "Believed",
    "DriveReport",
    "DriveUnderWay",
    "Failure",
    "FaultKind",
    "Job",
    "NavigatorCore",
    "NavigatorError",
    "NavigatorFactory",
    "Rate",
    "Soak",
    "SoakOptions",
    "SoakRun",
    "Spread",
    "Summary",
    "Way",
    "Wheels",
    "load_factory",
    "navigator_names",
    "report",
]
