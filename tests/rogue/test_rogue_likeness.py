"""Two stores that should tell of the same."""

from __future__ import annotations

import pytest

from rogue.errors import StoreError
from rogue.memory import FILE_NAME, Store, first_difference

LINES = [(1.0, "first"), (2.0, "this"), (2.0, "that"), (3.0, "last")]


async def kept(folder, lines, steps=()):
    """A store with a conversation and some steps in it; gives its file."""
    async with Store(folder) as store:
        for time, text in lines:
            await store.add_line(text, time)
        for time, room in steps:
            await store.begin_step("GOTO", [room], [], time)
    return folder / FILE_NAME


async def test_stores_that_tell_the_same_do_not_differ(tmp_path):
    one = await kept(tmp_path / "one", LINES, [(1.5, "r-1")])
    first, this, that, last = LINES
    other = await kept(tmp_path / "other", [first, that, this, last], [(1.5, "r-1")])
    assert await first_difference(one, other) is None


@pytest.mark.parametrize(
    ("lines", "time", "mine", "its"),
    [
        ([*LINES[:3], (3.1, "last")], 3.0, (3.0, "last"), (3.1, "last")),
        (LINES[:3], 3.0, (3.0, "last"), None),
        ([*LINES, (4.0, "more")], 4.0, None, (4.0, "more")),
        ([(1.0, "other"), *LINES[1:3]], 1.0, (1.0, "first"), (1.0, "other")),
    ],
)
async def test_the_first_line_that_differs_is_named(tmp_path, lines, time, mine, its):
    one, other = await kept(tmp_path / "one", LINES), await kept(tmp_path / "other", lines)
    found = await first_difference(one, other)
    assert (found.table, found.time) == ("trace", time)
    assert (found.one and found.one[:2], found.other and found.other[:2]) == (mine, its)


async def test_the_earliest_difference_of_all_comes_first(tmp_path):
    one = await kept(tmp_path / "one", LINES, [(1.5, "r-1")])
    other = await kept(tmp_path / "other", LINES[:3], [(1.6, "r-1")])
    found = await first_difference(one, other)
    assert (found.table, found.time) == ("steps", 1.5)


async def test_a_store_that_is_missing_or_is_none_is_a_clear_error(tmp_path):
    one = await kept(tmp_path / "one", LINES)
    with pytest.raises(StoreError, match="is not there"):
        await first_difference(one, tmp_path / "none.db")
    wrong = tmp_path / "wrong.db"
    wrong.write_bytes(b"no database" * 500)
    with pytest.raises(StoreError, match=r"wrong\.db"):
        await first_difference(one, wrong)
