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
    <realm>/policy/<module>                                       who may do what, from the router

``more`` begins with the number of the token, which counts how often the module has replaced it;
after it, by comma, come ``+`` and a resource that it offers, ``-`` and one that it requires, and
``held``, ``waiting`` or ``ready`` if it said so: ``2,+map,-odometry,ready``. A tap on messages that
do not pass central is ``~``, its condition, ``~`` and the message (``:`` for all), and ``~fail`` if
what it holds is to fail with it: ``3,~BeforeHandling~whereAmI~fail``. It may be left out.

The name of whoever sends stands in the key, so that a router's access rules can bind it. What
passes on which shape of key, and with what right, stands in `FAMILIES`.
"""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from tca_bus._presence import PresentModule, Stage, TapWord
from tca_bus._rights import Right

EVERY_MESSAGE = ":"
"""Stands for every message in a presence key, where an asterisk would be a pattern."""

NO_NAMES = "-"
"""Stands for an empty list in a presence key, since a chunk may not be empty."""

MOST_TOKENS = 4096
"""Tokens whose reading is remembered: all modules of a process read the same ones, and often."""

_NOT_IN_CHUNK = re.compile(r"[^A-Za-z0-9._:-]")


class Traffic(enum.Enum):
    """How messages pass on a family of keys."""

    ASKED = enum.auto()
    """The sender gets, the receiver has a queryable and replies."""
    PUT = enum.auto()
    """The sender puts, the receiver subscribes."""
    PUBLISHED = enum.auto()
    """Central puts, and answers gets; receivers subscribe and get."""


@dataclass(frozen=True, slots=True)
class Family:
    """Keys of one shape, behind the realm.

    In ``shape`` the names ``{sender}``, ``{receiver}``, ``{owner}`` and ``{name}`` stand for
    what an access rule puts there. ``needs`` are the rights of which a receiver needs one, by
    ``{name}`` or, where there is an owner, by ``{owner}``, who needs none. A receiver with a
    chunk of its own declares everything below that chunk.
    """

    shape: str
    traffic: Traffic
    needs: tuple[Right, ...] = ()


FAMILIES = (
    Family("query/{receiver}/*/{name}/{sender}", Traffic.ASKED, (Right.SERVE,)),
    Family("call/{receiver}/*/{name}/{sender}", Traffic.PUT, (Right.SERVE,)),
    Family("answer/{receiver}/*/{sender}", Traffic.PUT),
    Family("inform/{name}/{sender}", Traffic.PUT, (Right.SERVE, Right.LISTEN)),
    Family("broadcast/{name}/{sender}", Traffic.PUT, (Right.LISTEN,)),
    Family("task/{owner}/*", Traffic.PUBLISHED, (Right.WATCH,)),
    Family("variable/{name}", Traffic.PUBLISHED, (Right.READ,)),
)
"""Everything that passes on the bus but presence and the policy itself."""


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

    def query_to_all(self, name: str, caller: str) -> str:
        """The key of a query to every module that is there."""
        return f"{self.realm}/query/*/*/{name}/{caller}"

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

    def policy(self, module: str = "") -> str:
        """Where the router tells a module who may do what; without one, whether it matters."""
        return f"{self.realm}/policy/{module}" if module else f"{self.realm}/policy"

    def all_presence(self) -> str:
        """The tokens of all modules."""
        return f"{self.realm}/presence/**"


@lru_cache(maxsize=4096)
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


@lru_cache(maxsize=MOST_TOKENS)
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
    words += [_tap_text(tap) for tap in module.taps]
    return ",".join([*words, module.stage] if module.stage else words)


def _with_more(module: PresentModule, words: list[str]) -> PresentModule:
    number, *rest = words
    stages = [word for word in rest if word[:1] not in {"+", "-", "~"}]
    return replace(
        module,
        number=int(number),
        resources=tuple(word[1:] for word in rest if word[:1] == "+"),
        requires=tuple(word[1:] for word in rest if word[:1] == "-"),
        stage=Stage(stages[0]) if stages else Stage.UNSAID,
        taps=tuple(_tap_of(word) for word in rest if word[:1] == "~"),
    )


def _tap_text(tap: TapWord) -> str:
    message = EVERY_MESSAGE if tap.message == "*" else tap.message
    return f"~{tap.condition}~{message}" + ("~fail" if tap.fails else "")


def _tap_of(word: str) -> TapWord:
    _, condition, message, *rest = word.split("~")
    return TapWord(condition, "*" if message == EVERY_MESSAGE else message, rest == ["fail"])
