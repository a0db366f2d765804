"""A believed position in words."""

from __future__ import annotations

from navigate.messages import Position


def in_words(position: Position, *, heading: bool = True) -> str:
    """Where the robot believes to be and how sure it is, with or without its heading."""
    turned = f", heading {position.theta:.2f} rad" if heading else ""
    doubt = f" and {position.heading_deviation:.2f} rad" if heading else ""
    room = f", at {position.room} ({position.confidence:.0%} sure)" if position.room else ""
    return (
        f"({position.x:.2f}, {position.y:.2f}) m{turned}, "
        f"give or take {position.deviation:.2f} m{doubt}{room}"
    )
