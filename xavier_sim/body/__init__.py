"""The body of the robot: base, battery, bump panels, odometry, and physics among walls."""

from xavier_sim.body._base import clip_command, next_speed, next_turn_rate
from xavier_sim.body._battery import Battery
from xavier_sim.body._bumpers import Bumpers
from xavier_sim.body._disc import Disc
from xavier_sim.body._odometry import Odometry, wrap
from xavier_sim.body._people_met import PeopleMet
from xavier_sim.body._physics import BodyState, Contact, Physics, RobotBody

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
    "clip_command",
    "next_speed",
    "next_turn_rate",
    "wrap",
]
