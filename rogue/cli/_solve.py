"""The command that runs PRODIGY on any domain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rogue.cli._drawing import write_drawing
from rogue.cli._solve_functions import UserCodeError, named_functions
from rogue.cli._solve_report import Report
from rogue.prodigy import (
    Mode,
    ProdigyError,
    Search,
    SearchOptions,
    Solution,
    Solutions,
    Status,
    Task,
    goal_tree,
    load_task,
    validate_plan,
)
from rogue.prodigy import solve as search
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note

Bound = Annotated[int, Parameter(validator=Number(gte=1))]

Wanted = Literal["one", "all", "different", "shorter", "cheaper"]

Places = Annotated[list[str] | None, Parameter(negative="")]

SEARCH_GROUP = Group("Search", sort_key=10)
CODE_GROUP = Group("Code", sort_key=20)

BAD_INPUT = 2


@Parameter(name="*", group=SEARCH_GROUP)
@dataclass(frozen=True, kw_only=True)
class SearchFlags:
    """How it searches."""

    mode: Literal["saba", "savta"] = "saba"
    """saba back-chains before it applies, savta applies as soon as it can."""
    solutions: Wanted | None = None
    """Which plans are searched for after the first: none, all, different ones, or only ones that
    are shorter or cheaper than all before. By default one; cheaper where the problem asks for
    low cost."""
    protection: Annotated[bool, Parameter(negative="")] = False
    """Keep conditional effects from undoing what is needed, where nothing else is left."""
    depth: Bound = 200
    """Deepest node of the search tree."""
    nodes: Bound = 20_000
    """Most nodes, those of all attempts together."""
    seconds: Annotated[float, Parameter(name="--time", validator=Number(gt=0))] = 60.0
    """Longest time of the search in seconds."""

    def options(self, task: Task, *, level: int) -> SearchOptions:
        """The options of a search for a task."""
        return SearchOptions(
            mode=Mode(self.mode),
            level=level,
            protection=self.protection,
            depth_bound=self.depth,
            max_nodes=self.nodes,
            time_limit=self.seconds,
            solutions=_wanted(self.solutions, task),
            step_cost=task.costs.of,
        )


@Parameter(name="*", group=CODE_GROUP)
@dataclass(frozen=True, kw_only=True)
class CodeFlags:
    """Code of one's own that a domain calls."""

    functions: Places = None
    """Python code that the domain's types call: FILE.py:NAME or MODULE:NAME, where NAME is a
    function or a table of functions by name; without :NAME all of the file."""
    meta_predicates: Places = None
    """The same for the domain's control rules."""

    def task(self, domain: Path, problem: Path) -> Task:
        """Read a domain and a problem that call it.

        Raises:
            ProdigyError: They are wrong.
            UserCodeError: The code cannot be used.
            OSError: A file cannot be read.
        """
        return load_task(
            domain,
            problem,
            functions=named_functions(self.functions or ()),
            meta_predicates=named_functions(self.meta_predicates or ()),
        )


SEARCH = SearchFlags()
CODE = CodeFlags()


def solve(
    domain: Path,
    problem: Path,
    /,
    *,
    level: Annotated[int, Parameter(validator=Number(gte=0, lte=3))] = 2,
    check: Annotated[bool, Parameter(negative="")] = False,
    svg: Path | None = None,
    searching: SearchFlags = SEARCH,
    code: CodeFlags = CODE,
    flags: BusFlags = DEFAULT_FLAGS,
) -> int:
    """Plan with PRODIGY: a domain and a problem, in its own language or both in PDDL.

    Exit code 0 if solved, 1 if there is no plan or a limit was reached, which is said, 2 for a
    bad file. No bus is needed.

    Args:
        domain: File with the types, operators and control rules.
        problem: File with the objects, the state and the goal.
        level: What is printed: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        check: Have the plan checked by a part that knows nothing of the search.
        svg: Draw the search tree into this file: goals in ovals, operators in boxes.
        searching: How it searches.
        code: Code of one's own that the domain calls.
        flags: Shared flags; --json prints status, plan, nodes, seconds, trace and more.
    """
    try:
        task = code.task(domain, problem)
        report = _searched(task, searching.options(task, level=level), check=check, svg=svg)
    except (ProdigyError, UserCodeError) as error:
        return _refuse(str(error))
    except OSError as error:
        return _refuse(f"{error.filename} cannot be read: {error.strerror}")
    if flags.json:
        emit_json(report.document())
    else:
        for line in report.lines(level):
            emit(line)
    return 0 if report.result.status is Status.SOLVED and report.fault is None else 1


def _wanted(asked: Wanted | None, task: Task) -> Solutions:
    if asked is not None:
        return Solutions(asked)
    return Solutions.CHEAPER if task.minimize else Solutions.ONE


def _searched(task: Task, options: SearchOptions, *, check: bool, svg: Path | None) -> Report:
    found: list[Solution] = []
    draw = partial(_draw, svg, task) if svg is not None else None
    result = search(task.problem, options, on_solution=found.append, on_end=draw)
    is_checked = check and result.status is Status.SOLVED
    fault = validate_plan(task.problem, result.plan) if is_checked else None
    plans = tuple(solution.plan for solution in found)
    return Report(task, result, plans, is_checked=is_checked, fault=fault)


def _draw(svg: Path, task: Task, ended: Search) -> None:
    write_drawing(svg, goal_tree(ended), title=task.problem.name or "Search tree")


def _refuse(sentence: str) -> int:
    note(f"error: {sentence}")
    return BAD_INPUT
