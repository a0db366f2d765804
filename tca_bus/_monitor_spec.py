"""Monitors: a condition that is tested while something is under way, and what is done about it.

Source: TCA's point, polling (interval) and demon monitors. The condition is tested in the module
that serves it; central counts what it tells and sends the action.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus._attachments import Sending
from tca_bus._orders import PointRef


class Condition(BaseModel):
    """The answer of a condition: whether it is satisfied, and data for the action.

    Fields of ``data`` replace those of the action that have the same name.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    satisfied: bool
    data: dict[str, Any] = Field(default_factory=dict)


class MonitorSpec(BaseModel):
    """How a monitor tests and fires.

    ``period``, ``duration`` and ``first_wait`` are seconds on the clock of the module that tests;
    a ``duration`` of None has no limit. Each ``fire_every``-th satisfied test fires, at most
    ``max_fire`` times (None: no limit). ``until`` is the point at which it expires; by default
    that is the end of its parent's achievement.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["point", "polling", "demon"]
    action: Sending
    period: float = Field(default=1.0, gt=0.0, allow_inf_nan=False)
    duration: float | None = Field(default=None, gt=0.0)
    first_wait: float = Field(default=0.0, ge=0.0, allow_inf_nan=False)
    fire_every: int = Field(default=1, ge=1)
    max_fire: int | None = Field(default=None, ge=1)
    until: PointRef | None = None


class MonitorReport(BaseModel):
    """The result of a monitor: how often the condition held, and how often it fired."""

    model_config = ConfigDict(frozen=True)

    satisfied: int = 0
    fired: int = 0
