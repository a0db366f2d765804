"""The file of a people directory: who works where, how important they are, what is carried."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from rogue.deadlines import read_span
from rogue.errors import DirectoryError
from rogue.requests._finger import finger_account

USER = "user"
"""The end of an errand that is the room of its user."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Person(_Entry):
    """Somebody; ``rank`` is PersonRank, the position in the department.

    ``room`` is where they sit; without one, their finger server or they themselves are asked.
    ``finger`` is the address ``login@host`` or ``login@host:port`` of an account of theirs,
    ``also`` are other rooms in which they may be found, the likeliest first.
    """

    name: str = Field(min_length=1)
    room: str | None = Field(default=None, min_length=1)
    rank: int = Field(ge=0)
    title: str = ""
    finger: str | None = None
    also: tuple[str, ...] = ()

    @field_validator("finger")
    @classmethod
    def _is_an_account(cls, text: str | None) -> str | None:
        if text is not None:
            finger_account(text)
        return text


class Item(_Entry):
    """Something to carry: how the robot calls it, TaskRank, and where it comes from and goes.

    ``start`` and ``end`` name a service of the directory, or `USER`; without one, the user's
    finger server or the user is asked.
    """

    phrase: str = Field(min_length=1)
    rank: int = Field(ge=0)
    start: str | None = Field(default=None, alias="from")
    end: str | None = Field(default=None, alias="to")


class Defaults(_Entry):
    """What counts where nobody says otherwise.

    ``rank`` is the PersonRank of people whom only a finger server knows; ``deadline`` is the
    time that a request has whose user names none (an hour: Haigh & Veloso 1997, node 5).
    """

    rank: int = Field(default=0, ge=0)
    deadline: str = "1h"

    @field_validator("deadline")
    @classmethod
    def _is_a_span(cls, text: str) -> str:
        if not read_span(text):
            raise ValueError("a time from now on is expected, such as 30m or 1h30m")
        return text


class Entries(_Entry):
    """A directory as it is written: people and items by their names, services by their rooms."""

    services: dict[str, str]
    people: dict[str, Person]
    items: dict[str, Item]
    defaults: Defaults = Defaults()

    @model_validator(mode="after")
    def _services_exist(self) -> Self:
        known = {USER, *self.services}
        for name, item in self.items.items():
            for end in (item.start, item.end):
                if end is not None and end not in known:
                    raise ValueError(
                        f"item {name}: {end!r} is no service; expected one of {sorted(known)}"
                    )
        return self


def read_entries(path: Path | None = None) -> Entries:
    """Read a directory's file; without ``path`` the one that comes with the package.

    Raises:
        DirectoryError: the file cannot be read or does not fit.
    """
    name = str(path) if path else "people.yaml"
    try:
        source = path or resources.files("rogue.requests") / "people.yaml"
        content: Any = yaml.safe_load(source.read_text(encoding="utf-8"))
        return Entries.model_validate(content)
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
