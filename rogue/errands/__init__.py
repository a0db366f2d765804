"""ROGUE's office for the planner: domain, rules, and the switches of the papers' examples."""

from __future__ import annotations

from rogue.errands._office import (
    Distance,
    Errand,
    ErrandRooms,
    Switches,
    errand_rooms_rule,
    example1998,
    figure6,
    figure9,
    goto_for_consumer_rule,
    item_of_consumer_rule,
    load_office_domain,
    load_office_problem,
    nearest_room_rule,
    no_premature_goto_rule,
    robot_room,
    working,
)

__all__ = [
    "Distance",
    "Errand",
    "ErrandRooms",
    "Switches",
    "errand_rooms_rule",
    "example1998",
    "figure6",
    "figure9",
    "goto_for_consumer_rule",
    "item_of_consumer_rule",
    "load_office_domain",
    "load_office_problem",
    "nearest_room_rule",
    "no_premature_goto_rule",
    "robot_room",
    "working",
]
