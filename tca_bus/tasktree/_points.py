"""The points in time of a node, between which constraints are stated."""

from __future__ import annotations

import enum


class Point(enum.Enum):
    """Start and end of the intervals of a node (``tcaStartOf``, ``tcaEndOf``)."""

    START_HANDLING = "start of handling"
    END_HANDLING = "end of handling"
    START_PLANNING = "start of planning"
    END_PLANNING = "end of planning"
    START_ACHIEVING = "start of achievement"
    END_ACHIEVING = "end of achievement"


PointOf = tuple[str, Point]
"""A point of the node with this id."""
