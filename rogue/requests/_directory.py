"""The people directory: who is who, what can be carried, and what follows for a request."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rogue.errors import UnknownNameError
from rogue.messages import End, Filled, Refusal, Source
from rogue.requests._entries import USER, Defaults, Entries, Item, Person, read_entries


class Directory:
    """People and items: those of a file, and the people who were met since.

    A file that is read again replaces the entries; whom and what they no longer name stays
    known by name for the sake of requests that are open, but is not accepted any more.
    """

    def __init__(self, entries: Entries) -> None:
        self._entries = entries
        self._met: dict[str, Person] = {}

    @property
    def people(self) -> Mapping[str, Person]:
        """Everybody, by login name."""
        return {**self._met, **self._entries.people}

    @property
    def items(self) -> Mapping[str, Item]:
        """All that is carried, by name."""
        return self._entries.items

    @property
    def defaults(self) -> Defaults:
        """What counts where nobody says otherwise."""
        return self._entries.defaults

    def listed(self, user: str) -> Person | None:
        """The entry of a user in the file."""
        return self._entries.people.get(user)

    def replace(self, entries: Entries) -> None:
        """Go by another file from now on."""
        self._entries = entries

    def meet(self, user: str, person: Person) -> None:
        """Learn of somebody whom the file does not name."""
        self._met[user] = person

    def person(self, user: str) -> Person:
        """The entry of a user.

        Raises:
            UnknownNameError: there is nobody of that name.
        """
        found = self.listed(user) or self._met.get(user)
        if found is None:
            raise UnknownNameError(Refusal.UNKNOWN_USER, "user", user, self.people)
        return found

    def item(self, item: str) -> Item:
        """The entry of an item.

        Raises:
            UnknownNameError: nothing of that name is carried.
        """
        if item not in self.items:
            raise UnknownNameError(Refusal.UNKNOWN_ITEM, "item", item, self.items)
        return self.items[item]

    def usual(self, end: End, user: str, item: str) -> Filled | None:
        """The room of one end of an errand when its user names none, where that is known."""
        entry = self.item(item)
        place = entry.start if end == "pickup" else entry.end
        if place is None:
            return None
        if place != USER:
            return Filled(slot=end, value=self._entries.services[place], source="directory")
        room = self.person(user).room
        source: Source = "directory" if self.listed(user) else "finger"
        return Filled(slot=end, value=room, source=source) if room else None

    def is_at_user(self, end: End, item: str) -> bool:
        """Whether that end of an errand is, as a rule, the room of its user."""
        entry = self.item(item)
        return (entry.start if end == "pickup" else entry.end) == USER

    def other_rooms(self, user: str, room: str) -> tuple[str, ...]:
        """Where else a user may be found who is not in ``room``; none if it is not theirs."""
        person = self.people.get(user)
        rooms = (person.room, *person.also) if person else ()
        others = (other for other in rooms if other is not None and other != room)
        return tuple(others) if room in rooms else ()

    def rank(self, user: str, item: str) -> int:
        """PersonRank + TaskRank, the priority metric of Haigh & Veloso (1996), section 4."""
        return self.person(user).rank + self.item(item).rank

    def phrase(self, user: str, item: str) -> str:
        """What the robot says for an item of a user: ``Tom Mitchell's mail delivery``.

        Whoever and whatever is no longer known goes by the plain name.
        """
        person, thing = self.people.get(user), self.items.get(item)
        return f"{person.name if person else user}'s {thing.phrase if thing else item}"


def load_directory(path: Path | None = None) -> Directory:
    """A people directory from a file; without ``path`` the one that comes with the package.

    Raises:
        DirectoryError: the file cannot be read or does not fit.
    """
    return Directory(read_entries(path))
