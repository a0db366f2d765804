"""Deadlines as people write them."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

from rogue.errors import DeadlineError, MomentError
from rogue.times import show_time

LONGEST_SECONDS = 366 * 86400.0
"""Deadlines beyond a year are taken for slips of the pen."""

_UNITS = {"s": 1.0, "sec": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_PART = re.compile(r"(\d+(?:\.\d+)?)\s*(sec|s|min|m|h|d)", re.IGNORECASE)
_RELATIVE = re.compile(rf"\+?\s*(?:{_PART.pattern}\s*)+", re.IGNORECASE)
_CLOCK = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)")
_WEEKDAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_TIME = r"(?P<hour>[01]?\d|2[0-3]):(?P<minute>[0-5]\d)"
_DAY = rf"(?:(?P<weekday>{'|'.join(_WEEKDAYS)}) )?(?P<month>{'|'.join(_MONTHS)}) (?P<day>[0-3]?\d)"
_DATED = (re.compile(rf"{_DAY} {_TIME}"), re.compile(rf"{_TIME} {_DAY}"))


def read_deadline(text: str, now: float) -> float:
    """Read a deadline in seconds since the epoch.

    Clock times without a zone are local time; ``HH:MM`` is the one nearest to now. Days may be
    written as the papers do: ``Wed Oct 1 13:48``, or as in Figure 4, ``14:33 Fri Dec 1``.

    Raises:
        DeadlineError: ``text`` cannot be read, or names a time that has passed.
    """
    deadline = _read(text.strip(), now)
    if deadline is None:
        raise DeadlineError(text, "cannot be read")
    if deadline <= now:
        raise DeadlineError(text, f"has passed (it is {show_time(now)})")
    if deadline > now + LONGEST_SECONDS:
        raise DeadlineError(text, "is more than a year away")
    return deadline


def read_moment(text: str, now: float) -> float:
    """Read a time that has passed, in seconds since the epoch.

    A span is so long ago, ``HH:MM`` the last time that it was so late.

    Raises:
        MomentError: ``text`` cannot be read.
    """
    span = read_span(text)
    if span is not None:
        return now - span
    moment = _read(text.strip(), now)
    if moment is None:
        raise MomentError(text)
    is_to_come = moment > now and _CLOCK.fullmatch(text.strip()) is not None
    return moment - 86400.0 if is_to_come else moment


def read_span(text: str) -> float | None:
    """Seconds of a time from now on, ``30m`` or ``1h30m``; None of anything else."""
    if not _RELATIVE.fullmatch(text.strip()):
        return None
    return sum(float(number) * _UNITS[unit.lower()] for number, unit in _PART.findall(text))


def _read(text: str, now: float) -> float | None:
    span = read_span(text)
    if span is not None:
        return now + span
    if clock := _CLOCK.fullmatch(text):
        return _nearest_clock_time(int(clock[1]), int(clock[2]), now)
    words = " ".join(text.lower().split())
    for form in _DATED:
        if dated := form.fullmatch(words):
            return _nearest_date(dated, now)
    try:
        return datetime.fromisoformat(text).astimezone().timestamp()
    except (ValueError, OverflowError):
        return None


def _nearest_clock_time(hour: int, minute: int, now: float) -> float:
    """At ten to midnight 00:30 is tomorrow's, at half past two 14:00 has passed."""
    today = datetime.fromtimestamp(now).astimezone()
    moment = today.replace(hour=hour, minute=minute, second=0, microsecond=0)
    if today - moment > timedelta(hours=12):
        moment += timedelta(days=1)
    return moment.timestamp()


def _nearest_date(dated: re.Match[str], now: float) -> float | None:
    """The next such day, or one of the last half year; None if its weekday is another."""
    today = datetime.fromtimestamp(now).astimezone()
    month = _MONTHS.index(dated["month"]) + 1
    day, hour, minute = (int(dated[name]) for name in ("day", "hour", "minute"))
    for year in (today.year, today.year + 1):
        try:
            moment = datetime(year, month, day, hour, minute).astimezone()
        except ValueError:
            continue
        if today - moment < timedelta(days=183):
            fits = dated["weekday"] in {None, _WEEKDAYS[moment.weekday()]}
            return moment.timestamp() if fits else None
    return None
