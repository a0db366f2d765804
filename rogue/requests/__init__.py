"""What users ask for: their requests, who they are, and the desk that answers them."""

from __future__ import annotations

from rogue.requests._book import RequestBook
from rogue.requests._desk import Desk
from rogue.requests._directory import Directory, load_directory
from rogue.requests._intake import accept, is_same_errand

__all__ = [
    "Desk",
    "Directory",
    "RequestBook",
    "accept",
    "is_same_errand",
    "load_directory",
]
