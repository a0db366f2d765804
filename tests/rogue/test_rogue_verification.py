"""Where the robot stands, found out layer by layer."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rogue_fakes import NO_ANSWER, ScriptedRobot, failed, plate, play, position, typed

from navigate.messages import NavigateToGoal, NoticeLandmark, SetPosition
from rogue.execution import (
    Bystander,
    Doubt,
    Evidence,
    NavigatorBelief,
    Part,
    Patience,
    Tell,
    Verification,
    Whereabouts,
    go_to,
    layered,
)
from xavier_sim.messages import Ask

PATIENCE = Patience()
ROOMS = st.sampled_from(["r-1", "r-2", "r-3", "r-4"])
LIKELIHOOD = st.floats(0.001, 1.0)
EVIDENCE = st.builds(Evidence, st.dictionaries(ROOMS, LIKELIHOOD, max_size=3), LIKELIHOOD)


def total(known: Whereabouts) -> float:
    return sum(known.named.values()) + known.rest


@settings(max_examples=30, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(EVIDENCE, max_size=3))
def test_probabilities_add_up_to_one_in_whatever_order_evidence_comes(
    evidence: list[Evidence],
) -> None:
    results = []
    for order in itertools.islice(itertools.permutations(evidence), 6):
        known = Whereabouts()
        for one in order:
            known = known.updated(one)
        assert total(known) == pytest.approx(1.0)
        results.append([known.of(room) for room in ("r-1", "r-2", "r-3", "r-4", "r-9")])
    assert all(result == pytest.approx(results[0]) for result in results)


def test_a_room_that_evidence_names_late_was_as_probable_as_all_others() -> None:
    known = Whereabouts().updated(Evidence({"r-1": 0.9}, 0.1))
    assert known.of("r-2") == pytest.approx(known.rest / known.others)
    after = known.updated(Evidence({"r-2": 0.5}, 0.5))
    assert after.of("r-2") == pytest.approx(known.of("r-2"))


def arrive(robot: ScriptedRobot, arrival: Verification | None = None) -> tuple[str, list[str]]:
    outcome, lines = play(go_to("r-5303", PATIENCE, arrival or layered()), robot.outcome)
    return outcome.kind, [line.strip() for line in lines]


def test_a_navigator_that_is_sure_is_enough() -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.99))
    kind, lines = arrive(robot)
    assert kind == "done"
    assert robot.count(Ask) == 0
    assert "The navigator believes to be at R-5303 (0.990)." in lines
    assert not any("camera" in line for line in lines)


def test_the_door_plate_makes_sure_where_the_navigator_is_not() -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.8), plates=[plate("R-5303")])
    kind, lines = arrive(robot)
    assert kind == "done"
    assert robot.count(Ask) == 0
    assert "The camera reads R-5303 (0.950)." in lines
    assert "Taken together: R-5303 (1.000)." in lines


def test_the_navigator_is_told_of_the_plate_that_made_sure() -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.8), plates=[plate("r-5303")])
    arrive(robot)
    (told,) = [m for m in robot.performed if isinstance(m, NoticeLandmark)]
    assert told.room == "r-5303"
    assert told.confidence > 0.99


def test_a_plate_that_is_misread_is_looked_at_again_before_anybody_is_asked() -> None:
    robot = ScriptedRobot(
        belief=position("r-5303", 0.9), plates=[plate("r-5308", 0.9), plate("r-5303", 0.97)]
    )
    kind, _ = arrive(robot)
    assert kind == "done"
    assert (robot.count(NavigateToGoal), robot.count(Ask)) == (1, 0)


def test_a_plate_that_is_not_found_is_looked_for_again() -> None:
    robot = ScriptedRobot(belief=position(None), plates=[plate(None), plate("r-5303", 0.99)])
    kind, _ = arrive(robot)
    assert kind == "done"
    assert robot.count(Ask) == 0


@pytest.mark.parametrize(("expected", "first"), [(0.0, Ask), (0.35, SetPosition)])
def test_a_plate_where_the_navigator_may_well_be_needs_nobody_to_confirm_it(
    expected: float, first: type
) -> None:
    seen = plate("r-5305", 0.93, expected)
    robot = ScriptedRobot(belief=position("r-5303", 0.6), plates=[seen, failed("camera_gone")])
    arrive(robot)
    done = [type(message) for message in robot.performed]
    assert next(kind for kind in done if kind in (Ask, SetPosition)) is first


@pytest.mark.parametrize(
    ("confidence", "plates", "by"),
    [(0.99, [], "belief"), (0.8, [plate("r-5303")], "camera"), (0.8, [plate(None)] * 2, "person")],
)
def test_the_layer_that_made_sure_is_named(confidence, plates, by) -> None:
    robot = ScriptedRobot(belief=position("r-5303", confidence), plates=plates)
    outcome, _ = play(go_to("r-5303", PATIENCE, layered()), robot.outcome)
    (arrival,) = outcome.arrivals
    assert (arrival.room, arrival.by) == ("r-5303", by)


@pytest.mark.parametrize("seen", [plate(None), failed("camera_gone"), failed("no_handler")])
def test_a_person_is_asked_where_the_camera_sees_nothing(seen) -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.8), plates=[seen], answers=[typed("y")])
    kind, lines = arrive(robot)
    assert kind == "done"
    assert robot.count(Ask) == 1
    assert any(line.startswith("The camera sees no") for line in lines)


def test_a_plate_of_another_room_is_told_the_navigator_without_asking_anybody() -> None:
    robot = ScriptedRobot(
        belief=position("r-5303", 0.3),
        plates=[plate("r-5305", 0.99), plate("r-5305", 0.99), plate("r-5303", 0.99)],
    )
    kind, _ = arrive(robot)
    assert kind == "done"
    assert SetPosition(room="r-5305") in robot.performed
    assert (robot.count(NavigateToGoal), robot.count(Ask)) == (2, 0)


def test_a_plate_that_contradicts_a_sure_navigator_is_put_to_a_person() -> None:
    robot = ScriptedRobot(
        belief=position("r-5303", 0.97), plates=[plate("r-5305")], answers=[typed("y")]
    )
    kind, _ = arrive(robot)
    assert kind == "done"
    assert [m.about for m in robot.performed if isinstance(m, Ask)] == ["place"]


def test_a_person_who_says_no_and_names_the_room_outweighs_the_navigator() -> None:
    robot = ScriptedRobot(
        belief=position("r-5303", 0.97), answers=[typed("n"), typed("r-5305"), typed("y")]
    )
    kind, lines = arrive(robot)
    assert kind == "done"
    assert "The robot is at R-5305." in lines
    assert SetPosition(room="r-5305") in robot.performed


def test_where_nobody_makes_sure_the_robot_does_not_act_as_if() -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.5), answers=[NO_ANSWER] * 99)
    kind, _ = arrive(robot)
    assert kind == "failed"
    assert robot.count(NavigateToGoal) == PATIENCE.tries


def test_a_lost_robot_reads_the_plate_before_it_asks() -> None:
    robot = ScriptedRobot(drives=[failed("lost")], plates=[plate("r-5305", 0.99)])
    kind, _ = arrive(robot)
    assert kind == "done"
    assert SetPosition(room="r-5305") in robot.performed
    assert robot.count(Ask) == 0


@pytest.mark.parametrize(("sure", "asked"), [(0.5, 0), (0.9, 1)])
def test_how_sure_is_sure_enough_can_be_said(sure: float, asked: int) -> None:
    robot = ScriptedRobot(belief=position("r-5303", 0.8))
    kind, _ = arrive(robot, layered(sure=sure, camera=False))
    assert kind == "done"
    assert robot.count(Ask) == asked


def test_a_layer_of_ones_own_takes_its_place_in_the_list() -> None:
    class Beacon:
        name = "beacon"

        def look(self, doubt: Doubt) -> Part[Evidence | None]:
            yield Tell("A beacon was heard.")
            return Evidence({doubt.room or "": 1.0}, 1e-6)

    robot = ScriptedRobot(belief=position(None))
    kind, lines = arrive(robot, Verification((Beacon(), NavigatorBelief(), Bystander())))
    assert kind == "done"
    assert "A beacon was heard." in lines
    assert not any("navigator believes" in line for line in lines)
