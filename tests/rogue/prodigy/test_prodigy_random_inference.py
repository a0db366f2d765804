"""Random domains with inference, negation, OR, quantifiers, conditional and universal effects."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_random_domains import Texts, reachable, texts

from rogue.prodigy import Mode, SearchOptions, Status, solve, validate_plan


@settings(max_examples=35, deadline=None)
@given(texts, st.sampled_from(Mode), st.booleans())
def test_plans_are_valid_and_unsolvable_is_true(case: Texts, mode: Mode, switch: bool) -> None:
    problem = case.problem()
    options = SearchOptions(
        mode=mode,
        max_nodes=400,
        level=0,
        excise_loops=switch,
        use_abs_level=switch,
        min_conspiracy_number=not switch,
    )
    result = solve(problem, options)
    if result.status is Status.SOLVED:
        assert validate_plan(problem, result.plan) is None
        assert reachable(problem)
    elif result.status is Status.UNSOLVABLE:
        assert not reachable(problem)
    else:
        assert result.status is Status.LIMIT
        assert result.limit is not None
        assert reachable(problem), "so small a problem is solved or proved unsolvable"
