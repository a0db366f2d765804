"""The people of the office and the keyboard, without a bus."""

from __future__ import annotations

import asyncio
import io
import os

import pytest

from tca_bus import TaskError
from tca_bus.testing import eventually
from xavier_sim.keyboard import TYPE_AHEAD, Keyboard, accept, prompt_for
from xavier_sim.messages import Ask, TrueLocation
from xavier_sim.people import QUICKEST, SLOWEST, People, item_action, truthful_answer
from xavier_sim.snapshots import SnapshotError
from xavier_sim.spoken_record import KEPT, Done, RecordFile

ROOM = "r-5303"


def at(room, space="corridor-53"):
    return TrueLocation(
        x=0, y=0, theta=0, room=room, space=space, metres=0, bumps=0, tick=0, time=0
    )


def ask(about, choices=("y", "n"), **more):
    return Ask(question="Well?", choices=choices, about=about, room=ROOM, **more)


@pytest.mark.parametrize(
    ("about", "choices", "really", "answer"),
    [
        ("place", ("y", "n"), ROOM, "y"),
        ("place", ("y", "n"), "r-5305", "n"),
        ("place", ("y", "n"), None, "n"),
        ("placing", ("y", "i"), ROOM, "y"),
        ("placing", ("y", "i"), "r-5305", "i"),
        ("taking", ("y", "i"), ROOM, "y"),
        ("taking", ("y", "i"), None, "i"),
        ("where", (), "r-5305", "r-5305"),
        ("where", (), None, "corridor-53"),
        ("other", ("maybe", "no"), ROOM, "no"),
        ("other", (), ROOM, "y"),
    ],
)
def test_people_tell_the_truth(about, choices, really, answer):
    assert truthful_answer(ask(about, choices), at(really)) == answer


def test_reactions_depend_on_seed_and_question_only():
    one, two = (People(seed=4, silence=0.3) for _ in range(2))
    questions = [f"question {number}?" for number in range(50)]
    assert [one.react(q, 1) for q in questions] == [two.react(q, 1) for q in reversed(questions)][
        ::-1
    ]
    assert one.react("question 1?", 1) != one.react("question 1?", 2)


def test_share_of_silence_and_delays():
    people = People(seed=1, silence=0.2)
    delays = [people.react(f"{number}?", 1).delay for number in range(1000)]
    assert 150 < delays.count(None) < 250
    assert all(QUICKEST <= delay <= SLOWEST for delay in delays if delay is not None)


def test_nobody_is_silent_when_told_so():
    people = People(seed=1, silence=0.0)
    assert all(people.react(f"{number}?", 1).delay is not None for number in range(200))


def test_item_moves_only_when_somebody_says_yes():
    moved = ask("placing", ("y", "i"), user="mitchell", item="delivermail")
    assert item_action(moved, "y") == "placed"
    assert item_action(moved, "i") is None
    assert item_action(ask("taking", ("y", "i"), user="u", item="i"), "y") == "taken"
    assert item_action(ask("place"), "y") is None


def test_prompts_of_figure_6():
    assert prompt_for("Am I really?", ("y", "n")) == "Am I really? (y/n): "
    assert prompt_for("Am I really? (y/n)", ("y", "n")) == "Am I really? (y/n): "
    assert prompt_for("Finished?", ("y", "i")) == "Finished? (y/i(mpossible)): "
    assert prompt_for("Which room am I at?", ()) == "Which room am I at?: "


def test_answers_that_count():
    assert accept(" Y \n", ("y", "n")) == "y"
    assert accept("impossible", ("y", "i")) == "i"
    assert accept("n", ("y", "i")) is None
    assert accept("", ()) is None
    assert accept(" r-5303\n", ()) == "r-5303"


async def test_keyboard_asks_again_until_the_answer_counts():
    screen = io.StringIO()
    async with Keyboard(io.StringIO("what\n\ny\n"), screen) as keyboard:
        assert await keyboard.ask("Done?", ("y", "i")) == "y"
    assert screen.getvalue().count("Done? (y/i(mpossible)): ") == 3
    assert screen.getvalue().count("Please type y or i.") == 2


async def test_keyboard_tells_end_of_input():
    async with Keyboard(io.StringIO(""), io.StringIO()) as keyboard:
        assert await keyboard.ask("Done?", ("y", "i")) is None
        assert await keyboard.ask("Done?", ("y", "i")) is None


async def test_keyboard_drops_the_oldest_of_too_much_typed_ahead():
    typed = "".join(f"{number}\n" for number in range(TYPE_AHEAD + 5))
    async with Keyboard(io.StringIO(typed), io.StringIO()) as keyboard:
        await eventually(lambda: keyboard._ended)
        assert keyboard.dropped == 5
        assert await keyboard.ask("Number?", ()) == "5"


async def test_keyboard_on_a_pseudo_terminal_does_not_block_the_loop():
    master, slave = os.openpty()
    screen = io.StringIO()
    with os.fdopen(slave) as source:
        async with Keyboard(source, screen) as keyboard:
            asking = asyncio.create_task(keyboard.ask("Here?", ("y", "n")), name="asking")
            await eventually(lambda: "Here?" in screen.getvalue())
            os.write(master, b"n\n")
            assert await asking == "n"
            os.write(master, b"\x04")
            await eventually(lambda: keyboard._ended)
    os.close(master)


def test_a_question_sent_again_keeps_its_number():
    record = RecordFile(None).record
    assert record.number("t1", "Well?") == 1
    assert record.number("t2", "Well?") == 2
    assert record.number("t1", "Well?") == 1


def test_record_survives_a_restart(tmp_path):
    first = RecordFile(tmp_path)
    first.record.number("t1", "Well?")
    first.record.finish("t2", Done(text="y", time=5.0))
    first.save()
    again = RecordFile(tmp_path).record
    assert again.done["t2"] == Done(text="y", time=5.0)
    assert again.number("t1", "Well?") == 1


def test_record_is_bounded():
    record = RecordFile(None).record
    for number in range(KEPT + 10):
        record.number(f"t{number}", f"q{number}")
        record.finish(f"t{number}", Done(text="y", time=0.0))
    assert len(record.done) == len(record.asked) == KEPT
    assert "t0" not in record.done


def test_damaged_record_is_a_clear_error(tmp_path):
    (tmp_path / "speech.json").write_text("[]")
    with pytest.raises(SnapshotError, match=r"speech\.json is no record"):
        RecordFile(tmp_path)


def test_no_answer_names_question():
    from xavier_sim.speech_module import no_answer

    error = no_answer(ask("place"), "silence for 60 s")
    assert isinstance(error, TaskError)
    assert error.name == "no_answer"
    assert error.data == {"question": "Well?", "timeout": 60.0}
