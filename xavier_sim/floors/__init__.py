"""Floors: from files, checked, as geometry, and as a survey measures them."""

from xavier_sim.floors._doors import Doors, DoorStanding, UnknownDoorError
from xavier_sim.floors._floor import DEFAULT_FLOOR, find_floor, load_floor
from xavier_sim.floors._floor_checks import FloorError
from xavier_sim.floors._geometry import (
    WALL_RADIUS,
    Edge,
    Geometry,
    build_geometry,
    door_edge,
    door_room,
    segment_distances,
    shared_edges,
    space_at,
)
from xavier_sim.floors._survey import plan_to_yaml, survey_floor

__all__ = [
    "DEFAULT_FLOOR",
    "WALL_RADIUS",
    "DoorStanding",
    "Doors",
    "Edge",
    "FloorError",
    "Geometry",
    "UnknownDoorError",
    "build_geometry",
    "door_edge",
    "door_room",
    "find_floor",
    "load_floor",
    "plan_to_yaml",
    "segment_distances",
    "shared_edges",
    "space_at",
    "survey_floor",
]
