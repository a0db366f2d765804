"""The live tree: a forest kept up to date by statuses, folded rows, a window, keys."""

from __future__ import annotations

import asyncio
import os
import signal
import sys

import pytest
from central_robot import Drive
from hypothesis import given, settings
from hypothesis import strategies as st
from test_tca_cli import office

from tca_bus import TaskState, TaskStatus
from tca_bus.cli._forest import Forest
from tca_bus.cli._keyboard import keys_of
from tca_bus.cli._tree_rows import MARKS, TreeView

ENDINGS = {"achieved", "failed", "killed"}


def status(id: str, parent: str | None = None, state: str = "active", sequence: int = 1):
    return TaskStatus(
        id=id,
        parent=parent,
        name="go",
        task_class="goal",
        sender="me",
        state=state,
        handling="handling",
        planning="planning",
        achievement="achieving",
        existence="alive",
        created=10.0,
        ended=12.0 if state in ENDINGS else None,
        sequence=sequence,
    )


def forest(*statuses: TaskStatus, **facts) -> Forest:
    kept = Forest(**facts)
    for one in statuses:
        kept.take(one)
    return kept


def texts(view: TreeView, height: int = 30) -> list[str]:
    return [line.text for line in view.frame(12.5, height)[1:-1] if line.text]


@st.composite
def histories(draw):
    """Statuses of a random forest, each node's in order of time, the nodes in any order."""
    count = draw(st.integers(1, 12))
    parents = [draw(st.none() | st.integers(0, n - 1)) if n else None for n in range(count)]
    says = []
    for node, parent in enumerate(parents):
        above = None if parent is None else f"n{parent}"
        states = draw(st.lists(st.sampled_from(["inactive", "pending", "active"]), max_size=3))
        states += draw(st.lists(st.sampled_from(sorted(ENDINGS)), max_size=1))
        says += [
            status(f"n{node}", above, state, number)
            for number, state in enumerate(states or ["pending"], 1)
        ]
    return draw(st.permutations(says))


@settings(deadline=None)
@given(histories(), st.data())
def test_a_forest_is_the_same_in_whatever_order_statuses_come(says, data):
    kept = forest(*says, most_ended=100)
    newest = {}
    for one in sorted(says, key=lambda one: one.sequence):
        newest[one.id] = one
    assert kept.nodes == newest
    assert kept.counts.total() == len(newest)
    walked = [id for top in kept.tops() for id in kept.subtree(top)]
    assert sorted(walked) == sorted(newest)
    for id, one in newest.items():
        if one.parent is not None:
            assert id in kept.children(one.parent)
        below = [newest[node] for node in kept.subtree(id)]
        assert kept.has_ended(id) == all(node.is_ended for node in below)
    assert not any(kept.take(data.draw(st.sampled_from(says))) for _ in range(3))


@settings(deadline=None)
@given(histories(), st.booleans())
def test_every_node_is_in_a_row_or_folded_into_one(says, is_folding):
    kept = forest(*says, most_ended=100)
    view = TreeView(kept, is_folding=is_folding)
    shown = [row.id for row in view.rows() if row.id]
    folded = [id for row in view.rows() for top in row.folded for id in kept.subtree(top)]
    assert sorted([*shown, *folded]) == sorted(kept.nodes)
    assert is_folding or not folded


def test_every_state_has_a_mark():
    assert set(MARKS) == set(TaskState)


def test_only_one_task_and_what_is_below_it_is_kept():
    kept = forest(status("a"), status("b"), status("c", "b"), status("d", "c"), only="b")
    assert list(kept.nodes) == ["b", "c", "d"]


def test_the_oldest_tasks_that_ended_are_forgotten_with_all_below():
    says = [status("a"), status("b", "a", "achieved"), status("c"), status("d", None, "failed")]
    kept = forest(*says, status("a", None, "killed", 2), most_ended=1)
    assert list(kept.nodes) == ["a", "b", "c"]
    kept.take(status("c", None, "achieved", 2))
    assert list(kept.nodes) == ["c"]
    assert kept.counts == {TaskState.ACHIEVED: 1, TaskState.ACTIVE: 0} | dict.fromkeys(
        (TaskState.FAILED, TaskState.KILLED), 0
    )


def test_what_is_not_listed_any_more_is_gone_unless_it_came_meanwhile():
    kept = forest(status("a"), status("b", "a"), status("c"), status("d", None, "failed"))
    kept.replace([status("e")], keep={"c"})
    assert sorted(kept.nodes) == ["c", "d", "e"]
    kept.replace([status("e"), status("f", "e"), status("g", "f")])
    kept.replace([status("e")])
    assert sorted(kept.nodes) == ["d", "e"]
    assert not kept.has_ended("e")
    kept.take(status("e", None, "achieved", 2))
    assert kept.has_ended("e")


def test_tasks_that_ended_are_folded_with_a_summary():
    kept = forest(
        status("a", None, "achieved"),
        status("b", "a", "achieved"),
        status("c", "b", "failed"),
        status("d"),
        status("e", "d", "achieved"),
    )
    view = TreeView(kept)
    assert texts(view) == [
        "✓ go a  achieved  2.0 s  [2 below: 1 achieved, 1 failed]",
        "● go d  active  2.5 s",
        "└─ ✓ go e  achieved  2.0 s",
    ]
    view.press("f")
    assert len(texts(view)) == 5
    view.press("f")
    assert len(texts(view)) == 3


def test_long_runs_of_siblings_are_folded_but_for_those_next_to_what_runs():
    says = [status("top"), *(status(f"e{n}", "top", "achieved") for n in range(9))]
    says += [status("run", "top"), *(status(f"w{n}", "top", "inactive") for n in range(9))]
    assert texts(TreeView(forest(*says))) == [
        "● go top  active  2.5 s",
        "├─ … 7 more: 7 achieved",
        "├─ ✓ go e7  achieved  2.0 s",
        "├─ ✓ go e8  achieved  2.0 s",
        "├─ ● go run  active  2.5 s",
        "├─ · go w0  inactive  2.5 s",
        "├─ · go w1  inactive  2.5 s",
        "└─ … 7 more: 7 inactive",
    ]


def test_a_window_moves_by_keys_and_stays_within_the_rows():
    view = TreeView(forest(*(status(f"n{n}") for n in range(10))), is_folding=False)

    def first():
        return texts(view, height=5)[0].split()[2]

    assert first() == "n0"
    for key, expected in [
        ("down", "n1"),
        ("page down", "n4"),
        ("up", "n3"),
        ("end", "n7"),
        ("down", "n7"),
        ("page up", "n4"),
        ("home", "n0"),
        ("up", "n0"),
        ("nothing", "n0"),
    ]:
        view.press(key)
        assert first() == expected, key


def test_a_window_holds_on_to_its_first_row_while_others_come_and_go():
    kept = forest(status("a"), *(status(f"n{n}") for n in range(9)))
    view = TreeView(kept, is_folding=False)
    view.frame(0.0, 5)
    for _ in range(3):
        view.press("down")
    assert texts(view, 5)[0].split()[2] == "n2"
    kept.take(status("below", "a"))
    assert texts(view, 5)[0].split()[2] == "n2"


def test_the_first_and_the_last_line_tell_of_the_rest():
    view = TreeView(forest(status("a"), status("b", None, "pending")), title="realm x")
    head, *_, foot = view.frame(12.5, 10)
    assert head.text.endswith("realm x  2 nodes: 1 pending, 1 active")
    assert foot.text.startswith("rows 1-2 of 2")
    empty = TreeView(Forest())
    assert "no task is under way" in empty.frame(0.0, 4)[0].text
    assert len(empty.frame(0.0, 1)) == 3


def test_ten_thousand_nodes_are_walked_only_when_the_shape_changes():
    kept = forest(status("top"), *(status(f"n{n}", "top", "pending") for n in range(10_000)))
    view = TreeView(kept, is_folding=False)
    rows = view.rows()
    assert len(rows) == 10_001
    kept.take(status("top", None, "handled", 2))
    assert view.rows() is rows
    kept.take(status("n5", "top", "active", 2))
    assert view.rows() is not rows
    view.is_folding = True
    assert len(view.rows()) == 8


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"\x1b[A\x1b[6~q", ["up", "page down", "quit"]),
        (b"xjG", ["down", "end"]),
        (b"\x1b", []),
        (b"", []),
    ],
)
def test_keys_are_told_apart(data, keys):
    assert list(keys_of(data)) == keys


@pytest.mark.bus
@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
async def test_the_live_tree_gives_the_terminal_back_as_it_was():
    import pty
    import termios

    async with office() as here:
        await here.me.execute(Drive(to="x"), id="d1")
        ours, its = pty.openpty()
        before = termios.tcgetattr(its)
        try:
            process = await start_on(here, its)
            shown = await read_until(ours, "drive d1")
            await here.me.execute(Drive(to="y"), id="d2")
            shown += await read_until(ours, "drive d2")
            os.kill(process.pid, signal.SIGWINCH)
            os.write(ours, b"q")
            shown += await read_until(ours, "\x1b[?1049l")
            assert await process.wait() == 0
            assert termios.tcgetattr(its) == before
            assert "realm" in shown
        finally:
            os.close(ours)
            os.close(its)


async def start_on(here, terminal):
    bus_of = {"TCA_CONNECT": here.options.connect, "TCA_REALM": here.options.realm}
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "tca_bus", "tree", "--watch"),
        stdin=terminal,
        stdout=terminal,
        stderr=asyncio.subprocess.DEVNULL,
        env={**os.environ, **bus_of, "TERM": "xterm", "COLUMNS": "100", "LINES": "20"},
    )


async def read_until(terminal, text):
    shown = ""
    async with asyncio.timeout(30.0):
        while text not in shown:
            shown += (await asyncio.to_thread(os.read, terminal, 65536)).decode(errors="replace")
    return shown


@pytest.mark.bus
@pytest.mark.process
async def test_changes_are_printed_where_there_is_no_terminal():
    async with office() as here:
        await here.me.execute(Drive(to="x"), id="d1")
        process = await here.start("tree", "--watch")
        async with asyncio.timeout(30.0):
            first = (await process.stdout.readline()).decode()
            await here.me.kill("d1", reason="no more")
            last = first
            while "⊘" not in last:
                last = (await process.stdout.readline()).decode()
        assert "drive d1  " in first
        assert last.rstrip().endswith("no more")
        process.terminate()
        assert await process.wait() == 0
