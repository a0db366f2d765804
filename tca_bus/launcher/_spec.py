"""What to run, and how to treat it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from tca_bus._errors import ConfigError, did_you_mean
from tca_bus.launcher._ready import Ready
from tca_bus.launcher._restart import DEFAULT_POLICY, RestartPolicy

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class ProcessSpec:
    """One process of an office.

    Attributes:
        name: Shown before its log lines; also the name of its log file.
        argv: The program and its arguments.
        ready: When it counts as started; None: as soon as it runs.
        restart: When it is started again after an end that nobody asked for; None: never, and
            its end is not noticed.
        env: Added to the launcher's environment.
        stdin: ``inherit`` hands over the launcher's standard input, ``none`` an empty one.
        output: ``log`` takes its output as log lines; ``inherit`` leaves standard output alone,
            for a process that talks with a person, and takes standard error only.
        after: Names of earlier specs that must be ready first; None: all earlier ones.
        ready_timeout: Seconds it may take until it is ready.
        grace: Seconds between SIGTERM and SIGKILL.
    """

    name: str
    argv: Sequence[str]
    ready: Ready | None = None
    restart: RestartPolicy | None = DEFAULT_POLICY
    env: Mapping[str, str] = field(default_factory=dict)
    stdin: Literal["inherit", "none"] = "none"
    output: Literal["log", "inherit"] = "log"
    after: Sequence[str] | None = None
    ready_timeout: float = 30.0
    grace: float = 5.0

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            expected = "letters, digits, and after the first also '.', '_' and '-'"
            raise ConfigError("ProcessSpec.name", self.name, expected)
        if isinstance(self.argv, str) or not self.argv:
            raise ConfigError("ProcessSpec.argv", self.argv, "a list with at least the program")


def start_order(specs: Sequence[ProcessSpec]) -> dict[str, tuple[str, ...]]:
    """Map each name to the names that must be ready before it, in the order of the specs.

    Raises:
        ConfigError: a name is there twice, or ``after`` names no earlier spec.
    """
    order: dict[str, tuple[str, ...]] = {}
    for spec in specs:
        if spec.name in order:
            raise ConfigError("ProcessSpec.name", spec.name, "a name that no other process has")
        after = tuple(order) if spec.after is None else tuple(spec.after)
        for name in after:
            if name not in order:
                hint = did_you_mean(name, order)
                raise ConfigError(f"after of {spec.name}", name, f"an earlier process.{hint}")
        order[spec.name] = after
    return order
