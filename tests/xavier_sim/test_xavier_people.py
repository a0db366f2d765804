"""The people of the office and the keyboard, without a bus."""

from __future__ import annotations

import asyncio
import io
import os

import pytest

from tca_bus import TaskError
from tca_bus.testing import eventually
from xavier_sim.messages import Ask, TrueLocation
from xavier_sim.office import Habits, Keyboard, NotMovedError, RecordFile
from xavier_sim.office._keyboard import TYPE_AHEAD, accept, prompt_for
from xavier_sim.office._people import QUICKEST, SLOWEST, People, truthful_answer
from xavier_sim.office._spoken_record import KEPT, Done
from xavier_sim.office._things import KEPT as KEPT_THINGS
from xavier_sim.office._things import Things, item_action
from xavier_sim.snapshots import SnapshotError

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
    one, two = (People(seed=4, habits=Habits(silence=0.3)) for _ in range(2))
    questions = [f"question {number}?" for number in range(50)]
    assert [one.react(q, 1) for q in questions] == [two.react(q, 1) for q in reversed(questions)][
        ::-1
    ]
    assert one.react("question 1?", 1) != one.react("question 1?", 2)


def test_share_of_silence_and_delays():
    people = People(seed=1, habits=Habits(silence=0.2))
    delays = [people.react(f"{number}?", 1).delay for number in range(1000)]
    assert 150 < delays.count(None) < 250
    assert all(QUICKEST <= delay <= SLOWEST for delay in delays if delay is not None)


def test_nobody_is_silent_when_told_so():
    people = People(seed=1, habits=Habits())
    assert all(people.react(f"{number}?", 1).delay is not None for number in range(200))


ROOMS = [f"r-53{number:02}" for number in range(1, 61)]


def test_a_share_of_the_people_never_answer_and_stay_that_way():
    people = People(seed=2, habits=Habits(silent_people=0.2))
    silent = {room for room in ROOMS if not people.occupant(room, 0.0).answers}
    assert 5 < len(silent) < 20
    for room in ROOMS:
        heard = [people.is_heard(ask("place"), at(room), now) for now in (0.0, 1e5)]
        assert heard == [room not in silent] * 2
    assert people.is_heard(ask("place"), at(None), 0.0)


def test_people_come_and_go_by_the_half_hour():
    people = People(seed=2, habits=Habits(away=0.3))
    stays = [[people.occupant(room, now).present for room in ROOMS] for now in (0.0, 10.0, 1800.0)]
    assert stays[0] == stays[1] != stays[2]
    assert 8 < stays[0].count(False) < 28


def test_who_was_sent_out_is_out_until_sent_in():
    sent = {}
    people = People(seed=2, habits=Habits(), sent=sent)
    people.send(ROOM, present=False)
    assert not people.is_heard(ask("place"), at(ROOM), 0.0)
    assert people.is_heard(ask("place"), at("r-5305"), 0.0)
    people.send(ROOM, present=True)
    assert people.is_heard(ask("place"), at(ROOM), 0.0)
    assert sent == {ROOM: True}


def test_a_share_of_the_items_is_missing_and_stays_so():
    people = People(seed=2, habits=Habits(missing_items=0.25))
    there = [people.has_item(room, "mitchell", "delivermail") for room in ROOMS]
    assert 5 < there.count(False) < 25
    assert there == [people.has_item(room, "mitchell", "delivermail") for room in ROOMS]


def test_an_item_that_is_not_there_is_impossible():
    for about in ("placing", "taking"):
        assert truthful_answer(ask(about, ("y", "i")), at(ROOM), is_there=False) == "i"


def test_a_user_has_a_room_in_mind_for_each_end_of_an_errand():
    people = People(seed=2, habits=Habits(silent_people=0.5))
    wanted = [ask(about, (), user="jhm", item="deliverfax") for about in ("pickup", "deliver")]
    rooms = [people.room_for(one, ROOMS) for one in wanted]
    assert rooms == [people.room_for(one, ROOMS) for one in wanted]
    assert set(rooms) <= set(ROOMS)
    assert people.room_for(ask("pickup", ("r-1", "r-2"), user="jhm"), ROOMS) in {"r-1", "r-2"}
    assert people.room_for(ask("pickup", ()), []) == "nowhere"
    names = [f"user{number}" for number in range(40)]
    heard = [people.is_heard(ask("pickup", user=name), at(None), 0.0) for name in names]
    assert 8 < heard.count(False) < 32


def test_item_moves_only_when_somebody_says_yes():
    assert item_action(PLACING, "y") == "placed"
    assert item_action(PLACING, "i") is None
    assert item_action(ask("taking", ("y", "i"), user="u", item="i"), "y") == "taken"
    assert item_action(ask("place"), "y") is None


PLACING = ask("placing", ("y", "i"), user="mitchell", item="delivermail")
MAIL = ("mitchell", "delivermail")


def test_what_is_taken_from_the_tray_is_gone_for_one_question():
    things = Things()
    with pytest.raises(NotMovedError, match="delivermail of mitchell cannot be taken: it is not"):
        things.move(*MAIL, "taken")
    things.handed_over(PLACING, "placed")
    things.move(*MAIL, "taken")
    assert things.tray == []
    assert not things.is_there(PLACING)
    assert things.is_there(PLACING)


def test_what_another_brings_need_not_be_picked_up():
    things = Things()
    things.move(*MAIL, "brought")
    assert not things.is_there(PLACING)
    things.handed_over(PLACING, "placed")
    with pytest.raises(NotMovedError, match="it is on the tray"):
        things.move(*MAIL, "brought")
    things.handed_over(PLACING, "taken")
    assert things == Things()


def test_things_are_forgotten_one_day():
    things = Things()
    for number in range(KEPT_THINGS + 5):
        things.move(f"user{number}", "mail", "brought")
    assert len(things.gone) == KEPT_THINGS


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
    from xavier_sim.office._speech_module import no_answer

    error = no_answer(ask("place"), "silence for 60 s")
    assert isinstance(error, TaskError)
    assert error.name == "no_answer"
    assert error.data == {"question": "Well?", "timeout": 60.0}
