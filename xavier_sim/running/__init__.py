"""The world as it runs on the bus: in lockstep or by the wall clock."""

from xavier_sim.running._faults import make_fault
from xavier_sim.running._outlet import Witness
from xavier_sim.running._pacing import parse_speed
from xavier_sim.running._reflex import Reflex
from xavier_sim.running._robot_module import RobotModule
from xavier_sim.running._robot_state import RobotState
from xavier_sim.running._simulated_time import SimClock
from xavier_sim.running._team import Team, run_team

__all__ = [
    "Reflex",
    "RobotModule",
    "RobotState",
    "SimClock",
    "Team",
    "Witness",
    "make_fault",
    "parse_speed",
    "run_team",
]
