"""Loading of domains and problems from files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._functions import Function
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._parse_domain import parse_domain
from rogue.prodigy._parse_problem import parse_problem
from rogue.prodigy._problem import Problem


def load_domain(
    path: str | Path,
    *,
    functions: Mapping[str, Function] | None = None,
    meta_predicates: Mapping[str, MetaPredicate] | None = None,
) -> Domain:
    """Read a domain from a file; see ``parse_domain``.

    Raises:
        PdlError: If the text is no valid domain, with line and column.
        OSError: If the file cannot be read.
    """
    return parse_domain(
        _text(path), file=str(path), functions=functions, meta_predicates=meta_predicates
    )


def load_problem(path: str | Path, domain: Domain) -> Problem:
    """Read a problem of ``domain`` from a file; see ``parse_problem``.

    Raises:
        PdlError: If the text is no valid problem, with line and column.
        OSError: If the file cannot be read.
    """
    return parse_problem(_text(path), domain, file=str(path))


def _text(path: str | Path) -> str:
    data = Path(path).read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        column = error.start - before.rfind(b"\n")
        position = Position(str(path), before.count(b"\n") + 1, column)
        raise PdlError(position, f"byte {data[error.start]:#04x}", "text in UTF-8") from None
