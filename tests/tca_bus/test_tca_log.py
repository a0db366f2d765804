"""The task history in the grammar of TCA's own log: every line parses, every event is told."""

from __future__ import annotations

from typing import get_args

import lark
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tca_log_grammar import parse

from tca_bus import ConfigError, Failure
from tca_bus._attachments import Catch, CleanUp, Resolution, Tap
from tca_bus._history import TELLERS, NodeFacts, tell_event
from tca_bus._journal import Journal
from tca_bus._log_grammar import LETTERS, Letters, grammar_name, lines_of
from tca_bus._log_statements import (
    ConstraintAdded,
    MessagePassed,
    NodeRef,
    PointsOrdered,
    Statement,
    TimePoint,
)
from tca_bus._orders import Order, Point
from tca_bus._protocol import Constraint, LogEntry, Outcome, ReadLog, SubmitTask
from tca_bus.cli._history import entry_lines, summary_lines
from tca_bus.tasktree import (
    Abandoned,
    Alarmed,
    Attached,
    CaughtFailure,
    Constrained,
    Deregistered,
    Detached,
    Dispatched,
    Ended,
    Freed,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    LimitExceeded,
    Prepared,
    Prioritized,
    ProviderAppeared,
    ProviderLost,
    Record,
    RecordedEvent,
    Registered,
    Released,
    Reported,
    Resumed,
    Retried,
    Submitted,
    Suspended,
    Taken,
    Tree,
    Triggered,
    UncaughtFailure,
)

SHAPES = get_args(get_args(Statement)[0])
NAMES = st.text(max_size=12) | st.sampled_from(["and", "on", "Resource", "17", "-1", "a-->b", ""])
REFS = st.builds(NodeRef, name=NAMES, number=st.none() | st.integers(0, 10**9))
POINTS = st.builds(TimePoint, node=REFS)
PLACES = NAMES | st.just("ON HOLD") | NAMES.map("Resource {}".format)
STATEMENTS = st.one_of(
    *(
        st.builds(
            shape,
            **{
                field: strategy
                for field, strategy in {
                    "node": REFS,
                    "first": POINTS,
                    "second": POINTS,
                    "source": PLACES,
                    "destination": PLACES,
                    "module": NAMES,
                    "number": st.none() | st.integers(0, 10**9),
                    "parent": st.none() | st.integers(-1, 10**9),
                    "text": st.text(min_size=1).filter(str.split),
                }.items()
                if field in shape.model_fields
            },
        )
        for shape in SHAPES
        if shape is not ConstraintAdded
    ),
    st.builds(
        ConstraintAdded,
        constraint=st.sampled_from(["SEQUENTIAL ACHIEVEMENT", "SEQUENTIAL PLANNING"]),
        node=REFS,
        previous=REFS,
    ),
    st.builds(
        ConstraintAdded,
        constraint=st.sampled_from(["DELAY PLANNING", "PLAN FIRST"]),
        node=REFS,
        previous=st.none(),
    ),
)


@settings(deadline=None, max_examples=60)
@given(STATEMENTS, st.sets(st.sampled_from(sorted(LETTERS))), st.floats(0, 4e9))
def test_every_line_is_in_the_grammar(statement, letters, time):
    for line in lines_of(statement, time, Letters(frozenset(letters))):
        assert parse(line) is not None


@settings(deadline=None, max_examples=60)
@given(STATEMENTS)
def test_every_statement_has_a_line(statement):
    assert len(list(lines_of(statement, 0.0, Letters.parse("mstrp")))) == 1


@pytest.mark.parametrize(
    "line",
    ["Goal go {1}: me --> robot", "Goal go: me -> robot (Sent)", "Success go:", "Killed {3}"],
)
def test_the_grammar_of_the_tests_refuses_other_lines(line):
    with pytest.raises(lark.LarkError):
        parse(line)


def order(first, then, **facts):
    ends = {"first": {"task": "b", "point": first}} if first else {}
    return Order.model_validate({**ends, "then": {"task": "a", "point": then}, **facts})


LISTENER = {"name": "look", "task_class": "command"}
TAP = Tap(id="t", condition="BeforeHandling", listener=LISTENER)
CATCH = Catch(id="c", handler="ask", exception="door_blocked")
CLEAN_UP = CleanUp(id="u", sending=LISTENER)
TASK = SubmitTask(
    id="a",
    name="go",
    task_class="goal",
    data={},
    sender="rogue",
    orders=(order(Point.END_HANDLING, Point.START_PLANNING, delay=2.0),),
)

EVENTS = [
    Submitted(1.0, TASK, previous="b"),
    Prepared(1.0, "a", "go", "goal", "rogue"),
    Constrained(1.0, order(Point.END_ACHIEVING, Point.START_HANDLING)),
    Constrained(1.0, order(None, Point.START_HANDLING, at=1e9)),
    Released(1.0, "a", "b", Point.END_ACHIEVING),
    Dispatched(1.0, "a", 1, "robot", "r1"),
    Dispatched(1.0, "a", 2, "robot", "r1"),
    Taken(1.0, "a", 1),
    Reported(1.0, "a", 1, Outcome.SUCCESS, resolution=Resolution(action="bypass")),
    Reported(1.0, "a", 1, Outcome.SUCCESS, resolution=Resolution(action="retry", task="b")),
    Reported(1.0, "a", 1, Outcome.KILLED),
    Reported(1.0, "a", 1, Outcome.FAILURE, failure=Failure(name="lost", text="it is lost")),
    Abandoned(1.0, "a", 1),
    Alarmed(1.0, "a", "deadline"),
    Suspended(1.0, "a"),
    Resumed(1.0, "a"),
    Prioritized(1.0, "a", 3),
    Retried(1.0, "a"),
    Triggered(1.0, "a", 1, 2),
    CaughtFailure(1.0, "a", CATCH, "b", 1),
    UncaughtFailure(1.0, "a"),
    Attached(1.0, "a", TAP),
    Attached(1.0, "a", CATCH),
    Attached(1.0, "a", CLEAN_UP),
    Detached(1.0, "a", "t"),
    Registered(1.0, "go", TAP),
    Deregistered(1.0, "t"),
    KillRequested(1.0, "a", "enough"),
    KillRequested(1.0, "a", "enough", only_below=True),
    HandlerLost(1.0, "a", 1, "robot"),
    HandlerMissing(1.0, "a"),
    LimitExceeded(1.0, "a", "robot/arm", 2),
]


def test_every_kind_of_recorded_event_is_told():
    kinds = set(get_args(RecordedEvent))
    assert set(TELLERS) == kinds
    assert {type(event) for event in EVENTS} == kinds


@pytest.mark.parametrize("monitor", [None, "point", "polling", "demon"])
@pytest.mark.parametrize("event", EVENTS, ids=lambda event: type(event).__name__)
def test_every_event_has_a_word_and_lines_in_the_grammar(event, monitor):
    nodes = {"a": NodeRef(name="go", number=1), "b": NodeRef(name="tca.look", number=2)}
    facts = NodeFacts(node=nodes["a"], monitor=monitor, parent="b", nodes=nodes)
    told = tell_event(event, facts)
    assert told.event
    lines = [
        line for said in told.statements for line in lines_of(said, 1.0, Letters.parse("mstrp"))
    ]
    assert lines
    for line in lines:
        parse(line)


def test_constraints_between_points_are_told_as_tca_does():
    nodes = {"a": NodeRef(name="go", number=1), "b": NodeRef(name="look", number=2)}
    facts = NodeFacts(node=nodes["a"], nodes=nodes)
    delayed = order(Point.END_ACHIEVING, Point.START_HANDLING, delay=5.0)
    told = tell_event(Constrained(1.0, delayed), facts)
    lines = [line for said in told.statements for line in lines_of(said, 1.0, Letters.parse("msr"))]
    assert lines == [
        "   Asserting End(Achievement(look)) {2} <= Start(Handling(go)) {1}",
        f"    {delayed}",
    ]


@settings(deadline=None, max_examples=60)
@given(NAMES)
def test_names_keep_what_the_grammar_allows(name):
    parse(f"Killed {grammar_name(name)}")
    assert grammar_name("navigateToG") == "navigateToG"


def test_letters_choose_what_is_shown():
    said = MessagePassed(
        word="Goal",
        node=NodeRef(name="go", number=7),
        source="rogue",
        destination="Resource go",
        parent=3,
        status="Pending",
    )

    def line(letters):
        return list(lines_of(said, 0.0, Letters.parse(letters)))

    assert line("m") == ["Goal      go: rogue --> Resource go  (Pending)"]
    assert line("mrp") == ["Goal      go {7}: rogue {3} --> Resource go  (Pending)"]
    assert line("s") == []
    (timed,) = line("mt")
    assert [part.data for part in parse(timed).iter_subtrees()].count("time") == 1
    with pytest.raises(ConfigError, match=r"--letters is 'mq'.*m \(messages"):
        Letters.parse("mq")


def test_a_constraint_between_points_is_written():
    end = {"end": "End", "interval": "Achievement", "node": {"name": "a", "number": 1}}
    start = {"end": "Start", "interval": "Planning", "node": {"name": "b", "number": 2}}
    said = PointsOrdered.model_validate({"first": end, "relation": "<=", "second": start})
    (line,) = lines_of(said, 0.0, Letters.parse("mrt"))
    assert line == "   Asserting End(Achievement(a)) {1} <= Start(Planning(b)) {2}"
    parse(line)


class Teller:
    """A tree whose history is written down and told."""

    def __init__(self, journal):
        self.journal = journal
        self.tree = Tree()
        self.tree.apply(ProviderAppeared(0.0, "robot", "r1", {"go": 9, "say": 9}))

    async def happen(self, *events):
        effects = [effect for event in events for effect in self.tree.apply(event)]
        await self.journal.write(
            [effect for effect in effects if isinstance(effect, Record)],
            [effect for effect in effects if isinstance(effect, Freed)],
            [effect for effect in effects if isinstance(effect, Ended)],
        )

    async def submit(self, id, name, task_class, time, **facts):
        task = SubmitTask(
            id=id, name=name, task_class=task_class, data={"n": id}, sender="rogue", **facts
        )
        await self.happen(Submitted(time, task))

    async def lines(self, letters="msrdp", **question):
        entries = await self.journal.read_log(ReadLog(**question))
        return [line for entry in entries for line in entry_lines(entry, Letters.parse(letters))]


async def test_a_history_reads_as_tca_would_write_it():
    async with Journal(None) as journal:
        told = Teller(journal)
        await told.submit("top", "go", "goal", 1.0, constraints=0)
        await told.happen(Taken(1.5, "top", 1))
        await told.submit("a", "say", "command", 2.0, parent="top")
        flags = int(Constraint.SEQ_ACH | Constraint.DELAY_PLANNING)
        await told.submit("b", "go", "goal", 3.0, parent="top", constraints=flags)
        await told.happen(Reported(4.0, "a", 1, Outcome.SUCCESS, result=None))
        failure = Failure(name="door_blocked", text="the door is closed", module="robot")
        await told.happen(Reported(5.0, "b", 1, Outcome.FAILURE, failure=failure))
        await told.happen(KillRequested(6.0, "top", "enough"))
        await told.happen(ProviderLost(7.0, "r1"))
        lines = await told.lines()
        everything = await told.lines("mstrdp")
    assert [line for line in lines if not line.startswith("    ")] == [
        "Goal      go {1}: rogue --> Resource go  (Pending)",
        "Goal      go {1}: Resource go --> robot  (Sent)",
        "Command   say {4}: rogue {1} --> Resource say  (Pending)",
        "Command   say {4}: Resource say --> robot  (Sent)",
        "Goal      go {6}: rogue {1} --> Resource go  (Inactive)",
        "Adding SEQUENTIAL ACHIEVEMENT constraint between say {4} and go {6}",
        "Adding DELAY PLANNING constraint to go {6}",
        "  Success  say {4}:",
        "Goal      go {6}: ON HOLD --> robot  (Sent)",
        "Command   say {4}:  (Completed)",
        "  Failure  go {6}: robot {1}",
        "Killed go {6}",
        "Will kill go {1} when it completes",
        "Killed go {1}",
    ]
    assert '    a {"n": "a"}' in lines
    for line in everything:
        parse(line)


async def test_messages_and_tasks_are_chosen_and_ignored():
    async with Journal(None) as journal:
        told = Teller(journal)
        await told.submit("top", "go", "goal", 1.0)
        await told.submit("a", "say", "command", 2.0, parent="top")
        await told.submit("other", "say", "command", 3.0)
        one = await told.lines("mr", task="a", messages=("say",))
        rest = await told.lines("mr", ignore=("say",))
    assert all("say {3}" in line for line in one)
    assert one
    assert all("go {1}" in line for line in rest)
    assert rest


def entry(number, task, event, time):
    return LogEntry(number=number, time=time, task=task, name="say", event=event, text="")


def test_the_time_spent_in_handlers_is_summed_up():
    entries = [
        entry(1, "a", "started", 1.0),
        entry(2, "b", "started", 1.0),
        entry(3, "a", "handled", 2.0),
        entry(4, "b", "handler failed", 5.0),
        entry(5, "c", "started", 6.0),
    ]
    assert list(summary_lines(entries)) == ["    say: handled 2 times, mean 2.50 s, longest 4.00 s"]
    for line in summary_lines(entries):
        parse(line)
