"""Ask the person for what nobody knows, on the robot's keyboard.

A question is a task whose id follows from the request's, so that it is asked once, however often
the request is posted and the agent started again meanwhile.
"""

from __future__ import annotations

from collections.abc import Collection

from rogue import trace
from rogue.conversation import Conversation
from rogue.errors import MissingRoomError
from rogue.memory import Store
from rogue.messages import End
from rogue.requests._rooms import room_in
from tca_bus import Module, TaskFailedError, TcaError
from xavier_sim.messages import Ask

ASKS = 3
"""How often a question is asked, when nobody answers or the answer is no room."""

ANSWER_WITHIN = 60.0
"""Seconds on the module's clock that an answer is waited for, each time."""

HANDLER_WAIT = 5.0
"""Wall seconds that a question waits for a keyboard to be there."""

_WORDING = {
    "pickup": "Which room shall I get {} from?",
    "deliver": "Which room shall I take {} to?",
}


class Questions:
    """Finds out what only the person knows."""

    def __init__(self, module: Module, store: Store, conversation: Conversation) -> None:
        self._module = module
        self._store = store
        self._conversation = conversation

    async def room(
        self,
        request_id: str,
        end: End,
        *,
        about: tuple[str, str],
        phrase: str,
        rooms: Collection[str],
    ) -> str:
        """The room of one end of a request.

        Args:
            request_id: the request.
            end: which end.
            about: user and item.
            phrase: what the robot calls the item of the user.
            rooms: the rooms of the map.

        Raises:
            MissingRoomError: nobody answers with a room.
        """
        user, item = about
        question = wording(end, phrase)
        ask = Ask(question=question, about=end, user=user, item=item, timeout=ANSWER_WITHIN)
        identity = f"{await self._store.identity()}-q.{request_id}.{end}"
        problem = ""
        for number in range(1, ASKS + 1):
            try:
                answer = await self._answer(f"{identity}.{number}", ask)
            except TaskFailedError as error:
                problem = error.failure.text
                await self._conversation.tell(trace.prompt_line(question, f"({problem})"))
                continue
            except TcaError as error:
                raise MissingRoomError(end, question, str(error).rstrip(".")) from error
            await self._conversation.tell(trace.prompt_line(question, answer))
            if room := room_in(answer, rooms):
                return room
            problem = f"the answer {answer!r} is no room"
        raise MissingRoomError(end, question, problem)

    async def _answer(self, task_id: str, ask: Ask) -> str:
        handle = await self._module.execute(ask, id=task_id, wait_for_handler=HANDLER_WAIT)
        return (await handle.result()).answer


def wording(end: End, phrase: str) -> str:
    """The question for a room, for people and terminals alike."""
    return _WORDING[end].format(phrase)
