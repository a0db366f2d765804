"""Complete what a user asked for, from all who may know what is missing."""

from __future__ import annotations

import logging
from collections.abc import Collection

from rogue.errors import FingerError, MissingRoomError, UnknownNameError
from rogue.memory import Store
from rogue.messages import DeliveryRequest, Filled, PostRequest, Refusal
from rogue.requests._directory import Directory
from rogue.requests._entries import Person
from rogue.requests._finger import FingerServer, finger, finger_account
from rogue.requests._intake import accept, draft, normal
from rogue.requests._plan_file import PlanFile, read_plan
from rogue.requests._questions import Questions, wording
from rogue.requests._rooms import room_in

log = logging.getLogger(__name__)


class Reception:
    """Makes whole requests of what users ask for."""

    def __init__(
        self,
        *,
        store: Store,
        directory: Directory,
        questions: Questions,
        server: FingerServer | None = None,
    ) -> None:
        self._store = store
        self._directory = directory
        self._questions = questions
        self._server = server

    async def load(self) -> None:
        """Remember those who were met when the agent last ran."""
        for user, person in (await self._store.people()).items():
            self._directory.meet(user, Person.model_validate(person))

    async def complete(
        self, message: PostRequest, *, rooms: Collection[str], now: float
    ) -> tuple[DeliveryRequest, tuple[Filled, ...]]:
        """The request that ``message`` asks for, and what of it was filled in.

        Raises:
            RequestError: something is wrong with it, or missing, and nobody knows it.
        """
        directory, user, item = self._directory, normal(message.user), normal(message.item)
        plan = None if directory.listed(user) else await self._meet(user, rooms)
        found = draft(message, directory=directory, plan=plan, rooms=rooms)
        tried = "the people directory does not say"
        if found.missing and plan is None:
            plan, tried = await self._ask_finger(user, tried)
            found = draft(message, directory=directory, plan=plan, rooms=rooms)
        for end in found.missing:
            phrase = directory.phrase(user, item)
            if not message.ask:
                raise MissingRoomError(end, wording(end, phrase), tried)
            room = await self._questions.room(
                message.id, end, about=(user, item), phrase=phrase, rooms=rooms
            )
            found.fill(Filled(slot=end, value=room, source="answer"))
        return accept(message, found, directory=directory, plan=plan, now=now)

    async def _meet(self, user: str, rooms: Collection[str]) -> PlanFile | None:
        """Find out about somebody whom the directory does not list, and remember it."""
        plan, tried = await self._ask_finger(user, "")
        if plan is not None:
            rank = self._directory.defaults.rank
            room = room_in(plan.room, rooms) if plan.room else None
            person = Person(name=plan.name or user, room=room, rank=rank)
            await self._store.add_person(user, person.model_dump(mode="json"))
            self._directory.meet(user, person)
        elif user not in self._directory.people:
            known, hint = self._directory.people, f" {tried}." if tried else ""
            raise UnknownNameError(Refusal.UNKNOWN_USER, "user", user, known, hint=hint)
        return plan

    async def _ask_finger(self, user: str, tried: str) -> tuple[PlanFile | None, str]:
        """What a finger server knows; also ``tried``, and what came of asking there."""
        listed = self._directory.listed(user)
        login, server = user, self._server
        if listed is not None and listed.finger is not None:
            login, server = finger_account(listed.finger)
        if server is None:
            return None, tried
        try:
            reply = await finger(login, server)
        except FingerError as error:
            log.warning("nothing was learned of %s: %s", user, error)
            return None, _and(tried, str(error))
        plan = read_plan(reply, login) if reply is not None else None
        return plan, _and(tried, f"the finger server {server} does not know either")


def _and(tried: str, more: str) -> str:
    return f"{tried}, {more}" if tried else more
