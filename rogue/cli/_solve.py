"""The command that runs PRODIGY on any domain."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
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

BAD_INPUT = 2


def solve(
    domain: Path,
    problem: Path,
    /,
    *,
    mode: Literal["saba", "savta"] = "saba",
    level: Annotated[int, Parameter(validator=Number(gte=0, lte=3))] = 2,
    solutions: Wanted | None = None,
    protection: Annotated[bool, Parameter(negative="")] = False,
    depth: Bound = 200,
    nodes: Bound = 20_000,
    seconds: Annotated[float, Parameter(name="--time", validator=Number(gt=0))] = 60.0,
    functions: Places = None,
    meta_predicates: Places = None,
    check: Annotated[bool, Parameter(negative="")] = False,
    svg: Path | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> int:
    """Plan with PRODIGY: a domain and a problem, in its own language or both in PDDL.

    Exit code 0 if solved, 1 if there is no plan or a limit was reached, which is said, 2 for a
    bad file. No bus is needed.

    Args:
        domain: File with the types, operators and control rules.
        problem: File with the objects, the state and the goal.
        mode: saba back-chains before it applies, savta applies as soon as it can.
        level: What is printed: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        solutions: Which plans are searched for after the first: none, all, different ones, or only
            ones that are shorter or cheaper than all before. By default one; cheaper where the
            problem asks for low cost.
        protection: Keep conditional effects from undoing what is needed, where nothing else is
            left.
        depth: Deepest node of the search tree.
        nodes: Most nodes, those of all attempts together.
        seconds: Longest time of the search in seconds.
        functions: Python code that the domain's types call: FILE.py:NAME or MODULE:NAME, where
            NAME is a function or a table of functions by name; without :NAME all of the file.
        meta_predicates: The same for the domain's control rules.
        check: Have the plan checked by a part that knows nothing of the search.
        svg: Draw the search tree into this file: goals in ovals, operators in boxes.
        flags: Shared flags; --json prints status, plan, nodes, seconds, trace and more.
    """
    options = SearchOptions(
        mode=Mode(mode),
        level=level,
        protection=protection,
        depth_bound=depth,
        max_nodes=nodes,
        time_limit=seconds,
    )
    try:
        task = load_task(
            domain,
            problem,
            functions=named_functions(functions or ()),
            meta_predicates=named_functions(meta_predicates or ()),
        )
        options = replace(options, solutions=_wanted(solutions, task), step_cost=task.costs.of)
        report = _searched(task, options, check=check, svg=svg)
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
