"""What stands in files of PRODIGY's users around the language itself."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.prodigy._forms import as_form, fail, first, head
from rogue.prodigy._reader import Form, Node, Word

SKIPPED = frozenset(
    (
        *("declaim", "defconstant", "defmacro", "defparameter", "defstruct", "defun", "defvar"),
        *("export", "format", "import", "in-package", "proclaim", "provide", "pset", "require"),
        *("set-running-mode", "setf", "setq", "use-package"),
    )
)
"""Lisp that changes nothing in what is read: settings, and functions that Python replaces."""

REFUSED = {
    "event": "no exogenous events, which this planner does not have",
    "load": "the text of that file here, since nothing else is loaded",
}
"""What cannot be left out without changing what the text says."""


def without_lisp(nodes: Iterable[Node], sections: tuple[str, ...]) -> list[Form]:
    """Return the forms that begin with one of ``sections``, without the Lisp among them.

    Raises:
        PdlError: For anything that is neither, or that must not be left out.
    """
    forms: list[Form] = []
    for node in nodes:
        form = as_form(node, "'('")
        word = head(form)
        if word in REFUSED:
            fail(first(form), REFUSED[word])
        if word in SKIPPED and not _holds_any(form, sections):
            continue
        if word not in sections:
            fail(first(form), "one of " + ", ".join(sections), (*sections, *REFUSED))
        forms.append(form)
    return forms


def _holds_any(form: Form, sections: tuple[str, ...]) -> bool:
    inner = (item for item in form.items if isinstance(item, Form))
    return any(head(item) in sections for item in inner)


def unquoted(word: Word) -> str:
    """Return a name without the package before it: ``p4::diff`` is ``diff``."""
    return word.text.rpartition(":")[2] or word.text
