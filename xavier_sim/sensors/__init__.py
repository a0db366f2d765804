"""What the robot senses the world with: sonars and camera, and the rays behind them."""

from xavier_sim.sensors._camera import Camera, Look
from xavier_sim.sensors._caster import Caster
from xavier_sim.sensors._choice import Rays, make_caster
from xavier_sim.sensors._rays import RayCaster
from xavier_sim.sensors._senses import NoSensorError, Sensed, Senses
from xavier_sim.sensors._sonar import SonarRing

__all__ = [
    "Camera",
    "Caster",
    "Look",
    "NoSensorError",
    "RayCaster",
    "Rays",
    "Sensed",
    "Senses",
    "SonarRing",
    "make_caster",
]
