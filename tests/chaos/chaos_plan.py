"""What happens in a chaos run, from a seed: which tasks are sent, and who is killed when."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import get_args

from tca_bus import Constraint
from tca_bus._messages import ModuleLostPolicy

POLICIES: tuple[str, ...] = get_args(ModuleLostPolicy)
"""What a message may say of the loss of its module; a new policy is part of the run at once."""

INFRASTRUCTURE = ("router", "central")
INFRASTRUCTURE_SHARE = 1 / 3
"""How many of the kills strike the router or central; the others strike modules."""

GOAL_SHARE = 0.2
FAILURE_SHARE = 0.1
SENDER_KILL_SHARE = 0.08
SEQUENCE_SHARE = 0.1

LONGEST_WORK = 0.6
LONGEST_PAUSE = 0.5
"""Wall seconds."""


@dataclass(frozen=True)
class PlannedTask:
    """One top-level task: a command, or a goal with ``children`` commands below it.

    ``killed_after`` is after how many wall seconds its sender kills it; ``lenient`` goals go on
    when a child fails.
    """

    id: str
    policy: str
    child_policy: str
    work: float
    fails: bool
    children: int
    lenient: bool
    killed_after: float | None
    constraints: Constraint

    @property
    def is_goal(self) -> bool:
        """Whether it has children."""
        return self.children > 0


@dataclass(frozen=True)
class PlannedKill:
    """Kill ``victim`` by force ``pause`` seconds after task number ``after`` was sent."""

    victim: str
    after: int
    pause: float


@dataclass(frozen=True)
class Plan:
    """A whole run; the same seed and sizes give the same plan."""

    seed: int
    modules: tuple[str, ...]
    tasks: tuple[PlannedTask, ...]
    kills: tuple[PlannedKill, ...]


def make_plan(*, seed: int, tasks: int, kills: int, modules: int) -> Plan:
    """Draw a plan."""
    rng = random.Random(seed)
    names = tuple(f"crew-{number}" for number in range(modules))
    return Plan(
        seed,
        names,
        tuple(_task(rng, seed, number) for number in range(tasks)),
        tuple(_kills(rng, names, tasks=tasks, kills=kills)),
    )


def _task(rng: random.Random, seed: int, number: int) -> PlannedTask:
    is_killed = rng.random() < SENDER_KILL_SHARE
    return PlannedTask(
        id=f"chaos-{seed}-{number}",
        policy=rng.choice(POLICIES),
        child_policy=rng.choice(POLICIES),
        work=rng.uniform(0.0, LONGEST_WORK),
        fails=rng.random() < FAILURE_SHARE,
        children=rng.randint(1, 4) if rng.random() < GOAL_SHARE else 0,
        lenient=rng.random() < 0.5,
        killed_after=rng.uniform(0.0, LONGEST_WORK) if is_killed else None,
        constraints=Constraint.SEQ_ACH if rng.random() < SEQUENCE_SHARE else Constraint.NONE,
    )


def _kills(
    rng: random.Random, modules: tuple[str, ...], *, tasks: int, kills: int
) -> list[PlannedKill]:
    """Kills spread over the run; router and central are among the victims of any run."""
    central = round(kills * INFRASTRUCTURE_SHARE)
    victims = [INFRASTRUCTURE[number % 2] for number in range(central)]
    victims += [rng.choice(modules) for _ in range(kills - central)]
    rng.shuffle(victims)
    times = sorted(rng.randrange(tasks) for _ in victims)
    return [
        PlannedKill(victim, after, rng.uniform(0.0, LONGEST_PAUSE))
        for victim, after in zip(victims, times, strict=True)
    ]
