"""``navigate where --watch`` while the navigator comes and goes."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json

import pytest
from navigate_office import running

from navigate.cli import _drawing as drawing
from navigate.cli import _watching
from navigate.maps import Floor, load_plan
from navigate.messages import ShowMap, ShowOutlook
from navigate.navigator import Navigator
from navigate.reporting import outlook
from navigate.service import NavigateService
from tca_bus import Module
from tca_bus.testing import bus, eventually


def test_an_old_picture_in_the_terminal_says_first_how_old_it_is_and_why():
    floor = Floor(load_plan())
    scene = drawing.Scene(outlook(Navigator(floor), None, None, ""), floor.plan, None)
    new = _watching.Shot(scene)
    old = _watching.Shot(scene, age=12.3, why="no module handles 'navigateOutlook'.")
    fresh, stale = (_watching._framed(shot, 60, 20).split("\n") for shot in (new, old))
    said = "no answer, the picture is 12 s old: no module handles 'navigateOutlook'."
    assert stale[0] == said[:60]
    assert "no answer" not in "".join(fresh)
    assert len(stale) <= len(fresh) <= 20


@pytest.mark.bus
async def test_it_says_that_nobody_answers_and_that_somebody_does_again(monkeypatch):
    monkeypatch.setattr(_watching, "PERIOD", 0.05)
    monkeypatch.setattr(_watching, "LEAST", 0.0)
    out, err, looks = io.StringIO(), io.StringIO(), []

    async def look(*arguments):
        looks.append(arguments)
        return await drawing.look(*arguments)

    monkeypatch.setattr(_watching, "look", look)

    def lines():
        return out.getvalue().count("\n")

    async with bus() as options, Module("asker", options=options) as asker:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            async with running(NavigateService(Navigator(Floor(load_plan())), options).run()):
                await asker.wait_for(ShowOutlook, ShowMap, timeout=10)
                watching = asyncio.ensure_future(_watching.watch_robot(asker, None, json=True))
                await eventually(lambda: lines() > 2)
            await eventually(lambda: "no answer, the picture is" in err.getvalue())
            silent, asked = lines(), len(looks)
            await eventually(lambda: len(looks) > asked + 2)
            assert lines() == silent
            async with running(NavigateService(Navigator(Floor(load_plan())), options).run()):
                await eventually(lambda: "answers again" in err.getvalue(), timeout=20)
                await eventually(lambda: lines() > silent)
                watching.cancel()
    assert err.getvalue().count("\n") == 2
    assert "belief" in json.loads(out.getvalue().splitlines()[0])
