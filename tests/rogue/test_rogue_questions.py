"""Asking the person for a room that nobody knows."""

from __future__ import annotations

from pathlib import Path

import pytest
from rogue_fakes import FakeModule, reception

from rogue.errors import MissingRoomError
from rogue.memory import Store
from rogue.messages import DeliveryRequest, PostRequest
from rogue.requests import load_directory
from tca_bus import Failure, TaskFailedError
from xavier_sim.messages import Ask, Typed

ROOMS = [f"r-53{number:02d}" for number in range(1, 16)]
VISITOR = PostRequest(id="a", user="visitor", item="delivermail", ask=True)


class Handle:
    def __init__(self, answer: str | None) -> None:
        self.answer = answer

    async def result(self) -> Typed:
        if self.answer is None:
            failure = Failure(name="no_answer", text="nobody answered within 60 s")
            raise TaskFailedError("C_ask", failure)
        return Typed(answer=self.answer, time=0.0)


class Keyboard(FakeModule):
    """A module with somebody at the robot's keyboard who says, or does not say, something."""

    def __init__(self, *answers: str | None) -> None:
        super().__init__()
        self.lines = list(answers)
        self.asked: dict[str, Ask] = {}

    async def execute(self, message: Ask, *, id: str, wait_for_handler: float) -> Handle:
        del wait_for_handler
        self.asked[id] = message
        return Handle(self.lines.pop(0))


async def complete(folder: Path, keyboard: Keyboard) -> tuple[DeliveryRequest, list[str]]:
    async with Store(folder) as store:
        desk = reception(keyboard, store, load_directory())
        request, filled = await desk.complete(VISITOR, rooms=ROOMS, now=0.0)
        lines = [line.text for line in await store.lines(0, 10)]
        assert [one.source for one in filled] == ["directory", "answer", "default"]
        return request, lines


async def test_the_person_is_asked_once_under_the_name_of_the_request(tmp_path: Path):
    keyboard = Keyboard("Room 5307, please")
    request, lines = await complete(tmp_path, keyboard)
    assert request.deliver == "r-5307"
    ((task, ask),) = keyboard.asked.items()
    assert task.endswith("-q.a.deliver.1")
    assert (ask.about, ask.user, ask.item) == ("deliver", "visitor", "delivermail")
    question = "Which room shall I take the visitor's mail delivery to?"
    assert ask.question == question
    assert lines == [f"{question}: Room 5307, please"]


async def test_an_answer_that_is_no_room_is_asked_for_again(tmp_path: Path):
    request, lines = await complete(tmp_path, Keyboard("over there", None, "5301"))
    assert request.deliver == "r-5301"
    assert [line.rpartition(": ")[2] for line in lines] == [
        "over there",
        "(nobody answered within 60 s)",
        "5301",
    ]


async def test_without_an_answer_the_request_is_refused(tmp_path: Path):
    with pytest.raises(MissingRoomError, match=r"\(nobody answered within 60 s\)") as caught:
        await complete(tmp_path, Keyboard(None, None, None))
    assert caught.value.objection.field == "deliver"


async def test_nobody_is_asked_unless_that_is_wanted(tmp_path: Path):
    keyboard = Keyboard()
    async with Store(tmp_path) as store:
        desk = reception(keyboard, store, load_directory())
        message = VISITOR.model_copy(update={"ask": False})
        with pytest.raises(MissingRoomError, match="name a room, with --to"):
            await desk.complete(message, rooms=ROOMS, now=0.0)
    assert not keyboard.asked
