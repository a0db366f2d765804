"""A believed position in words."""

from __future__ import annotations

from navigate.messages import Position


def in_words(position: Position, *, heading: bool = True) -> str:
    """Where the robot believes to be, with or without its heading; first of all, if it is lost."""
    where = place_in_words(position, heading=heading)
    if not position.heard and position.lost:
        return f"no robot has been heard yet, and it may be elsewhere than at {where}"
    if not position.heard:
        return f"no robot has been heard yet: it is taken to be at {where}"
    if position.lost:
        return f"lost: it may be at {where}"
    return where


def place_in_words(position: Position, *, heading: bool = True) -> str:
    """The place alone, and how sure the robot is of it, which means nothing in one that is lost."""
    turned = f", heading {position.theta:.2f} rad" if heading else ""
    where = f"({position.x:.2f}, {position.y:.2f}) m{turned}"
    room = f", at {position.room}" if position.room else ""
    if position.lost or not position.heard:
        return f"{where}{room}"
    doubt = f" and {position.heading_deviation:.2f} rad" if heading else ""
    sure = f" ({position.confidence:.0%} sure)" if position.room else ""
    return f"{where}, give or take {position.deviation:.2f} m{doubt}{room}{sure}"
