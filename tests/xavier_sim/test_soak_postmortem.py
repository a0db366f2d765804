"""Why drives failed: facts that are true, and a sentence for each kind of failure."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_soak import FLOOR, job_of, soak_of

from xavier_sim.body import Disc
from xavier_sim.floors import load_floor
from xavier_sim.soak import (
    Company,
    Course,
    Goal,
    PostMortem,
    RoomDoor,
    SoakOptions,
    Stray,
    Tally,
    Watch,
    Way,
    explain,
)
from xavier_sim.soak._examiner import Examiner, crossed
from xavier_sim.soak._reaching import Reach

RADIUS = 0.3
OPEN = {"d-1": True, "d-2": True, "d-3": True}
R_2 = Goal("r-2", 5.4, 3.1, "r-2")


def facts_of(**facts):
    plain = {
        "x": 3.0, "y": 1.2, "heading": 90.0, "space": "hall",
        "believed_x": 3.0, "believed_y": 1.2, "believed_heading": 90.0, "believed_space": "hall",
        "along": 0.0, "across": 0.0, "turned": 0.0, "astray": 0.0,
        "stray": None, "strayed_in": None, "doors": (), "blamed": None,
        "company": (), "in_company": 0.0, "lost": False,
    }  # fmt: skip
    return PostMortem(**{**plain, **facts})


def door_of(room="r-2", *, is_open=True, last_minute=Way.OPEN):
    return RoomDoor(name=f"d-{room}", room=room, is_open=is_open, last_minute=last_minute)


def company_of(gap, bearing, kind="person"):
    return Company(kind=kind, gap=gap, bearing=bearing)


WEST = {
    "believed_x": 3.51,
    "along": -0.51,
    "turned": -2.2,
    "astray": 38.0,
    "stray": "drifted",
    "strayed_in": "hall",
}
KNEW = "knew where it stood to 0.00 m"


@pytest.mark.parametrize(
    ("job", "facts", "sentence"),
    [
        (
            {"reason": "door_blocked"},
            {**WEST, "blamed": "r-2", "doors": (door_of(),)},
            ("took the open door of r-2 for shut: stood 0.51 m west of where it believed, heading "
            "off by 2 degrees, for 38 s, from hall on"),
        ),
        (
            {"reason": "door_blocked"},
            {"blamed": "r-1", "doors": (door_of(), door_of("r-1", last_minute=Way.CHANGING))},
            f"took the door of r-1 for shut, which had moved in the last minute: {KNEW}",
        ),
        (
            {"reason": "door_blocked"},
            {"doors": (door_of(is_open=False, last_minute=Way.SHUT),)},
            f"found the door of r-2 shut, though there was another way: {KNEW}",
        ),
        (
            {"reason": "door_blocked"},
            {"doors": (door_of(),), "company": (company_of(0.7, -11.8),), "in_company": 77.0},
            (f"was kept out of the open door of r-2: {KNEW}; had a person 0.7 m before it for "
            "77 s"),
        ),
        (
            {"reason": "door_blocked"},
            {"doors": (door_of(),), "company": (company_of(0.7, -11.8),), "in_company": 3.0},
            f"took the open door of r-2 for shut: {KNEW}; had a person 0.7 m before it for 3 s",
        ),
        ({"reason": "door_blocked"}, {}, f"took the door of r-2 for shut: {KNEW}"),
        (
            {"reason": "corridor_blocked"},
            {"company": (company_of(0.6, -20.0),), "in_company": 40.0},
            f"took its way to r-2 for blocked: {KNEW}; had a person 0.6 m before it for 40 s",
        ),
        (
            {"reason": "no_progress"},
            {"company": (
                company_of(0.2, 170.0), company_of(0.5, 170.0), company_of(1.0, 90.0, "cart"),
            )},
            (f"came no nearer to r-2: {KNEW}; had a cart and 2 people within 1.5 m, the nearest "
            "0.2 m behind it"),
        ),
        (
            {"reason": "lost"},
            {"lost": True, "believed_y": 3.2, "believed_space": "r-2", "across": -2.0},
            ("was lost on its way to r-2: stood 2.00 m south of where it believed, in hall and not "
            "r-2"),
        ),
        (
            {"reason": "no_route"},
            {"doors": (door_of(is_open=False, last_minute=Way.CHANGING), door_of("r-1"))},
            f"knew of no way to r-2: {KNEW}; the door of r-2 was shut within the last minute",
        ),
        (
            {"reason": "endless", "seconds": 1200.0},
            {"turned": 31.0},
            ("did not get to r-2 within 1200 s: knew where it stood to 0.00 m, but not where it "
            "looked, by 31 degrees"),
        ),
        (
            {"off": 0.7},
            {"across": 0.1},
            "said that it was at r-2, and was 0.70 m from its place: knew where it stood to 0.10 m",
        ),
        (
            {"reason": "bump"},
            {"company": (company_of(-0.01, 100.0, "cart"),), "in_company": 3.0},
            (f"could not back out of a contact on its way to r-2: {KNEW}; had a cart 0.0 m to its "
            "left for 3 s"),
        ),
        ({"reason": "tired"}, {}, f"gave r-2 up as tired: {KNEW}"),
    ],
)  # fmt: skip
def test_each_kind_of_failure_has_its_sentence(job, facts, sentence):
    assert explain(job_of(**job), facts_of(**facts)) == sentence


class Bench:
    """A drive from the hall to r-2 that is watched tick by tick."""

    def __init__(self, start="hall"):
        plan = load_floor(FLOOR)
        self.start = start
        self.tally = Tally()
        self.watch = Watch(
            Reach(plan), Examiner(plan, RADIUS), R_2, self.seen(0.0, 0.0, 0), OPEN, number=0
        )

    def seen(self, x, y, tick, theta=0.0):
        return SimpleNamespace(
            x=x, y=y, theta=theta, space=self.start, metres=0.0, bumps=0, people_touched=0,
            people_hit=0, tick=tick,
        )  # fmt: skip

    def look(self, at, believed, around=()):
        self.watch.look(at, believed, 0.0, self.tally, around)

    def end(self, at, believed, *, tick=1000, theta=0.0, around=(), reason="lost", door=None):
        report = SimpleNamespace(recoveries=0, position=SimpleNamespace(confidence=0.5), door=door)
        return self.watch.judge(reason, report, self.seen(*at, tick, theta), believed, around)


def test_an_error_is_split_along_the_space_and_across():
    job = Bench().end((2.0, 1.0), (1.6, 1.1, math.pi - 0.1), theta=-math.pi + 0.1)
    facts = job.post_mortem
    assert (facts.along, facts.across) == (pytest.approx(0.4), pytest.approx(-0.1))
    assert facts.turned == pytest.approx(math.degrees(0.2), abs=0.1)
    assert (facts.space, facts.believed_space, facts.lost) == ("hall", "hall", True)
    in_room = Bench().end((1.0, 4.0), (1.4, 4.1, 0.0)).post_mortem
    assert (in_room.space, in_room.along, in_room.across) == ("r-1", -0.4, -0.1)


def test_it_is_told_for_how_long_belief_was_off():
    bench = Bench()
    for error in (0.3, 0.2, 0.26, 0.4):
        bench.look((2.0, 1.0), (2.0 + error, 1.0))
    assert bench.end((2.0, 1.0), (2.5, 1.0, 0.0)).post_mortem.astray == 2.0
    found = bench.end((2.0, 1.0), (2.1, 1.0, 0.0)).post_mortem
    assert (found.astray, found.stray, found.strayed_in) == (0.0, None, None)


@pytest.mark.parametrize(
    ("looks", "stray", "words"),
    [
        ([((2.0, 1.0), (2.3, 1.0))], Stray.BEFORE, "since before it set out"),
        ([((1.8, 1.0), (1.9, 1.0)), ((2.0, 1.0), (2.3, 1.0))], Stray.DRIFTED, "from hall on"),
        (
            [((6.0, 4.0), (6.0, 4.0)), ((2.0, 4.0), (6.0, 4.0))],
            Stray.CARRIED,
            "since it was put down in r-1",
        ),
        (
            [((2.0, 1.0), (2.0, 1.0)), ((2.0, 1.0), (6.0, 1.0))],
            Stray.JUMPED,
            "since its belief jumped, in hall",
        ),
    ],
)
def test_it_is_told_how_belief_and_truth_parted(looks, stray, words):
    bench = Bench()
    for at, believed in [*looks, ((2.1, 1.0), (4.0, 1.0))]:
        bench.look(at, believed)
    job = bench.end((2.1, 1.0), (4.0, 1.0, 0.0))
    assert job.post_mortem.stray is stray
    assert explain(job, job.post_mortem).endswith(f"for 2 s, {words}")


def test_it_is_told_who_was_near_and_for_how_long():
    bench, here = Bench(), (2.0, 1.0)
    near, far = Disc(2.0, 1.9, 0.25, person=True), Disc(6.5, 1.0, 0.3)
    for around in ([near], [far], [near, far], [near]):
        bench.look(here, here, around)
    facts = bench.end(here, (*here, 0.0), around=[far, near]).post_mortem
    assert facts.company == (Company(kind="person", gap=0.35, bearing=90.0),)
    assert facts.in_company == 2.0


@pytest.mark.parametrize(("shut", "count"), [(False, 1), (True, 0)])
def test_who_is_behind_a_shut_door_is_not_near(shut, count):
    bench = Bench()
    bench.watch.doors_moved("hall", {**OPEN, "d-1": not shut}, 10)
    inside = Disc(1.8, 3.0, 0.25, person=True)
    facts = bench.end((1.8, 1.8), (1.8, 1.8, 0.0), around=[inside]).post_mortem
    assert len(facts.company) == count


def test_who_is_behind_a_wall_is_not_near():
    inside = Disc(0.5, 3.0, 0.25, person=True)
    facts = Bench().end((0.5, 1.8), (0.5, 1.8, 0.0), around=[inside]).post_mortem
    assert facts.company == ()


def test_it_is_told_how_the_doors_at_both_ends_stood():
    bench = Bench(start="r-1")
    bench.watch.doors_moved("r-1", {**OPEN, "d-2": False}, 200)
    bench.watch.doors_moved("r-1", {**OPEN, "d-1": False}, 500)
    facts = bench.end((2.0, 1.0), (2.0, 1.0, 0.0), tick=1000).post_mortem
    assert [(one.name, one.is_open, one.last_minute) for one in facts.doors] == [
        ("d-1", False, Way.CHANGING),
        ("d-2", True, Way.CHANGING),
    ]
    later = bench.end((2.0, 1.0), (2.0, 1.0, 0.0), tick=1101).post_mortem
    assert [one.last_minute for one in later.doors] == [Way.SHUT, Way.OPEN]


def test_the_door_that_a_navigator_blames_is_told_of():
    ends = {"at": (2.0, 1.0), "believed": (2.0, 1.0, 0.0), "door": "r-3"}
    blamed = Bench().end(**ends, reason="door_blocked").post_mortem
    assert (blamed.blamed, [door.room for door in blamed.doors]) == ("r-3", ["r-2", "r-3"])
    assert Bench().end(**ends, reason="lost").post_mortem.blamed is None


def test_a_job_that_ended_well_has_no_post_mortem():
    assert Bench().end((5.4, 3.1), (5.4, 3.1, 0.0), reason=None).post_mortem is None
    false = Bench().end((1.8, 3.1), (5.4, 3.1, 0.0), reason=None)
    assert false.post_mortem.believed_space == "r-2"


def test_a_soak_explains_what_went_wrong_in_it():
    job = soak_of(navigator="soak_sleeper:Sleeper").run_job()
    facts = job.post_mortem
    assert (facts.x, facts.y, facts.believed_x, facts.believed_y) == (3.6, 1.2, 0.0, 0.0)
    sentence = explain(job, facts)
    assert sentence.startswith(f"gave {job.goal} up as asleep: stood 3.79 m east of where")


def test_post_mortems_are_kept_and_jobs_without_them_are_read():
    job = job_of(reason="lost", post_mortem=facts_of(doors=(door_of(),)))
    course = Course(load_floor(FLOOR), SoakOptions(floor=FLOOR))
    course.enter(job)
    kept = json.loads(json.dumps(course.snapshot()))
    course.restore(kept)
    assert course.tally.jobs == [job]
    del kept["tally"]["jobs"][0]["post_mortem"]
    course.restore(kept)
    assert course.tally.jobs[0].post_mortem is None


coordinates = st.floats(-5.0, 5.0).map(lambda value: round(value, 3))
spots = st.tuples(coordinates, coordinates)


@given(spots, spots)
@settings(max_examples=50)
def test_a_line_crosses_a_wall_where_its_ends_are_on_both_sides(one, other):
    wall = np.array([[0.0, -100.0, 0.0, 100.0]])
    assert crossed(wall, one, other) == (one[0] * other[0] < 0.0)
    beyond = np.array([[0.0, 50.0, 0.0, 100.0]])
    assert not crossed(beyond, one, other)
