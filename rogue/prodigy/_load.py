"""Loading of domains and problems from files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._functions import Function
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._parse_domain import parse_domain
from rogue.prodigy._parse_problem import parse_problem
from rogue.prodigy._problem import Problem
from rogue.prodigy._task import Task
from rogue.prodigy._text import read_text
from rogue.prodigy.pddl import read_domain, read_problem

_PDDL = re.compile(r"(?:\s|;[^\n]*\n)*\(\s*define\b", re.IGNORECASE)


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
        read_text(path), file=str(path), functions=functions, meta_predicates=meta_predicates
    )


def load_problem(path: str | Path, domain: Domain) -> Problem:
    """Read a problem of ``domain`` from a file; see ``parse_problem``.

    Raises:
        PdlError: If the text is no valid problem, with line and column.
        OSError: If the file cannot be read.
    """
    return parse_problem(read_text(path), domain, file=str(path))


def load_task(
    domain: str | Path,
    problem: str | Path,
    *,
    functions: Mapping[str, Function] | None = None,
    meta_predicates: Mapping[str, MetaPredicate] | None = None,
) -> Task:
    """Read a domain and a problem of it, both in PRODIGY's language or both in PDDL.

    Args:
        domain: A file; its text says which language it is in.
        problem: A file in the same language.
        functions: As for ``parse_domain``; PDDL has none.
        meta_predicates: As for ``parse_domain``; PDDL has none.

    Raises:
        PdlError: If a text is not valid, with line and column.
        OSError: If a file cannot be read.
    """
    about, what = read_text(domain), read_text(problem)
    if is_pddl(about) != is_pddl(what):
        found = _language(what)
        expected = f"{_language(about)}, in which {domain} is written"
        raise PdlError(Position(str(problem), 1, 1), found, expected)
    if is_pddl(about):
        return read_problem(what, read_domain(about, file=str(domain)), file=str(problem))
    known = parse_domain(
        about, file=str(domain), functions=functions, meta_predicates=meta_predicates
    )
    return Task(parse_problem(what, known, file=str(problem)))


def is_pddl(text: str) -> bool:
    """Say whether a text is in PDDL, by its first word; any other is taken as PRODIGY's."""
    return _PDDL.match(text) is not None


def _language(text: str) -> str:
    return "PDDL" if is_pddl(text) else "PRODIGY's language"
