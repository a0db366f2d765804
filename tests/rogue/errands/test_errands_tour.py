"""Tours against every order that there is."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rogue.errands import (
    EXACT_UP_TO,
    OpenErrand,
    RunningTour,
    Tour,
    Travel,
    TravelError,
    best_tour,
    promise,
)

MISSED = 1e6


def ring(one: str, other: str) -> float:
    apart = (int(one[2:]) - int(other[2:])) % 24
    return 3.0 * min(apart, 24 - apart)


def some_errands(chance: random.Random, count: int, *, due: float = inf) -> list[OpenErrand]:
    return [
        OpenErrand(
            key=f"e{i}",
            pickup=f"r-{chance.randrange(24)}",
            deliver=f"r-{chance.randrange(24)}",
            rank=chance.randrange(4),
            deadline=chance.uniform(0.0, due) if due < inf else inf,
            carried=chance.random() < 0.2,
        )
        for i in range(count)
    ]


def orders(errands: Sequence[OpenErrand], capacity: int | None) -> Iterator[list[tuple[int, bool]]]:
    """Every order of stops in which items are fetched before they are brought, tray permitting."""
    stops = [(i, False) for i, e in enumerate(errands) if not e.carried]
    stops += [(i, True) for i in range(len(errands))]
    for order in itertools.permutations(stops):
        load = sum(e.carried for e in errands)
        held = {i for i, e in enumerate(errands) if e.carried}
        for i, is_delivery in order:
            if is_delivery:
                if i not in held:
                    break
                load -= 1
            else:
                held.add(i)
                load += 1
                if capacity is not None and load > capacity:
                    break
        else:
            yield list(order)


def measured(
    errands: Sequence[OpenErrand], order: list[tuple[int, bool]], travel: Travel, start: str
) -> tuple[float, float, dict[int, float]]:
    """Cost, metres and completions of an order, from the definition."""
    here, time, metres, completions = start, 0.0, 0.0, dict[int, float]()
    for i, is_delivery in order:
        room = errands[i].deliver if is_delivery else errands[i].pickup
        metres += travel.distance(here, room)
        time += travel.distance(here, room) / travel.speed + travel.handling
        here = room
        if is_delivery:
            completions[i] = time
    lowest = min(e.rank for e in errands)
    cost = time
    for i, e in enumerate(errands):
        weight = travel.haste / len(errands) + travel.urgency * (e.rank - lowest)
        cost += weight * completions[i]
        cost += MISSED * (1.0 + weight) if completions[i] > e.deadline else 0.0
    return cost, metres, completions


problems = st.tuples(
    st.integers(0, 10_000),
    st.integers(1, 3),
    st.sampled_from([inf, 150.0, 300.0]),
    st.sampled_from([None, 1, 2]),
)


@settings(max_examples=60, deadline=None)
@given(problems)
def test_no_order_costs_less_than_the_best_tour(problem: tuple[int, int, float, int | None]):
    seed, count, due, capacity = problem
    errands = some_errands(random.Random(seed), count, due=due)
    travel = Travel(distance=ring, capacity=capacity)
    tour = best_tour(errands, start="r-0", travel=travel)
    costs = [measured(errands, order, travel, "r-0") for order in orders(errands, capacity)]
    assert tour.cost == pytest.approx(min(cost for cost, _, _ in costs))
    assert tour.is_exact


@settings(max_examples=60, deadline=None)
@given(problems)
def test_a_promise_is_the_earliest_completion_of_any_order(
    problem: tuple[int, int, float, int | None],
):
    seed, count, due, capacity = problem
    errands = some_errands(random.Random(seed), min(count, 2), due=due)
    new = OpenErrand(key="new", pickup="r-7", deliver="r-19", deadline=200.0)
    travel = Travel(distance=ring, capacity=capacity)
    late = set(best_tour(errands, start="r-0", travel=travel).late)
    everything = [*errands, new]
    in_time = [
        done[len(errands)]
        for order in orders(everything, capacity)
        for _, _, done in [measured(everything, order, travel, "r-0")]
        if all(done[i] <= e.deadline or e.key in late for i, e in enumerate(errands))
    ]
    answer = promise(new, errands, start="r-0", travel=travel)
    assert answer.earliest == pytest.approx(min(in_time))
    assert answer.alone <= answer.earliest + 1e-9
    assert answer.can_be_kept == (answer.earliest <= 200.0)


@pytest.mark.parametrize("capacity", [None, 3])
@pytest.mark.parametrize("seed", range(4))
def test_a_tour_that_grows_serves_everybody_in_a_possible_order(seed: int, capacity: int | None):
    chance = random.Random(seed)
    travel = Travel(distance=ring, capacity=capacity)
    running, errands = RunningTour(travel), list[OpenErrand]()
    for number in range(3 * EXACT_UP_TO):
        one = some_errands(chance, 1)[0]
        errands.append(
            OpenErrand(key=f"n{number}", pickup=one.pickup, deliver=one.deliver, rank=one.rank)
        )
        tour = running.update(errands, start="r-0")
        assert served(tour, errands, capacity) == {errand.key for errand in errands}
        if number % 5 == 4:
            errands.pop(chance.randrange(len(errands)))


@pytest.mark.parametrize("seed", range(6))
def test_a_long_tour_from_a_full_tray_is_possible(seed: int):
    chance = random.Random(seed)
    travel = Travel(distance=ring, capacity=3)
    errands = [
        replace(e, carried=number < 3, deadline=chance.choice([inf, 900.0]))
        for number, e in enumerate(some_errands(chance, 2 * EXACT_UP_TO))
    ]
    tour = best_tour(errands, start="r-0", travel=travel)
    assert served(tour, errands, 3) == {errand.key for errand in errands}


def served(tour: Tour, errands: Sequence[OpenErrand], capacity: int | None) -> set[str]:
    """Whose item is delivered, if each stop of the tour is possible when its turn comes."""
    held = {e.key for e in errands if e.carried}
    delivered = set[str]()
    for stop in tour.stops:
        if stop.is_delivery:
            held.remove(stop.key)
            delivered.add(stop.key)
        else:
            held.add(stop.key)
        assert capacity is None or len(held) <= max(capacity, sum(e.carried for e in errands))
    assert not held
    return delivered


@pytest.mark.parametrize("seed", range(5))
def test_insertion_costs_little_more_than_the_best(seed: int, monkeypatch: pytest.MonkeyPatch):
    errands = some_errands(random.Random(seed), EXACT_UP_TO)
    travel = Travel(distance=ring)
    exact = best_tour(errands, start="r-0", travel=travel)
    monkeypatch.setattr("rogue.errands._touring.EXACT_UP_TO", 0)
    near = best_tour(errands, start="r-0", travel=travel)
    assert not near.is_exact
    assert exact.cost <= near.cost + 1e-9
    assert near.cost <= 1.15 * exact.cost


@pytest.mark.parametrize("seed", range(5))
def test_a_promise_given_from_a_long_tour_can_be_kept(seed: int, monkeypatch: pytest.MonkeyPatch):
    travel = Travel(distance=ring, capacity=2)
    tight = some_errands(random.Random(seed), 5, due=600.0)
    errands = [replace(errand, deadline=errand.deadline + 600.0) for errand in tight]
    new = OpenErrand(key="new", pickup="r-7", deliver="r-19")
    exact = promise(new, errands, start="r-0", travel=travel)
    monkeypatch.setattr("rogue.errands._touring.EXACT_UP_TO", 0)
    near = promise(new, errands, start="r-0", travel=travel)
    late = best_tour(errands, start="r-0", travel=travel).late
    monkeypatch.undo()
    assert near.alone == pytest.approx(exact.alone)
    promised = [*errands, replace(new, deadline=near.earliest + 1e-6)]
    assert len(best_tour(promised, start="r-0", travel=travel).late) <= len(late)


def test_who_is_more_important_is_served_first_though_it_is_farther():
    near = OpenErrand(key="near", pickup="r-2", deliver="r-3")
    far = OpenErrand(key="far", pickup="r-20", deliver="r-19", rank=9.0)
    travel = Travel(distance=ring)
    assert best_tour([near, far], start="r-0", travel=travel).stops[0].key == "far"
    equal = [near, OpenErrand(key="far", pickup="r-20", deliver="r-19")]
    assert best_tour(equal, start="r-0", travel=travel).stops[0].key == "near"


def test_a_deadline_overtakes_a_shorter_way():
    near = OpenErrand(key="near", pickup="r-2", deliver="r-3")
    due = OpenErrand(key="due", pickup="r-20", deliver="r-19", deadline=110.0)
    travel = Travel(distance=ring)
    tour = best_tour([near, due], start="r-0", travel=travel)
    assert tour.stops[0].key == "due"
    assert not tour.late


def test_without_a_known_room_the_way_to_the_first_stop_counts_nothing():
    one = OpenErrand(key="a", pickup="r-9", deliver="r-10")
    tour = best_tour([one], start=None, travel=Travel(distance=ring))
    assert tour.metres == pytest.approx(3.0)


def test_no_errands_no_tour():
    tour = best_tour([], start="r-0", travel=Travel(distance=ring))
    assert tour.stops == ()
    assert tour.completion("a") == inf


@pytest.mark.parametrize(("name", "value"), [("speed", 0.0), ("capacity", 0), ("haste", -1.0)])
def test_senseless_figures_are_refused(name: str, value: float):
    with pytest.raises(TravelError, match=f"{name} is {value}; expected"):
        Travel(distance=ring, **{name: value})
