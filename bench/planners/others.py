"""The others: OR-Tools in the process, pyperplan and Fast Downward as processes of their own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ortools.constraint_solver import pywrapcp, routing_enums_pb2
from planners.office import HANDLING, SPEED, Instance, Job
from planners.ours import Planned

PATIENCE = 60.0
"""Seconds that a process may take for one batch."""

STOP = re.compile(r"\((acquire|deliver) (\w+) r\d+\)", re.IGNORECASE)

# The robot goes from door to door, which these planners plan sooner than from any room to any.
DOMAIN = """
(define (domain office)
  (:requirements :strips :typing)
  (:types room job)
  (:predicates (at ?r - room) (waits ?j - job ?r - room) (held ?j - job)
               (goes ?j - job ?r - room) (done ?j - job) (next ?from ?to - room))
  (:action goto :parameters (?from ?to - room)
    :precondition (and (at ?from) (next ?from ?to))
    :effect (and (not (at ?from)) (at ?to)))
  (:action acquire :parameters (?j - job ?r - room)
    :precondition (and (at ?r) (waits ?j ?r)) :effect (and (held ?j) (not (waits ?j ?r))))
  (:action deliver :parameters (?j - job ?r - room)
    :precondition (and (at ?r) (held ?j) (goes ?j ?r)) :effect (and (done ?j) (not (held ?j)))))
"""


@dataclass(frozen=True)
class Open:
    """A job that is not done: fetched already or not."""

    job: Job
    is_carried: bool = False


def route(
    instance: Instance,
    jobs: Sequence[Open],
    at: int,
    *,
    seconds: float | None = None,
    weighted: bool = False,
) -> list[tuple[Job, bool]]:
    """Order the stops with OR-Tools: the shortest way, or with ``weighted`` the least waiting.

    The weighted cost is the seconds of the way, and for each errand its weight times the seconds
    until it is delivered. ``seconds`` are given to guided local search; without them the first
    solution is taken.
    """
    stops = [(one.job, False) for one in jobs if not one.is_carried]
    stops += [(one.job, True) for one in jobs]
    places = [job.deliver if is_delivery else job.pickup for job, is_delivery in stops]
    manager = pywrapcp.RoutingIndexManager(len(stops) + 2, 1, [len(stops)], [len(stops) + 1])
    model = pywrapcp.RoutingModel(manager)

    def duration(one: int, other: int) -> int:
        here, there = manager.IndexToNode(one), manager.IndexToNode(other)
        if there == len(stops) + 1 or there == len(stops):
            return 0
        start = at if here >= len(stops) else places[here]
        return round(instance.metres(start, places[there]) / SPEED + HANDLING)

    transit = model.RegisterTransitCallback(duration)
    model.SetArcCostEvaluatorOfAllVehicles(transit)
    model.AddDimension(transit, 0, 10**7, True, "time")
    clock = model.GetDimensionOrDie("time")
    _tie(model, manager, clock, stops)
    if weighted:
        for node, (job, is_delivery) in enumerate(stops):
            if is_delivery:
                index = manager.NodeToIndex(node)
                clock.SetCumulVarSoftUpperBound(index, 0, round(job.weight))
    solution = model.SolveWithParameters(_parameters(seconds))
    found, index = [], model.Start(0)
    while not model.IsEnd(index := solution.Value(model.NextVar(index))):
        found.append(stops[manager.IndexToNode(index)])
    return found


def _tie(
    model: pywrapcp.RoutingModel,
    manager: pywrapcp.RoutingIndexManager,
    clock: pywrapcp.RoutingDimension,
    stops: list[tuple[Job, bool]],
) -> None:
    solver = model.solver()
    index = {stop: manager.NodeToIndex(node) for node, stop in enumerate(stops)}
    for (job, is_delivery), to in index.items():
        if is_delivery and (job, False) in index:
            fro = index[job, False]
            model.AddPickupAndDelivery(fro, to)
            solver.Add(clock.CumulVar(fro) <= clock.CumulVar(to))


def _parameters(seconds: float | None) -> object:
    parameters = pywrapcp.DefaultRoutingSearchParameters()
    parameters.first_solution_strategy = (
        routing_enums_pb2.FirstSolutionStrategy.PARALLEL_CHEAPEST_INSERTION
    )
    if seconds is None:
        parameters.solution_limit = 1
    else:
        parameters.local_search_metaheuristic = (
            routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
        )
        parameters.time_limit.FromMilliseconds(round(1000 * seconds))
    return parameters


def ortools_first(instance: Instance) -> Planned:
    """OR-Tools' first solution."""
    began = time.process_time()
    order = route(instance, [Open(job) for job in instance.jobs], instance.start)
    spent = time.process_time() - began
    return Planned(spent, spent, instance.length(order))


def ortools_searching(instance: Instance) -> Planned:
    """OR-Tools with 0.2 s of guided local search, all of which it uses."""
    began = time.process_time()
    order = route(instance, [Open(job) for job in instance.jobs], instance.start, seconds=0.2)
    spent = time.process_time() - began
    return Planned(spent, spent, instance.length(order))


def pyperplan(instance: Instance) -> Planned | None:
    """Pyperplan, greedy best first with hFF; None if it gives no plan in time."""
    program = Path(sys.executable).with_name("pyperplan")
    flags = ["-s", "gbf", "-H", "hff", "domain.pddl", "problem.pddl"]
    return _in_process([str(program), *flags], "problem.pddl.soln", instance)


def fast_downward(instance: Instance) -> Planned | None:
    """Fast Downward, first iteration of LAMA; None if it gives no plan in time."""
    program = downward() or ""
    flags = ["--alias", "lama-first", "domain.pddl", "problem.pddl"]
    return _in_process([program, *flags], "sas_plan", instance)


def downward() -> str | None:
    """Fast Downward's driver, if it is installed."""
    return shutil.which("fast-downward.py") or shutil.which("fast-downward")


def _in_process(command: list[str], result: str, instance: Instance) -> Planned | None:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "domain.pddl").write_text(DOMAIN)
        Path(folder, "problem.pddl").write_text(_problem(instance))
        began = _spent_by_children()
        try:
            subprocess.run(command, cwd=folder, capture_output=True, timeout=PATIENCE, check=False)
        except subprocess.TimeoutExpired:
            return None
        spent = _spent_by_children() - began
        solution = Path(folder, result)
        if not solution.is_file():
            return None
        found = STOP.findall(solution.read_text())
    jobs = {job.name: job for job in instance.jobs}
    order = [(jobs[name.lower()], kind.lower() == "deliver") for kind, name in found]
    return Planned(spent, spent, instance.length(order))


def _spent_by_children() -> float:
    spent = os.times()
    return spent.children_user + spent.children_system


def _problem(instance: Instance) -> str:
    rooms = " ".join(f"r{number}" for number in range(instance.rooms))
    jobs = " ".join(job.name for job in instance.jobs)
    facts = [f"(at r{instance.start})"]
    facts += [f"(waits {job.name} r{job.pickup})" for job in instance.jobs]
    facts += [f"(goes {job.name} r{job.deliver})" for job in instance.jobs]
    pairs = ((room, (room + 1) % instance.rooms) for room in range(instance.rooms))
    facts += [f"(next r{one} r{other}) (next r{other} r{one})" for one, other in pairs]
    goals = " ".join(f"(done {job.name})" for job in instance.jobs)
    return (
        f"(define (problem batch) (:domain office) (:objects {rooms} - room {jobs} - job) "
        f"(:init {' '.join(facts)}) (:goal (and {goals})))"
    )
