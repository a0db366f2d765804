"""The body of the robot: base, battery, bump panels, odometry, and physics among walls."""

from xavier_sim.body._base import clip_command
from xavier_sim.body._battery import Battery
from xavier_sim.body._bumpers import Bumpers
from xavier_sim.body._disc import Disc
from xavier_sim.body._odometry import Odometry, wrap
from xavier_sim.body._people_met import PeopleMet
from xavier_sim.body._physics import BodyState, Contact, Physics, RobotBody
from xavier_sim.body._wheels import Wheels

__all__ = [
    "Battery",
    "BodyState",
    "Bumpers",
    "Contact",
    "Disc",
    "Odometry",
    "PeopleMet",
    "Physics",
    "RobotBody",
    "Wheels",
    "clip_command",
    "wrap",
]
