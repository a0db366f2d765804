"""What ``rogue up`` and ``rogue demo`` refuse before they start anything."""

from __future__ import annotations

import asyncio

import pytest
from command_line import run_command

from rogue.cli import app


@pytest.mark.parametrize(
    "words",
    [
        ("up", "--seed", "-1"),
        ("up", "--silence", "2"),
        ("up", "--speed", "0"),
        ("up", "--data", "/dev/null/x"),
        ("demo", "--seed", "-1"),
        ("demo", "--data", "/dev/null/x"),
    ],
)
async def test_what_cannot_be_is_told_before_anything_starts(words: tuple[str, ...], monkeypatch):
    async def start(*arguments, **options):
        raise AssertionError(f"it starts {arguments}")

    monkeypatch.setattr(asyncio, "create_subprocess_exec", start)
    ran = await run_command(app, *words, TCA_CONNECT="tcp/127.0.0.1:1", TCA_REALM="test")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith("error: ")
    assert words[1] in ran.err
