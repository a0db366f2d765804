"""How far soaks have come, told while they run: on standard error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from tca_bus.cli import note
from xavier_sim.soak import Standing

LINES = 20
"""Lines of progress that a soak writes where there is no terminal."""


class Progress(Protocol):
    """Tells how far each of some soaks has come."""

    def tell(self, standing: Standing) -> None:
        """A job of one of them has ended."""
        ...


class Lines:
    """A line of each soak now and then."""

    def __init__(self, seeds: Sequence[int], hours: float) -> None:
        self._step = hours * 3600.0 / LINES
        self._next = dict.fromkeys(seeds, self._step)

    def tell(self, standing: Standing) -> None:
        """Write a line when another twentieth is done."""
        if standing.seconds >= self._next[standing.seed]:
            self._next[standing.seed] = standing.seconds + self._step
            note(f"seed {standing.seed}: {standing}")


@contextmanager
def progress_of(seeds: Sequence[int], hours: float) -> Iterator[Progress]:
    """A bar for each soak on a terminal, lines elsewhere."""
    from rich.console import Console  # noqa: PLC0415 - only for this command
    from rich.progress import Progress as Bars  # noqa: PLC0415 - same
    from rich.progress import TextColumn, TimeRemainingColumn  # noqa: PLC0415 - same

    console = Console(stderr=True)
    if not console.is_terminal:
        yield Lines(seeds, hours)
        return
    columns = (
        *Bars.get_default_columns()[:3],
        TimeRemainingColumn(),
        TextColumn("{task.fields[at]}"),
    )
    with Bars(*columns, console=console) as bars:
        tasks = {seed: bars.add_task(f"seed {seed}", total=hours * 3600.0, at="") for seed in seeds}
        yield _Bars(lambda seed, seconds, at: bars.update(tasks[seed], completed=seconds, at=at))


class _Update(Protocol):
    def __call__(self, seed: int, seconds: float, at: str, /) -> object: ...


class _Bars:
    def __init__(self, update: _Update) -> None:
        self._update = update

    def tell(self, standing: Standing) -> None:
        self._update(standing.seed, standing.seconds, str(standing))
