"""Times as the papers write them; local time of this machine."""

from __future__ import annotations

import math
from datetime import datetime


def show_time(when: float) -> str:
    """A time as the papers' request messages have it: ``Oct 1 12:51``."""
    moment = datetime.fromtimestamp(when).astimezone()
    return f"{moment:%b} {moment.day} {moment:%H:%M}"


def show_minute_after(when: float) -> str:
    """The full minute in which something is over, as `show_time` has it."""
    return show_time(math.ceil(when / 60.0) * 60.0)


def show_deadline(when: float) -> str:
    """A deadline as the papers' request messages have it: ``Wed Oct 1 13:48``."""
    moment = datetime.fromtimestamp(when).astimezone()
    return f"{moment:%a} {show_time(when)}"
