"""Flags that several commands of ``xavier`` have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tca_bus import ConfigError

Data = Annotated[Path | None, Parameter(env_var="TCA_DATA")]


def checked_seed(seed: int) -> int:
    """A seed that was typed.

    Raises:
        ConfigError: It is negative.
    """
    if seed < 0:
        raise ConfigError("--seed", seed, "0 or more")
    return seed
