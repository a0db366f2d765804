"""Which way to go: the topological graph, A* over it, and what stands in the way."""

from navigate.routes._distances import Distances, as_table
from navigate.routes._graph import show_point
from navigate.routes._hindrances import Hindrances
from navigate.routes._memory import CERTAIN, REMEMBER, Memory
from navigate.routes._routes import (
    NoRouteError,
    Planner,
    Step,
    describe,
    remaining,
    seconds_left,
    side_of,
)

__all__ = [
    "CERTAIN",
    "REMEMBER",
    "Distances",
    "Hindrances",
    "Memory",
    "NoRouteError",
    "Planner",
    "Step",
    "as_table",
    "describe",
    "remaining",
    "seconds_left",
    "show_point",
    "side_of",
]
