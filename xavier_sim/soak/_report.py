"""Soaks as one HTML page: figures, plots, doors, and every job that did not end as it should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from xavier_sim.soak._door_rates import by_door, door_rates
from xavier_sim.soak._figure_rows import figure_rows
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._plots import plots
from xavier_sim.soak._summary import Figures, Outcome, together

MOST_ROWS = 500
"""Jobs that the list of failures shows at most."""

STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 1200px; padding: 0 1em;
       color: #222; background: #fff; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 1.5em; }
figure { margin: 0; }
table { border-collapse: collapse; margin: 1em 0; font-size: 14px; }
td, th { padding: 2px 10px; text-align: right; border-bottom: 1px solid #8884; }
td:first-child, th:first-child { text-align: left; }
table.words td { vertical-align: top; }
table.words :is(td, th):last-child { text-align: left; min-width: 28em; }
tr.sum td { font-weight: bold; }
@media (prefers-color-scheme: dark) { body { color: #ddd; background: #1b1b1b; } }
"""

DOOR_HEAD = (
    "room", "drives", "completed", "stuck", "% of drives", "recovered", "% of stuck", "given up",
    "% of drives", "door shut", "bumps",
)  # fmt: skip
WRONG_HEAD = (
    "seed", "job", "hour", "from", "to", "way", "ended", "at x, m", "at y, m", "s", "m", "off, m",
    "mean error, m", "worst error, m", "last error, m", "sure", "recoveries", "bumps",
)  # fmt: skip

WHY_HEAD = (
    "seed", "job", "hour", "from", "to", "ended", "along, m", "across, m",
    "heading, degrees", "why",
)  # fmt: skip

EXPLAINED = (
    "By the truth, at the end of each of these jobs. Errors are truth less belief along the longer "
    "side of the space in which the robot stood, and across; positive are east, north, and left."
)

DOORS = (
    "Of the drives into each room, and out of it where they were tried, whose way was open at all "
    "times: on those that are <i>stuck</i> the robot met trouble, in the door or elsewhere on the "
    "drive, <i>recovered</i> are those of them that arrived all the same, and <i>given up</i> "
    "those that ended with a reason instead."
)

Row = Sequence[object]


def report(outcomes: Sequence[Outcome]) -> str:
    """The page of soaks that differ in their seeds, with all that it shows in it."""
    title = _title(outcomes)
    jobs = [job for one in outcomes for job in one.tally.jobs]
    body = [
        f"<h1>{escape(title)}</h1>",
        _figures(outcomes),
        '<div class="plots">',
        *(f"<figure>{plot}</figure>" for plot in plots(outcomes)),
        "</div>",
        "<h2>Rooms and their doors</h2>",
        f"<p>{DOORS}</p>",
        _table(DOOR_HEAD, _doors(jobs), sums=1),
        "<h2>What did not end as it should</h2>",
        _table(WRONG_HEAD, [row for one in outcomes for row in _wrong(one)]),
        "<h2>Failures, explained</h2>",
        f"<p>{EXPLAINED}</p>",
        _table(WHY_HEAD, [row for one in outcomes for row in _whys(one)], style="words"),
        "<h2>Options</h2>",
        _table(("option", "value"), _options(outcomes)),
    ]
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return "\n".join(
        [f"<!doctype html><html lang=en><head>{head}</head><body>", *body, "</body></html>\n"]
    )


def _title(outcomes: Sequence[Outcome]) -> str:
    seeds = ", ".join(str(one.options.seed) for one in outcomes)
    hours = sum(one.seconds for one in outcomes) / 3600.0
    return f"{hours:.4g} hours of errands, seed{'s' * (len(outcomes) > 1)} {seeds}"


def _figures(outcomes: Sequence[Outcome]) -> str:
    columns = list[Figures](one.summary() for one in outcomes)
    if len(outcomes) == 1:
        return _table(("", ""), figure_rows(columns))
    columns.append(together(outcomes)[0])
    names = [f"seed {one.options.seed}" for one in outcomes]
    return _table(("", *names, "all"), figure_rows(columns))


def _doors(jobs: Sequence[Job]) -> Iterator[Row]:
    """All doors together, then each, in and out."""
    yield _door("all", jobs)
    for room, its in by_door(jobs).items():
        yield _door(room, its)


def _door(room: str, jobs: Sequence[Job]) -> Row:
    rates = door_rates(jobs)
    return (
        room,
        rates.drives,
        rates.completed,
        rates.stuck,
        _percent(rates.stuck_share),
        rates.recovered,
        _percent(rates.recovered_share),
        rates.given_up,
        _percent(rates.given_up_share),
        len(jobs) - rates.drives,
        sum(job.bumps for job in jobs),
    )


def _percent(share: float | None) -> str | None:
    return None if share is None else f"{100 * share:.2f}"


def _wrong(outcome: Outcome) -> list[Row]:
    jobs = outcome.tally.jobs
    wrong = [job for job in jobs if job.went_wrong]
    return [
        (
            outcome.options.seed, job.number, f"{job.began / 3600:.3f}", job.start, job.goal,
            job.way, job.outcome, job.x, job.y, job.seconds, job.metres, job.off, job.mean_off,
            job.worst_off, job.last_off, job.confidence, job.recoveries, job.bumps,
        )
        for job in wrong[:MOST_ROWS]
    ]  # fmt: skip


def _whys(outcome: Outcome) -> Iterator[Row]:
    for one in outcome.failures()[:MOST_ROWS]:
        facts = one.facts
        yield (
            outcome.options.seed, one.number, f"{one.began / 3600:.3f}", one.start, one.goal,
            one.outcome, facts.along, facts.across, facts.turned, one.why,
        )  # fmt: skip


def _options(outcomes: Sequence[Outcome]) -> list[Row]:
    options = outcomes[0].options.model_dump(exclude={"seed"})
    settings = outcomes[0].navigator_settings
    options["navigator_options"] = ", ".join(f"{name} {value}" for name, value in settings.items())
    return [("seed", ", ".join(str(one.options.seed) for one in outcomes)), *options.items()]


def _table(head: Sequence[str], rows: Iterable[Row], *, sums: int = 0, style: str = "") -> str:
    """A table; so many of its first rows are sums of the others. ``style`` is its class."""
    lines = ["".join(f"<td>{escape(_shown(cell))}</td>" for cell in row) for row in rows]
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = [
        f'<tr class="sum">{line}</tr>' if number < sums else f"<tr>{line}</tr>"
        for number, line in enumerate(lines)
    ]
    begin = f'<table class="{style}">' if style else "<table>"
    return "\n".join([begin, *([f"<tr>{top}</tr>"] if any(head) else []), *body, "</table>"])


def _shown(cell: object) -> str:
    return "" if cell is None else str(cell)
