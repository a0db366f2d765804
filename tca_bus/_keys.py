"""The key expressions of the bus, all in one place.

::

    <realm>/query/<callee>/<incarnation>/<name>/<caller>          queries, as Zenoh queries; unique
                                                                  per callee, so that exactly one
                                                                  gets each
    <realm>/call/<callee>/<incarnation>/<name>/<caller>           the same, published
    <realm>/answer/<caller>/<incarnation>/<callee>                answers to what was published
    <realm>/inform/<name>/<sender>                                informs
    <realm>/broadcast/<name>/<sender>                             broadcasts
    <realm>/task/<sender>/<id>                                    task states, from central
    <realm>/variable/<name>                                       shared variables, from central
    <realm>/presence/<module>/<incarnation>/<host>/<pid>/<names>/<more>
                                                                  liveliness tokens; names of the
                                                                  messages it handles, by comma

``more`` begins with the number of the token, which counts how often the module has replaced it;
after it, by comma, come ``+`` and a resource that it offers, ``-`` and one that it requires, and
``held``, ``waiting`` or ``ready`` if it said so: ``2,+map,-odometry,ready``. It may be left out.

The name of whoever sends stands in the key, so that a router's access rules can bind it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import NamedTuple

from tca_bus._presence import PresentModule, Stage

NO_NAMES = "-"
"""Stands for an empty list in a presence key, since a chunk may not be empty."""

_NOT_IN_CHUNK = re.compile(r"[^A-Za-z0-9._:-]")


class QueryAddress(NamedTuple):
    """What the key of a query says."""

    name: str
    caller: str


@dataclass(frozen=True, slots=True)
class Keys:
    """The keys of one realm."""

    realm: str

    def query(self, callee: PresentModule, name: str, caller: str) -> str:
        """The key of one query to one module."""
        return f"{self.realm}/query/{callee.name}/{callee.incarnation}/{name}/{caller}"

    def queries_to(self, name: str, incarnation: str) -> str:
        """All queries to one incarnation of a module."""
        return f"{self.realm}/query/{name}/{incarnation}/**"

    def call(self, callee: PresentModule, name: str, caller: str) -> str:
        """The key on which a query to one module is published."""
        return f"{self.realm}/call/{callee.name}/{callee.incarnation}/{name}/{caller}"

    def calls_to(self, name: str, incarnation: str) -> str:
        """All published queries to one incarnation of a module."""
        return f"{self.realm}/call/{name}/{incarnation}/*/*"

    def answer(self, caller: str, incarnation: str, callee: str) -> str:
        """The key of the answers of one module to one incarnation of another."""
        return f"{self.realm}/answer/{caller}/{incarnation}/{callee}"

    def answers_to(self, name: str, incarnation: str) -> str:
        """All answers to one incarnation of a module."""
        return f"{self.realm}/answer/{name}/{incarnation}/*"

    def one_way(self, kind: str, name: str, sender: str) -> str:
        """The key of an inform or broadcast; ``sender`` may be ``*``."""
        return f"{self.realm}/{kind}/{name}/{sender}"

    def task(self, sender: str, id: str) -> str:
        """The key of a task's state; either part may be ``*``."""
        return f"{self.realm}/task/{sender}/{id}"

    def all_tasks(self) -> str:
        """All task states."""
        return f"{self.realm}/task/**"

    def variable(self, name: str) -> str:
        """The key of a shared variable; ``*`` for all."""
        return f"{self.realm}/variable/{name}"

    def presence(self, module: PresentModule) -> str:
        """The liveliness token of a module."""
        names = ",".join(module.provides) or NO_NAMES
        host = _NOT_IN_CHUNK.sub("-", module.host) or NO_NAMES
        process = f"{module.name}/{module.incarnation}/{host}/{module.pid}"
        return f"{self.realm}/presence/{process}/{names}/{_more_of(module)}"

    def all_presence(self) -> str:
        """The tokens of all modules."""
        return f"{self.realm}/presence/**"


def parse_query(key: str) -> QueryAddress:
    """Read name and caller from the key of a query, published or not.

    Raises:
        ValueError: The key has another shape.
    """
    chunks = key.split("/")
    if len(chunks) != 6:
        raise ValueError(f"{key!r} is no query key: expected 6 parts, got {len(chunks)}")
    return QueryAddress(name=chunks[4], caller=chunks[5])


def parse_sender(key: str) -> str:
    """Read the sender from the key of an inform, a broadcast or an answer."""
    return key.rsplit("/", 1)[-1]


def parse_task(key: str) -> tuple[str, str]:
    """Read sender and id from a key or key expression of task states; ``*`` where it is wild."""
    chunks = key.split("/")[2:]
    if len(chunks) != 2 or "**" in chunks:
        return "*", "*"
    return chunks[0], chunks[1]


def parse_presence(key: str) -> PresentModule:
    """Read a module from its liveliness token.

    Raises:
        ValueError: The key has another shape.
    """
    chunks = key.split("/")
    if len(chunks) not in {7, 8}:
        raise ValueError(f"{key!r} is no presence key: expected 7 or 8 parts, got {len(chunks)}")
    _, _, name, incarnation, host, pid, names = chunks[:7]
    provides = () if names == NO_NAMES else tuple(names.split(","))
    if not pid.isascii() or not pid.isdigit():
        raise ValueError(f"{key!r} is no presence key: expected a process number, got {pid!r}")
    module = PresentModule(name, incarnation, host, int(pid), provides)
    return _with_more(module, chunks[7].split(",")) if len(chunks) == 8 else module


def _more_of(module: PresentModule) -> str:
    words = [str(module.number)]
    words += [f"+{name}" for name in module.resources]
    words += [f"-{name}" for name in module.requires]
    return ",".join([*words, module.stage] if module.stage else words)


def _with_more(module: PresentModule, words: list[str]) -> PresentModule:
    number, *rest = words
    stages = [word for word in rest if word[:1] not in {"+", "-"}]
    return replace(
        module,
        number=int(number),
        resources=tuple(word[1:] for word in rest if word[:1] == "+"),
        requires=tuple(word[1:] for word in rest if word[:1] == "-"),
        stage=Stage(stages[0]) if stages else Stage.UNSAID,
    )
