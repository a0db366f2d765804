"""``docs/navigate.md`` names every message and every failure."""

from __future__ import annotations

import re
from pathlib import Path

from navigate import messages
from navigate.messages import NavigationFailure
from tca_bus import Message

TEXT = (Path(__file__).parents[2] / "docs" / "navigate.md").read_text(encoding="utf-8")


def table(heading):
    """The first two cells of each row of the table below a heading."""
    section = TEXT.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0]
    return dict(re.findall(r"^\| `(\w+)` +\| ([^|]+?) +\|", section, re.MULTILINE))


def test_every_message_is_listed_with_its_class():
    types = [getattr(messages, name) for name in messages.__all__]
    own = [one for one in types if isinstance(one, type) and issubclass(one, Message)]
    assert table("Messages") == {one.wire_name: one.message_class.value for one in own}


def test_every_failure_is_listed():
    assert set(table("How a drive ends")) == {failure.value for failure in NavigationFailure}
