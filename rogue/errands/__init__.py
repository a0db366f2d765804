"""ROGUE's office for the planner: domains, rules, priorities, tours, and the papers' examples."""

from __future__ import annotations

from rogue.errands._advice import Advice, Outlook
from rogue.errands._agenda import MARGIN, NEARBY, Agenda, robot_room
from rogue.errands._errand import Errand
from rogue.errands._lists import Lists, ListWatcher, Moment
from rogue.errands._priority import (
    Claim,
    Metric,
    MetricError,
    RankSum,
    guarded,
    load_metric,
)
from rogue.errands._published_rules import goto_for_consumer_rule, nearest_room_rule
from rogue.errands._selection import Selected, select
from rogue.errands._switches import (
    Switches,
    example1998,
    figure6,
    figure9,
    load_office_domain,
    load_office_problem,
    load_working_domain,
    working,
)
from rogue.errands._tour import Distance, OpenErrand, Stop, Tour, Travel, TravelError
from rogue.errands._tour_exact import EXACT_UP_TO
from rogue.errands._touring import Promise, RunningTour, best_tour, promise
from rogue.errands._tray import MOST_PLACES, TrayError, tray_counts, tray_facts, tray_state

__all__ = [
    "EXACT_UP_TO",
    "MARGIN",
    "MOST_PLACES",
    "NEARBY",
    "Advice",
    "Agenda",
    "Claim",
    "Distance",
    "Errand",
    "ListWatcher",
    "Lists",
    "Metric",
    "MetricError",
    "Moment",
    "OpenErrand",
    "Outlook",
    "Promise",
    "RankSum",
    "RunningTour",
    "Selected",
    "Stop",
    "Switches",
    "Tour",
    "Travel",
    "TravelError",
    "TrayError",
    "best_tour",
    "example1998",
    "figure6",
    "figure9",
    "goto_for_consumer_rule",
    "guarded",
    "load_metric",
    "load_office_domain",
    "load_office_problem",
    "load_working_domain",
    "nearest_room_rule",
    "promise",
    "robot_room",
    "select",
    "tray_counts",
    "tray_facts",
    "tray_state",
    "working",
]
