from __future__ import annotations

import pytest
from rogue_fakes import NO_ANSWER, ScriptedRobot, failed, play, position, typed

from navigate.messages import NavigateToGoal, SetPosition
from rogue.execution import Patience, Perform, acquire, as_published, deliver, go_to, layered
from rogue.outcomes import Trouble
from rogue.trace import say_line
from xavier_sim.messages import Ask, Say

PATIENCE = Patience()
ASKING = as_published()
THING = ("mitchell", "delivermail")
MAIL = "Tom Mitchell's mail delivery"

GOTO_LINES = """\
          SENDING COMMAND (TCAEXPANDGOAL "navigateToG" #(TASK-CONTROL::MAPLOCDATA 567.0d0 2316.5d0))
          ...waiting...
          Action NAVIGATE-TO-GOAL-ACHIEVED finished.

          Verifying Location: R-5303
          SENDING COMMAND (TCAEXECUTECOMMAND "C_say" "Am I really at the door of room R-5303?")
          SENDING COMMAND (TCAEXECUTECOMMAND "C_say" "Please answer on my keyboard.")

Am I really at the door of room R-5303? (y/n): y
          COMPLETED-ACTION (GOTO-LOCATION 1 R-5303)
"""


def test_goto_prints_what_figure_6_prints():
    robot = ScriptedRobot()
    outcome, lines = play(go_to("r-5303", PATIENCE, ASKING), robot.outcome)
    assert "\n".join(lines) == GOTO_LINES
    assert (outcome.kind, outcome.room) == ("done", "r-5303")


def test_a_wrong_arrival_is_told_the_navigator_and_driven_again():
    robot = ScriptedRobot(answers=[typed("n"), typed("R-5305"), typed("y")])
    outcome, lines = play(go_to("r-5303", PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"
    assert SetPosition(room="r-5305") in robot.performed
    assert robot.count(NavigateToGoal) == 2
    assert "          The robot is at R-5305." in lines


def test_after_three_wrong_arrivals_the_planner_learns_the_true_room():
    robot = ScriptedRobot(answers=[typed("n"), typed("r-5305")] * 3)
    outcome, _ = play(go_to("r-5303", PATIENCE, ASKING), robot.outcome)
    assert (outcome.kind, outcome.room) == ("elsewhere", "r-5305")
    assert robot.count(NavigateToGoal) == 3


def test_a_room_that_nobody_knows_is_asked_for_again():
    robot = ScriptedRobot(answers=[typed("n"), typed("the loo"), typed("r-5305"), typed("y")])
    outcome, _ = play(go_to("r-5303", PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"


@pytest.mark.parametrize(
    ("room", "confidence", "kind"),
    [("r-5303", 0.99, "done"), ("r-5303", 0.5, "failed"), (None, 0.0, "failed")],
)
def test_with_nobody_there_a_navigator_that_is_sure_is_believed(room, confidence, kind):
    robot = ScriptedRobot(answers=[NO_ANSWER] * 99, belief=position(room, confidence))
    outcome, _ = play(go_to("r-5303", PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == kind
    if kind == "done":
        assert robot.count(Ask) == PATIENCE.asks


@pytest.mark.parametrize("reason", ["door_blocked", "corridor_blocked", "no_route"])
def test_a_blocked_way_is_left_to_the_planner_at_once(reason):
    robot = ScriptedRobot(drives=[failed(reason)] * 99)
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING), robot.outcome)
    assert (outcome.kind, outcome.trouble) == ("failed", Trouble.BLOCKED)
    assert outcome.reason is not None
    assert f"cannot get to r-5313, {reason}" in outcome.reason
    assert robot.count(NavigateToGoal) == 1
    assert robot.count(Ask) == 0


def test_a_robot_that_is_shut_in_asks_to_be_let_out_and_stays_where_it_is():
    shut = failed("door_blocked", door="r-5303")
    robot = ScriptedRobot(drives=[shut])
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING, start="r-5303"), robot.outcome)
    assert (outcome.trouble, outcome.room) == (Trouble.SHUT_IN, "r-5303")
    assert outcome.reason == "cannot get out of r-5303, door_blocked: it was door_blocked"
    assert [m.text for m in robot.performed if isinstance(m, Say)] == [
        "I am shut in. Please open the door."
    ]


@pytest.mark.parametrize("start", [None, "r-5305"])
def test_a_door_that_is_not_that_of_the_robots_room_shuts_nobody_in(start):
    robot = ScriptedRobot(drives=[failed("door_blocked", door="r-5313")])
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING, start=start), robot.outcome)
    assert (outcome.trouble, outcome.room) == (Trouble.BLOCKED, None)


@pytest.mark.parametrize("failure", ["bump", "no_progress", "lost"])
def test_a_way_that_is_not_mastered_may_be_tried_again_later(failure):
    robot = ScriptedRobot(drives=[failed(failure)] * 3, answers=[NO_ANSWER] * 99)
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING), robot.outcome)
    assert outcome.trouble is Trouble.HINDERED
    assert failure in (outcome.reason or "")
    assert robot.count(NavigateToGoal) == PATIENCE.tries


def test_a_lost_robot_asks_where_it_is():
    robot = ScriptedRobot(drives=[failed("lost")], answers=[typed("r-5305"), typed("y")])
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"
    assert [m.about for m in robot.performed if isinstance(m, Ask)] == ["where", "place"]


def test_a_drive_that_failed_where_the_navigator_knows_its_place_is_driven_again():
    robot = ScriptedRobot(drives=[failed("bump")], answers=[typed("y")])
    outcome, _ = play(go_to("r-5313", PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"
    assert [m.about for m in robot.performed if isinstance(m, Ask)] == ["place"]


def test_acquire_prints_what_figure_6_prints():
    outcome, lines = play(acquire("r-5303", THING, MAIL, PATIENCE, ASKING), ScriptedRobot().outcome)
    assert lines == [
        f'          SENDING COMMAND (TCAEXECUTECOMMAND "C_say" "Please place {MAIL} on my tray.")',
        say_line("Please indicate on my keyboard when you are finished."),
        "",
        f"Are you finished placing {MAIL} on my tray? (y/i(mpossible)): y",
        f'          COMPLETED-ACTION (ACQUIRE-ITEM 1 "{MAIL}")',
        "",
    ]
    assert (outcome.kind, outcome.room) == ("done", "r-5303")


def test_impossible_fails_with_that_reason():
    robot = ScriptedRobot(answers=[typed("i")], tray={THING})
    outcome, lines = play(deliver("r-5313", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "failed"
    assert outcome.reason == "deliver-item at r-5313, impossible: the person there said so"
    assert f"Are you finished taking {MAIL} from my tray? (y/i(mpossible)): i" in lines


def test_an_unanswered_question_is_asked_three_times():
    robot = ScriptedRobot(answers=[NO_ANSWER] * 99)
    outcome, _ = play(acquire("r-5303", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "failed"
    assert "no_answer: nobody answered" in (outcome.reason or "")
    assert (robot.count(Ask), robot.count(Say)) == (3, 6)


def test_an_answer_at_the_second_try_will_do():
    robot = ScriptedRobot(answers=[NO_ANSWER, typed("y")])
    outcome, _ = play(acquire("r-5303", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"


def test_what_is_on_the_tray_already_is_not_asked_for():
    robot = ScriptedRobot(tray={THING})
    outcome, _ = play(acquire("r-5303", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert (outcome.kind, outcome.placed) == ("done", (THING,))
    assert robot.count(Ask) == 0


def test_an_item_that_is_gone_is_not_delivered():
    robot = ScriptedRobot()
    outcome, _ = play(deliver("r-5313", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert (outcome.kind, outcome.trouble) == ("failed", Trouble.MISTAKEN)
    assert outcome.gone == (THING,)
    assert robot.count(Ask) == 0


def test_a_robot_that_was_moved_notices_before_it_hands_anything_over():
    robot = ScriptedRobot(belief=position("r-5305", 0.99), tray={THING})
    outcome, _ = play(deliver("r-5313", THING, MAIL, PATIENCE, layered()), robot.outcome)
    assert (outcome.trouble, outcome.room) == (Trouble.MISTAKEN, "r-5305")
    assert robot.performed == [SetPosition(room="r-5305")]


def test_an_item_that_was_put_there_without_a_word_is_there():
    class Silent(ScriptedRobot):
        def outcome(self, effect):
            if isinstance(effect, Perform) and isinstance(effect.message, Ask):
                self.tray.add(THING)
            return super().outcome(effect)

    robot = Silent(answers=[NO_ANSWER] * 99)
    outcome, _ = play(acquire("r-5303", THING, MAIL, PATIENCE, ASKING), robot.outcome)
    assert outcome.kind == "done"
