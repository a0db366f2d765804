"""Bad and large input: a clear error, or a search that says at which limit it stopped."""

from __future__ import annotations

import sys

import pytest
from prodigy_office_runs import FIGURE6, PUBLISHED

from rogue.errands import Errand
from rogue.prodigy import (
    Choice,
    Execute,
    FunctionError,
    LimitKind,
    Literal,
    Mode,
    Poll,
    PreferRule,
    Problem,
    RuleSet,
    Search,
    SearchOptions,
    Status,
    TooManyValuesError,
    generator,
    parse_domain,
    solve,
    validate_plan,
)


def things(count: int) -> dict[str, list[str]]:
    return {"thing": [f"t{i}" for i in range(count)]}


def chain(length: int) -> Problem:
    text = """(ptype-of thing :top-type)
    (OPERATOR go (params <b>) (preconds ((<a> thing) (<b> thing)) (and (at <a>) (next <a> <b>)))
      (effects () ((del (at <a>)) (add (at <b>)))))"""
    links = [Literal("next", (f"t{i}", f"t{i + 1}")) for i in range(length)]
    return Problem.build(
        parse_domain(text),
        objects=things(length + 1),
        facts=[Literal("at", ("t0",)), *links],
        goals=[Literal("at", (f"t{length}",))],
    )


def frames() -> int:
    frame, count = sys._getframe(), 0
    while frame.f_back is not None:
        frame, count = frame.f_back, count + 1
    return count


@pytest.mark.parametrize("mode", list(Mode))
def test_recursion_does_not_depend_on_the_length_of_the_plan(mode: Mode) -> None:
    problem = chain(300)
    options = SearchOptions(mode=mode, depth_bound=None, max_nodes=None, proof_states=0)
    before = sys.getrecursionlimit()
    try:
        sys.setrecursionlimit(frames() + 100)
        search = Search(problem, options)
        list(search.events())
    finally:
        sys.setrecursionlimit(before)
    assert search.result is not None
    assert len(search.result.plan) == 300
    assert validate_plan(chain(20), solve(chain(20)).plan) is None


def test_a_domain_that_never_ends_is_given_up_at_a_limit_that_is_named() -> None:
    @generator
    def below(n: int | None, m: int | None) -> list[int]:
        return [] if n is None or m is not None else [n - 1]

    text = """(infinite-type level #'integerp)
    (OPERATOR climb (params <m>)
      (preconds ((<n> (and level (below <m> <n>))) (<m> level)) (reached <n>))
      (effects () ((add (reached <m>)))))"""
    problem = Problem.build(
        parse_domain(text, functions={"below": below}),
        objects={},
        facts=[Literal("reached", (0,))],
        goals=[Literal("reached", (-1,))],
    )
    for bound, kind in ((60, LimitKind.DEPTH), (None, LimitKind.NODES)):
        options = SearchOptions(depth_bound=bound, max_nodes=3000, proof_states=100)
        result = Search(problem, options)
        list(result.events())
        assert result.result is not None
        assert result.result.status is Status.LIMIT
        assert result.result.limit is not None
        assert result.result.limit.kind is kind


FIFTY = " ".join(f"(<v{i}> thing)" for i in range(50))
SHUN = " ".join(f"(~ (chosen <v{i}>))" for i in range(50))


@pytest.mark.parametrize("objects", [3, 10_000])
def test_fifty_variables_and_ten_thousand_objects_end_at_the_bound_of_bindings(
    objects: int,
) -> None:
    text = f"""(ptype-of thing :top-type)
    (OPERATOR choose (params <v0>) (preconds ({FIFTY}) (and {SHUN}))
      (effects () ((add (chosen <v0>)))))"""
    problem = Problem.build(
        parse_domain(text), objects=things(objects), goals=[Literal("chosen", ("t0",))]
    )
    search = Search(problem, SearchOptions(max_bindings=20_000, proof_states=0))
    list(search.events())
    assert search.result is not None
    assert search.result.limit is None or search.result.status is Status.LIMIT
    failed = [line for line in search.trace if line.endswith("more than 20000 bindings to try")]
    assert len(failed) == 1


def test_a_rule_over_too_many_objects_is_refused_by_name_of_the_limit() -> None:
    text = """(ptype-of thing :top-type)
    (OPERATOR go (params) (preconds () (and)) (effects () ((add (gone)))))
    (INFERENCE-RULE all (mode eager) (params)
      (preconds ((<a> thing) (<b> thing)) (~ (gone))) (effects () ((add (pair <a> <b>)))))"""
    problem = Problem.build(parse_domain(text), objects=things(200), goals=[Literal("gone")])
    with pytest.raises(TooManyValuesError, match="more than 5000 values"):
        Search(problem, SearchOptions(max_bindings=5000))


def test_time_runs_out_in_the_midst_of_a_step() -> None:
    text = """(ptype-of thing :top-type)
    (OPERATOR go (params <a>) (preconds ((<a> thing) (<b> thing) (<c> thing)) (ready <a> <b> <c>))
      (effects () ((add (gone)))))
    (OPERATOR prepare (params <a> <b> <c>) (preconds ((<a> thing) (<b> thing) (<c> thing)) (and))
      (effects () ((add (ready <a> <b> <c>)))))"""
    problem = Problem.build(parse_domain(text), objects=things(60), goals=[Literal("gone")])
    ticks = iter(range(10**9))
    options = SearchOptions(time_limit=30.0, clock=lambda: float(next(ticks)), proof_states=0)
    search = Search(problem, options)
    list(search.events())
    assert search.result is not None
    assert search.result.limit is not None
    assert (search.result.limit.kind, search.result.limit.value) == (LimitKind.SECONDS, 30.0)


def test_a_cycle_of_preferences_is_reported_and_ends() -> None:
    text = "".join(
        f"(OPERATOR op{i} (params) (preconds () (and)) (effects () ((add (done-it)))))\n"
        for i in range(3)
    )
    problem = Problem.build(parse_domain(text), objects={}, goals=[Literal("done-it")])
    always = PreferRule("next", Choice.OPERATOR, lambda _v, one, other: one is not other)
    search = Search(problem, None, RuleSet((always,)))
    list(search.events())
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    fired = [f.action for d in search.decisions for f in d.rules]
    assert "prefer cycle" in fired


def test_a_function_that_raises_or_never_ends_is_named() -> None:
    def broken(_value: object) -> bool:
        raise ZeroDivisionError

    text = """(ptype-of thing :top-type)
    (OPERATOR go (params <a>) (preconds ((<a> (and thing (fits <a>)))) (and))
      (effects () ((add (gone)))))"""
    domain = parse_domain(text, functions={"fits": broken})
    problem = Problem.build(domain, objects=things(2), goals=[Literal("gone")])
    with pytest.raises(FunctionError, match="fits t0"):
        solve(problem)


def test_a_search_that_needs_more_memory_than_allowed_gives_up() -> None:
    search = Search(chain(100), SearchOptions(max_held=150, depth_bound=None))
    list(search.events())
    assert search.result is not None
    assert search.result.limit is not None
    assert (search.result.limit.kind, search.result.limit.value) == (LimitKind.HELD, 150)


def test_a_search_that_runs_for_days_does_not_grow() -> None:
    options = PUBLISHED.options
    held = 300
    search = Search(
        Problem.build(FIGURE6.domain, objects={
            "room": [f"r-{i}" for i in range(8)], "person": ["ann", "ben"], "item": ["tea"],
        }, facts=[Literal("robot-in-room", ("r-0",))]),
        SearchOptions(execute=True, depth_bound=None, max_nodes=None, time_limit=None,
                      poll=options.poll, max_held=held, proof_states=0),
        PUBLISHED.rules,
    )  # fmt: skip
    done, current = 0, None
    sizes: list[int] = []
    for event in search.events():
        if isinstance(event, Execute):
            search.executed()
        elif isinstance(event, Poll):
            if current is not None and search.state.holds(PUBLISHED.goal(current)):
                done += 1
                facts = [*PUBLISHED.facts(current)[1:], PUBLISHED.goal(current)]
                search.remove_goal(PUBLISHED.goal(current), facts)
                current = None
                sizes.append(len(search.nodes()) + len(search.trace) + len(search.decisions))
            if current is None and done < 60:
                user = ("ann", "ben")[done % 2]
                current = Errand(user, "tea", f"r-{done % 7 + 1}", f"r-{(done + 3) % 7 + 1}")
                search.add_goal(PUBLISHED.facts(current), PUBLISHED.goal(current))
    assert done == 60
    assert max(sizes) <= 5 * held
    assert search.nodes()[-1].number > 2 * held
