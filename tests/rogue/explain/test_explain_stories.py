"""What a user is told: whole stories from whole searches, and each kind of decision."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from rogue.errands import Agenda, Claim, Errand, Switches, example1998, figure9, working
from rogue.explain import (
    RULES,
    Chronicle,
    Concern,
    Decision,
    DecisionKind,
    Entry,
    Record,
    Rival,
    because,
    in_words,
    sentence,
    story,
    told,
)
from rogue.messages import Closing, DeliveryRequest, Filled, RequestState, StepView
from rogue.outcomes import Arrival
from rogue.prodigy import Decided, Execute, Failed, RuleSet, Search

MAIL = Errand("mitchell", "delivermail", "r-5303", "r-5313")
FAX = Errand("jhm", "deliverfax", "r-5311", "r-5313")


def metres(one: str, other: str) -> float:
    return abs(int(one[2:]) - int(other[2:])) * 1.8


def new_search(office: Switches) -> Search:
    """One errand of mitchell; the robot is in the first of eight rooms."""
    problem = office.problem(
        [MAIL],
        rooms=[f"r-53{number:02d}" for number in range(1, 16, 2)],
        people=["jhm", "mitchell"],
        items=["deliverfax", "delivermail"],
        at="r-5301",
    )
    return Search(problem, office.options, office.rules)


def concern(name: str, errand: Errand, rank: int, posted: float) -> Concern:
    return Concern(name, errand.user, errand.item, rank, posted)


@dataclass
class Run:
    """A search whose second request arrives during the first step."""

    office: Switches
    late: Concern
    decisions: list[Decision] = field(default_factory=list)

    def play(self) -> Run:
        search = new_search(self.office)
        chronicle = Chronicle()
        chronicle.admit(concern("a", MAIL, 5, 1.0))
        for now, event in enumerate(search.events()):
            if isinstance(event, Decided | Failed):
                self.decisions += chronicle.note(event, float(now))
            elif isinstance(event, Execute):
                if not search.executed_operators():
                    search.add_goal(self.office.facts(FAX), self.office.goal(FAX))
                    chronicle.admit(self.late)
                search.executed()
        return self

    def of(self, name: str, kind: DecisionKind) -> list[Decision]:
        return [d for d in self.decisions if name in d.requests and d.kind is kind]


def urgent_arrives() -> Run:
    return Run(figure9(metres), concern("b", FAX, 8, 2.0)).play()


def request(name: str = "a", **fields: object) -> DeliveryRequest:
    values: dict[str, object] = {
        "id": name,
        "user": "mitchell",
        "item": "delivermail",
        "pickup": "r-5303",
        "deliver": "r-5313",
        "state": RequestState.QUEUED,
        "rank": 5,
        "posted": 0.0,
        "deadline": 3600.0,
    }
    return DeliveryRequest.model_validate({**values, **fields})


def last(record: Record) -> Entry:
    return story(record)[-1]


def test_an_urgent_errand_overtakes_once_and_says_by_which_rule() -> None:
    run = urgent_arrives()
    [overtaken] = run.of("a", DecisionKind.OVERTAKEN)
    assert (overtaken.rule, overtaken.rivals) == ("nearest-room", (Rival("b", 8),))
    assert sentence(overtaken) == (
        "It was overtaken by request b (rank 8), which came later: driving to r-5311 to fetch "
        "something for jhm came first, since its room is the nearest."
    )
    assert not run.of("b", DecisionKind.OVERTAKEN)


def test_the_working_rules_put_off_what_is_less_urgent() -> None:
    agenda = Agenda.plain(metres)
    agenda.put(Claim(user="jhm", item="deliverfax", person_rank=20))
    run = Run(working(agenda), concern("b", FAX, 20, 2.0)).play()
    rules = {d.rule for kind in (DecisionKind.OVERTAKEN, DecisionKind.WAITS)
             for d in run.of("a", kind)}  # fmt: skip
    assert rules & {"put-off-for-top-priority", "order-of-tour"}
    assert [d.requests for d in run.decisions if d.kind is DecisionKind.STEP][-1] == ("a",)


def test_an_errand_of_lower_rank_that_goes_first_does_not_overtake() -> None:
    run = Run(figure9(metres), concern("b", FAX, 3, 2.0)).play()
    assert not run.of("a", DecisionKind.OVERTAKEN)
    assert run.of("a", DecisionKind.WAITS)


def test_errands_to_one_room_share_the_drive() -> None:
    run = urgent_arrives()
    [of_a], [of_b] = run.of("a", DecisionKind.MERGED), run.of("b", DecisionKind.MERGED)
    assert sentence(of_b) == "It shares the drive to r-5313 with request a (rank 5)."
    assert of_a.rivals == (Rival("b", 8),)
    [drive] = [d for d in run.of("a", DecisionKind.STEP) if "goto-deliver" in d.chosen]
    assert drive.requests == ("a", "b")


def test_each_step_names_what_it_was_chosen_over() -> None:
    steps = urgent_arrives().of("a", DecisionKind.STEP)
    assert sentence(steps[0]) == (
        "Next came driving to r-5303 to fetch something for mitchell, rather than driving to "
        "r-5313 to deliver to mitchell, since its room is the nearest."
    )
    assert [d.chosen.split()[0] for d in steps] == [
        "<goto-pickup-loc",
        "<acquire-item",
        "<goto-deliver-loc",
        "<deliver-item",
    ]


def test_every_decision_has_its_requests_and_its_time() -> None:
    decisions = urgent_arrives().decisions
    assert all(d.requests and set(d.requests) <= {"a", "b"} for d in decisions)
    assert [d.time for d in decisions] == sorted(d.time for d in decisions)
    assert {DecisionKind.OPERATOR, DecisionKind.BINDINGS, DecisionKind.DEAD_END} <= {
        d.kind for d in decisions if d.is_routine
    }


def test_a_request_that_was_withdrawn_is_told_of_no_more() -> None:
    chronicle = Chronicle()
    chronicle.admit(concern("a", MAIL, 5, 1.0))
    chronicle.withdraw("a")
    search = new_search(example1998(metres))
    event = next(e for e in search.events() if isinstance(e, Decided))
    assert chronicle.note(event, 1.0) == []


def test_a_request_that_nothing_was_planned_for_waits_too() -> None:
    chronicle = Chronicle()
    chronicle.admit(concern("a", MAIL, 5, 1.0))
    chronicle.admit(concern("z", FAX, 1, 1.0))
    search = new_search(figure9(metres))
    decisions: list[Decision] = []
    for event in search.events():
        if isinstance(event, Execute):
            break
        if isinstance(event, Decided | Failed):
            decisions += chronicle.note(event, 1.0)
    [waits] = [d for d in decisions if d.requests == ("z",)]
    assert (waits.kind, waits.rivals) == (DecisionKind.WAITS, (Rival("a", 5),))


def test_that_a_request_waits_on_is_no_news() -> None:
    chronicle = Chronicle()
    chronicle.admit(concern("a", MAIL, 5, 1.0))
    chronicle.admit(concern("z", Errand("xue", "tea", "r-5315", "r-5301"), 1, 1.0))
    search = new_search(figure9(metres))
    decisions: list[Decision] = []
    for event in search.events():
        if isinstance(event, Execute):
            search.executed()
        elif isinstance(event, Decided | Failed):
            decisions += chronicle.note(event, 1.0)
    assert sum(d.kind is DecisionKind.STEP for d in decisions) == 4
    assert [d.kind for d in decisions if "z" in d.requests] == [DecisionKind.WAITS]


def test_routine_choices_are_told_only_on_request() -> None:
    decisions = [d for d in urgent_arrives().decisions if "a" in d.requests]
    short = story(Record(request=request(), decisions=decisions))
    long = story(Record(request=request(), decisions=decisions), everything=True)
    assert {"goal", "operator", "bindings"} & {entry.kind for entry in short} == set()
    assert len(long) == len(decisions) + 2
    assert len(short) < len(long)


def test_a_door_that_was_closed() -> None:
    step = StepView(
        operator="goto-pickup-loc mitchell r-5303",
        state="failed",
        started=60.0,
        ended=400.0,
        outcome="cannot get to r-5303, door_blocked: the door is closed",
    )
    held = Record(request=request(), steps=[step], hold=(1000.0, step.outcome or ""))
    kinds = [entry.kind for entry in story(held)]
    assert kinds == ["posted", "begun", "failed", "now"]
    assert story(held)[2].sentence == (
        "Driving to r-5303 to fetch something for mitchell did not succeed: cannot get to r-5303, "
        "the door is closed."
    )
    assert "It waits until" in last(held).sentence
    assert last(held).sentence.endswith("cannot get to r-5303, the door is closed.")


def test_nobody_answered() -> None:
    step = StepView(
        operator="acquire-item r-5303 mitchell delivermail",
        state="failed",
        started=60.0,
        ended=240.0,
        outcome="nobody answered within 60 s",
    )
    reason = "acquire-item at r-5303, nobody answered"
    ended = request(state=RequestState.FAILED, finished=240.0, reason=reason)
    entries = story(Record(request=ended, steps=[step], notes=[(240.0, reason)]))
    assert entries[-2].sentence.startswith("Having delivermail for mitchell put on the tray")
    assert entries[-1].sentence == f"It failed: {reason}."
    assert [e.kind for e in entries].count("noted") == 0


def test_a_request_that_was_canceled_while_its_item_was_on_the_tray() -> None:
    closing = Closing(state=RequestState.CANCELED, reason="no need", since=9.0)
    open_still = request(state=RequestState.UNDERWAY, closing=closing, then="back")
    assert last(Record(request=open_still)).sentence == (
        "It will be canceled (no need) when its item is in r-5303."
    )
    done = request(state=RequestState.CANCELED, finished=9.0, reason="no need")
    assert last(Record(request=done)) == Entry(9.0, "ended", "It is canceled: no need.")


def test_a_deadline_that_cannot_be_met_is_said() -> None:
    warning = "it cannot be delivered before Oct 1 14:00"
    sentence_now = last(Record(request=request(warning=warning))).sentence
    assert sentence_now.endswith("It cannot be delivered before Oct 1 14:00.")


def test_who_waits_is_told_behind_whom() -> None:
    ahead = request("b", state=RequestState.UNDERWAY, rank=8)
    waiting = Record(request=request(state=RequestState.SUSPENDED), others=[ahead, request("c")])
    assert last(waiting).sentence == (
        "It was begun and put aside while the robot serves b (rank 8)."
    )
    alone = Record(request=request(), others=[request()])
    assert last(alone).sentence == "It waits; nothing is being done before it."


def test_what_was_left_out_and_what_was_forgotten_is_said() -> None:
    slot = Filled(slot="pickup", value="r-5303", source="directory")
    lines = told(story(Record(request=request(), filled=[slot], forgotten=3)))
    assert any("The pickup was left out; it is r-5303, from the people" in one for one in lines)
    assert "(3 older choices were not kept.)" in lines


@pytest.mark.parametrize("kind", list(DecisionKind))
def test_every_kind_of_decision_makes_a_sentence(kind: DecisionKind) -> None:
    one = Decision(time=1.0, kind=kind, requests=("a",), chosen="<x>", reason="why", until=5.0)
    said = sentence(one)
    assert said.endswith(".")
    assert said[0].isupper()
    assert "  " not in said
    assert ".." not in said


def test_every_rule_of_the_office_has_words() -> None:
    offices = [figure9(metres), example1998(metres), working(Agenda.plain(metres))]
    own = [rule for office in offices for rule in (office.domain.rules or RuleSet()).rules]
    added = [rule for office in offices for rule in office.rules.rules]
    names = {rule.name.lower() for rule in (*own, *added)}
    assert len(names) > 8
    assert names <= RULES.keys()


def test_a_rule_of_somebodys_own_is_named() -> None:
    assert because("LUNCH-FIRST") == "as the rule LUNCH-FIRST says"
    assert because("") == ""


def test_what_is_not_of_the_office_stays_as_it_is() -> None:
    assert in_words("<stack a b>") == "<stack a b>"
    assert in_words("(on a b)") == "(on a b)"
    assert in_words("<goto-pickup-loc mitchell>") == "<goto-pickup-loc mitchell>"


def test_a_drive_tells_what_made_sure_of_each_arrival() -> None:
    arrivals = (
        Arrival(room="r-5305", by="camera", sure=0.99),
        Arrival(),
        Arrival(room="r-5303", by="belief", sure=0.985),
    )
    step = StepView(
        operator="goto-pickup-loc mitchell r-5303",
        state="done",
        started=60.0,
        ended=400.0,
        outcome=None,
        arrivals=arrivals,
    )
    assert story(Record(request=request(), steps=[step]))[2].sentence == (
        "Driving to r-5303 to fetch something for mitchell was done; the door plate made sure of "
        "r-5305, then nothing made sure where it was, then the navigator's belief made sure of "
        "r-5303."
    )
