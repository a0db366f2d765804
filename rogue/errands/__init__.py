"""ROGUE's office for the planner: domain, rules, and the switches of the papers' examples."""

from __future__ import annotations

from rogue.errands._office import (
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
from rogue.errands._tour import Distance, OpenErrand, Stop, Tour, Travel, TravelError
from rogue.errands._tour_exact import EXACT_UP_TO
from rogue.errands._touring import Promise, RunningTour, best_tour, promise

__all__ = [
    "EXACT_UP_TO",
    "Distance",
    "Errand",
    "ErrandRooms",
    "OpenErrand",
    "Promise",
    "RunningTour",
    "Stop",
    "Switches",
    "Tour",
    "Travel",
    "TravelError",
    "best_tour",
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
    "promise",
    "robot_room",
    "working",
]
