"""The people directory: who works where, how important they are, and what is carried for them."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from rogue.errors import DirectoryError, UnknownNameError
from rogue.messages import Refusal

USER = "user"
"""The end of an errand that is the room of its user."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Person(_Entry):
    """Somebody with a room; ``rank`` is PersonRank, the position in the department."""

    name: str = Field(min_length=1)
    room: str = Field(min_length=1)
    rank: int = Field(ge=0)
    title: str = ""


class Item(_Entry):
    """Something to carry: how the robot calls it, TaskRank, and where it comes from and goes.

    ``start`` and ``end`` name a service of the directory, or `USER`.
    """

    phrase: str = Field(min_length=1)
    rank: int = Field(ge=0)
    start: str = Field(alias="from")
    end: str = Field(alias="to")


class Directory(_Entry):
    """People and items by their names, services by the room that has them."""

    services: dict[str, str]
    people: dict[str, Person]
    items: dict[str, Item]

    @model_validator(mode="after")
    def _services_exist(self) -> Directory:
        known = {USER, *self.services}
        for name, item in self.items.items():
            for end in (item.start, item.end):
                if end not in known:
                    raise ValueError(
                        f"item {name}: {end!r} is no service; expected one of {sorted(known)}"
                    )
        return self

    def person(self, user: str) -> Person:
        """The entry of a user.

        Raises:
            UnknownNameError: there is nobody of that name.
        """
        if user not in self.people:
            raise UnknownNameError(Refusal.UNKNOWN_USER, "user", user, self.people)
        return self.people[user]

    def item(self, item: str) -> Item:
        """The entry of an item.

        Raises:
            UnknownNameError: nothing of that name is carried.
        """
        if item not in self.items:
            raise UnknownNameError(Refusal.UNKNOWN_ITEM, "item", item, self.items)
        return self.items[item]

    def ends(self, user: str, item: str) -> tuple[str, str]:
        """The rooms where an errand begins and ends when its user names none."""
        rooms = {USER: self.person(user).room, **self.services}
        entry = self.item(item)
        return rooms[entry.start], rooms[entry.end]

    def rank(self, user: str, item: str) -> int:
        """PersonRank + TaskRank, the priority metric of Haigh & Veloso (1996), section 4."""
        return self.person(user).rank + self.item(item).rank

    def phrase(self, user: str, item: str) -> str:
        """What the robot says for an item of a user: ``Tom Mitchell's mail delivery``."""
        return f"{self.person(user).name}'s {self.item(item).phrase}"


def load_directory(path: Path | None = None) -> Directory:
    """Read a people directory; without ``path`` the one that comes with the package.

    Raises:
        DirectoryError: the file cannot be read or does not fit.
    """
    name = str(path) if path else "people.yaml"
    try:
        source = path or resources.files("rogue.requests") / "people.yaml"
        content: Any = yaml.safe_load(source.read_text(encoding="utf-8"))
        return Directory.model_validate(content)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise DirectoryError(name, str(error)) from error
    except ValidationError as error:
        raise DirectoryError(name, "; ".join(_sentences(error))) from error


def _sentences(error: ValidationError) -> list[str]:
    return [
        f"{'.'.join(map(str, one['loc'])) or 'the document'}: {one['msg']}"
        + (f", got {one['input']!r}" if isinstance(one["input"], str | int | float) else "")
        for one in error.errors()
    ]
