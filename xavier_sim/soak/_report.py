"""A soak as one HTML page: figures, plots, doors, and every job that did not end as it should."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from html import escape

from xavier_sim.soak._charts import Axis, Point, bars, columns, curves, points
from xavier_sim.soak._jobs import Job, Way
from xavier_sim.soak._summary import Rate, Spread, Summary
from xavier_sim.soak._tally import Tally

WINDOW = 50
"""Jobs over which the running share of success is taken."""

SLOTS = 30
"""Columns of the histogram of times."""

MOST_ROWS = 500
"""Jobs that the list of failures shows at most."""

STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 1200px; padding: 0 1em;
       color: #222; background: #fff; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 1.5em; }
table { border-collapse: collapse; margin: 1em 0; font-size: 14px; }
td, th { padding: 2px 10px; text-align: right; border-bottom: 1px solid #8884; }
td:first-child, th:first-child { text-align: left; }
@media (prefers-color-scheme: dark) { body { color: #ddd; background: #1b1b1b; } }
"""

Row = Sequence[object]


def report(summary: Summary, tally: Tally) -> str:
    """The page, with all that it shows in it."""
    jobs = tally.jobs
    title = f"{summary.hours:.4g} hours of errands, seed {summary.options.seed}"
    plots = [
        _success(jobs),
        bars("Jobs that were not completed, by reason", summary.reasons),
        _position_error(tally),
        _times(jobs),
        _speeds(jobs),
    ]
    body = [
        f"<h1>{escape(title)}</h1>",
        _table(("", ""), _figures(summary)),
        '<div class="plots">',
        *(f"<figure>{plot}</figure>" for plot in plots),
        "</div>",
        "<h2>Rooms and their doors</h2>",
        _table(
            ("goal", "jobs", "completed", "stuck", "recovered", "given up", "door shut", "bumps"),
            _doors(jobs),
        ),
        "<h2>What did not end as it should</h2>",
        _table(
            ("job", "hour", "from", "to", "way", "ended", "s", "m", "off, m", "worst error, m",
             "sure", "recoveries", "bumps"),
            _wrong(jobs),
        ),
        "<h2>Options</h2>",
        _table(("option", "value"), list(summary.options.model_dump().items())),
    ]  # fmt: skip
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return "\n".join(
        [f"<!doctype html><html lang=en><head>{head}</head><body>", *body, "</body></html>\n"]
    )


def _figures(summary: Summary) -> list[Row]:
    return [
        ("kilometres", f"{summary.km:.3f}"),
        ("jobs", summary.jobs),
        ("completed", summary.completed),
        ("goals with an open way: completed", _rate(summary.reachable)),
        ("goals behind closed doors: given up for that", _rate(summary.unreachable)),
        ("goals whose way changed: either", _rate(summary.changing)),
        ("false arrivals", summary.false_arrivals),
        ("bumps", summary.bumps),
        ("people run into above 0.1 m/s", summary.people_hit),
        ("recoveries per km", summary.recoveries_per_km),
        ("rescues by people", summary.rescues),
        ("median speed of a job, m/s", summary.median_speed),
        ("speed while driving, m/s", _spread(summary.driving_speed)),
        ("distance between belief and truth, m", _spread(summary.position_error)),
        ("off the place at arrival, m", _spread(summary.arrival_error)),
        ("time of a job, s", _spread(summary.job_seconds)),
        ("real-time factor", summary.real_time_factor),
        ("the same by processor time", summary.cpu_time_factor),
        ("memory after an hour and at the end, MB", "{:.0f}, {:.0f}".format(*summary.memory_mb)),
    ]  # fmt: skip


def _success(jobs: Sequence[Job]) -> str:
    met = [job for job in jobs if job.way is Way.OPEN]
    all_so_far, lately, done = list[Point](), list[Point](), list[bool]()
    for job in met:
        done.append(job.arrived)
        hour = (job.began + job.seconds) / 3600.0
        all_so_far.append((hour, 100.0 * sum(done) / len(done)))
        last = done[-WINDOW:]
        lately.append((hour, 100.0 * sum(last) / len(last)))
    x = Axis.over("hours", (hour for hour, _ in all_so_far))
    lowest = min((share for _, share in [*all_so_far, *lately]), default=90.0)
    y = Axis("% completed", min(90.0, 10.0 * (lowest // 10.0)), 100.0)
    lines = {"all so far": all_so_far, f"last {WINDOW}": lately}
    return curves("Success where there was a way", x, y, lines)


def _position_error(tally: Tally) -> str:
    shares = [(error, 100.0 * share) for error, share in tally.errors.shares()]
    x = Axis.over("metres", [tally.errors.quantile(0.999) or 0.1])
    y = Axis("% of the time below", 0.0, 100.0)
    return curves("Distance between belief and truth", x, y, {"": shares})


def _times(jobs: Sequence[Job]) -> str:
    seconds = [job.seconds for job in jobs if job.arrived]
    x = Axis.over("seconds", seconds or [1.0])
    width = (x.high - x.low) / SLOTS
    counts = [0] * SLOTS
    for value in seconds:
        counts[min(SLOTS - 1, int(value / width))] += 1
    slots = [(width * slot, width * (slot + 1), float(count)) for slot, count in enumerate(counts)]
    return columns("Time of a completed job", x, Axis.over("jobs", [*counts, 1]), slots)


def _speeds(jobs: Sequence[Job]) -> str:
    groups = {
        "arrived": [(job.metres, job.seconds) for job in jobs if job.arrived],
        "not": [(job.metres, job.seconds) for job in jobs if not job.arrived],
    }
    x = Axis.over("metres driven", [job.metres for job in jobs] or [1.0])
    y = Axis.over("seconds", [job.seconds for job in jobs] or [1.0])
    return points("Way and time of each job", x, y, groups)


def _doors(jobs: Iterable[Job]) -> list[Row]:
    """By goal: *stuck* met trouble, *recovered* and arrived all the same, *given up* with a way."""
    by_goal = defaultdict[str, list[Job]](list)
    for job in jobs:
        by_goal[job.goal].append(job)
    return [_door(goal, by_goal[goal]) for goal in sorted(by_goal)]


def _door(goal: str, jobs: list[Job]) -> Row:
    tried = [job for job in jobs if job.way is Way.OPEN]
    stuck = [job for job in tried if job.recoveries]
    return (
        goal,
        len(tried),
        sum(job.arrived for job in tried),
        len(stuck),
        sum(job.arrived for job in stuck),
        sum(job.reason is not None for job in tried),
        len(jobs) - len(tried),
        sum(job.bumps for job in jobs),
    )


def _wrong(jobs: Iterable[Job]) -> list[Row]:
    wrong = [job for job in jobs if not job.arrived and not job.refused_rightly]
    return [
        (
            job.number, f"{job.began / 3600:.3f}", job.start, job.goal, job.way, job.outcome,
            job.seconds, job.metres, job.off, job.worst_off, job.confidence, job.recoveries,
            job.bumps,
        )
        for job in wrong[:MOST_ROWS]
    ]  # fmt: skip


def _table(head: Sequence[str], rows: Iterable[Row]) -> str:
    lines = ["".join(f"<td>{escape(_shown(cell))}</td>" for cell in row) for row in rows]
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head) if any(head) else ""
    return "\n".join(
        ["<table>", *(f"<tr>{line}</tr>" for line in [top, *lines] if line), "</table>"]
    )


def _shown(cell: object) -> str:
    return "" if cell is None else str(cell)


def _rate(rate: Rate) -> str:
    share = f" ({100 * rate.share:.2f} %)" if rate.share is not None else ""
    return f"{rate.right} of {rate.jobs}{share}"


def _spread(spread: Spread) -> str:
    if spread.median is None:
        return ""
    return (
        f"median {spread.median:g}, 90 % below {spread.p90:g}, 99 % below {spread.p99:g}, "
        f"most {spread.most:g}"
    )
