"""What users ask for: their requests, who they are, and the desk that answers them."""

from __future__ import annotations

from rogue.requests._book import RequestBook
from rogue.requests._desk import Desk
from rogue.requests._directory import Directory, load_directory
from rogue.requests._entries import Person, read_entries
from rogue.requests._finger import FingerServer, finger, finger_server
from rogue.requests._intake import accept, draft, is_same_errand, refuse_duplicate
from rogue.requests._outlook import Outlook
from rogue.requests._pace import at_pace
from rogue.requests._plan_file import PlanFile, read_plan
from rogue.requests._prospects import Prospects
from rogue.requests._questions import Questions
from rogue.requests._reception import Reception
from rogue.requests._reloading import reread_on_hangup

__all__ = [
    "Desk",
    "Directory",
    "FingerServer",
    "Outlook",
    "Person",
    "PlanFile",
    "Prospects",
    "Questions",
    "Reception",
    "RequestBook",
    "accept",
    "at_pace",
    "draft",
    "finger",
    "finger_server",
    "is_same_errand",
    "load_directory",
    "read_entries",
    "read_plan",
    "refuse_duplicate",
    "reread_on_hangup",
]
