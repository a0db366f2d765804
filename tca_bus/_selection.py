"""Which keys of a realm are meant, as a user names them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import zenoh

from tca_bus._errors import ConfigError
from tca_bus._options import CHUNK_PATTERN

KINDS = ("inform", "broadcast", "task", "presence")
"""Words that stand for all keys of a kind."""

EXPECTED = (
    "a message's name, one of inform, broadcast, task and presence, or a key expression without "
    "the realm such as broadcast/**"
)


@dataclass(frozen=True, slots=True)
class Selection:
    """Key expressions without the realm; a key is selected when any of them matches it."""

    expressions: tuple[str, ...] = ("**",)

    @classmethod
    def parse(cls, words: Sequence[str]) -> Selection:
        """Read what a user named; nothing means everything.

        Raises:
            ConfigError: It is no name, kind or key expression, or about queries.
        """
        found = [expression for word in words for expression in _expressions(word)]
        return cls(tuple(_without_included(found))) if found else cls()

    def includes(self, key: str) -> bool:
        """Whether a key without its realm is selected."""
        return self.first(key) is not None

    def first(self, key: str) -> int | None:
        """The number of the first expression that matches a key."""
        concrete = zenoh.KeyExpr(key)
        for number, expression in enumerate(self.expressions):
            if zenoh.KeyExpr(expression).intersects(concrete):
                return number
        return None


def _expressions(word: str) -> list[str]:
    if word in KINDS:
        return [f"{word}/**"]
    if "/" not in word and "*" not in word:
        if not CHUNK_PATTERN.fullmatch(word):
            raise ConfigError("KEY", word, EXPECTED)
        return [f"{kind}/{word}/*" for kind in ("inform", "broadcast")]
    try:
        expression = str(zenoh.KeyExpr.autocanonize(word))
    except zenoh.ZError:
        raise ConfigError("KEY", word, EXPECTED) from None
    if expression.split("/", maxsplit=1)[0] == "query":
        raise ConfigError("KEY", word, "no query: those go to one module and cannot be listened to")
    return [expression]


def _without_included(expressions: Sequence[str]) -> list[str]:
    """Each expression once, without those that another one includes."""
    unique = list(dict.fromkeys(expressions))
    return [
        one
        for one in unique
        if not any(
            zenoh.KeyExpr(other).includes(zenoh.KeyExpr(one)) for other in unique if other != one
        )
    ]
