"""What the robot senses the world with: sonars and camera, and the rays behind them."""

from xavier_sim.sensors._camera import Camera, Look
from xavier_sim.sensors._rays import RayCaster
from xavier_sim.sensors._sonar import SonarRing

__all__ = [
    "Camera",
    "Look",
    "RayCaster",
    "SonarRing",
]
