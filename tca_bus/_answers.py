"""Which requests a module has answered lately, so that one sent again is handled once."""

from __future__ import annotations

from collections import OrderedDict

from tca_bus._bridge import Answer

MOST_ANSWERS = 1024
MOST_BYTES = 4 * 1024 * 1024


class AnswerCache:
    """The latest answers by request, the least recently used forgotten first."""

    def __init__(self, *, most_answers: int = MOST_ANSWERS, most_bytes: int = MOST_BYTES) -> None:
        self._most_answers = most_answers
        self._most_bytes = most_bytes
        self._bytes = 0
        self._answers: OrderedDict[tuple[str, str], Answer] = OrderedDict()

    def get(self, request: tuple[str, str]) -> Answer | None:
        """The answer that was given, if it is still known."""
        if request in self._answers:
            self._answers.move_to_end(request)
        return self._answers.get(request)

    def put(self, request: tuple[str, str], answer: Answer) -> None:
        """Keep an answer."""
        self._answers[request] = answer
        self._bytes += len(answer.payload.data)
        while len(self._answers) > self._most_answers or self._bytes > self._most_bytes:
            _, forgotten = self._answers.popitem(last=False)
            self._bytes -= len(forgotten.payload.data)

    def __len__(self) -> int:
        return len(self._answers)
