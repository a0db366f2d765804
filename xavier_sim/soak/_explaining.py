"""One plain sentence about why a drive failed, from the facts of its post-mortem."""

from __future__ import annotations

import math
from collections import Counter

from xavier_sim.soak._jobs import ENDLESS, Job
from xavier_sim.soak._postmortem import ASTRAY_FROM, NEAR, Company, PostMortem, RoomDoor, Stray
from xavier_sim.soak._way import Way

HEADING_OFF = 10.0
"""Degrees of an error of the heading that is told of a robot that knows its place."""

AHEAD, BEHIND = 45.0, 135.0
"""Degrees of bearing up to which somebody is before the robot, and from which behind it."""

AWHILE = 15.0
"""Seconds of company from which whoever is before the robot keeps it out of a door."""

WINDS = (
    "east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east",
)  # fmt: skip

SAID = {
    "bump": "could not back out of a contact on its way to {goal}",
    "cancelled": "was stopped on its way to {goal}",
    "corridor_blocked": "took its way to {goal} for blocked",
    "lost": "was lost on its way to {goal}",
    "no_progress": "came no nearer to {goal}",
    "no_route": "knew of no way to {goal}",
    ENDLESS: "did not get to {goal} within {seconds:.0f} s",
}
"""What a navigator said with the reasons that are known, and ``door_blocked`` beside."""

PARTED = {
    Stray.BEFORE: "since before it set out",
    Stray.CARRIED: "since it was put down in {space}",
    Stray.JUMPED: "since its belief jumped, in {space}",
    Stray.DRIFTED: "from {space} on",
}
"""Since when a robot has been astray."""


def explain(job: Job, facts: PostMortem) -> str:
    """Why a job failed, as an engineer would say it."""
    circumstances = [_position(facts), _presence(facts), *_doors(job, facts)]
    return f"{_what(job, facts)}: {'; '.join(one for one in circumstances if one)}"


def _what(job: Job, facts: PostMortem) -> str:
    if job.reason is None:
        return f"said that it was at {job.goal}, and was {job.off:.2f} m from its place"
    if job.reason == "door_blocked":
        return _at_door(facts.blamed or job.goal, facts)
    said = SAID.get(job.reason, "gave {goal} up as {reason}")
    return said.format(goal=job.goal, seconds=job.seconds, reason=job.reason)


def _at_door(room: str, facts: PostMortem) -> str:
    doors = _of_room(room, facts)
    if not doors:
        return f"took the door of {room} for shut"
    if all(door.last_minute is Way.OPEN for door in doors):
        if _waits_for_somebody(facts):
            return f"was kept out of the open door of {room}"
        return f"took the open door of {room} for shut"
    if any(door.is_open for door in doors):
        return f"took the door of {room} for shut, which had moved in the last minute"
    return f"found the door of {room} shut, though there was another way"


def _waits_for_somebody(facts: PostMortem) -> bool:
    """Whether somebody has stood before the robot for a while."""
    ahead = any(abs(one.bearing) <= AHEAD for one in facts.company)
    return ahead and facts.in_company >= AWHILE


def _position(facts: PostMortem) -> str:
    """Whether it knew where it was."""
    if facts.error > ASTRAY_FROM:
        return _astray(facts)
    known = f"knew where it stood to {facts.error:.2f} m"
    if abs(facts.turned) > HEADING_OFF:
        return f"{known}, but not where it looked, by {_degrees(facts.turned)}"
    return known


def _astray(facts: PostMortem) -> str:
    east, north = facts.x - facts.believed_x, facts.y - facts.believed_y
    parts = [f"stood {facts.error:.2f} m {_wind(east, north)} of where it believed"]
    if facts.space != facts.believed_space:
        parts.append(f"in {facts.space or 'a wall'} and not {facts.believed_space or 'a space'}")
    if round(abs(facts.turned)):
        parts.append(f"heading off by {_degrees(facts.turned)}")
    if facts.stray:
        parts.append(f"for {facts.astray:.0f} s, {PARTED[facts.stray]}")
    return ", ".join(parts).format(space=facts.strayed_in)


def _presence(facts: PostMortem) -> str:
    """Who and what was near it."""
    if not facts.company:
        return ""
    nearest = facts.company[0]
    where = f"{max(nearest.gap, 0.0):.1f} m {_side(nearest)}"
    since = f" for {facts.in_company:.0f} s" if facts.in_company else ""
    if len(facts.company) == 1:
        return f"had a {nearest.kind} {where}{since}"
    return f"had {_counted(facts)} within {NEAR:g} m{since}, the nearest {where}"


def _counted(facts: PostMortem) -> str:
    count = Counter(one.kind for one in facts.company)
    names = {"person": "people", "cart": "carts"}
    said = [f"{n} {names[kind]}" if n > 1 else f"a {kind}" for kind, n in sorted(count.items())]
    return " and ".join(said)


def _doors(job: Job, facts: PostMortem) -> list[str]:
    """How the doors stood that were not open, of the rooms that are not told of already."""
    told = (facts.blamed or job.goal) if job.reason == "door_blocked" else None
    return [
        f"the door of {door.room} {_stood(door)}"
        for door in facts.doors
        if door.last_minute is not Way.OPEN and door.room != told
    ]


def _stood(door: RoomDoor) -> str:
    if door.last_minute is Way.SHUT:
        return "was shut"
    return f"was {'opened' if door.is_open else 'shut'} within the last minute"


def _of_room(room: str, facts: PostMortem) -> list[RoomDoor]:
    return [door for door in facts.doors if door.room == room]


def _side(one: Company) -> str:
    if abs(one.bearing) <= AHEAD:
        return "before it"
    if abs(one.bearing) >= BEHIND:
        return "behind it"
    return f"to its {'left' if one.bearing > 0.0 else 'right'}"


def _wind(east: float, north: float) -> str:
    return WINDS[round(math.atan2(north, east) / (math.pi / 4)) % len(WINDS)]


def _degrees(angle: float) -> str:
    whole = round(abs(angle))
    return f"{whole} degree{'s' * (whole != 1)}"
