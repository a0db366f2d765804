"""What ``rogue up`` and ``rogue demo`` refuse before they start anything."""

from __future__ import annotations

import asyncio
from typing import get_args

import pytest
from command_line import run_command

from navigate.cli import app as navigate
from navigate.messages import Belief, LocalizerName, Progress
from rogue.cli import _up, app
from rogue.cli._guard import office_policy
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, ConfigError, read_policy
from tca_bus._rights import Right
from xavier_sim.cli import app as xavier
from xavier_sim.messages import ProfileName


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


RANK = "def by_age(claim, now):\n    return now - claim.posted\n"


async def test_what_it_is_told_reaches_the_processes(tmp_path, monkeypatch):
    specs = []

    def launcher(wanted, bus, *, console):
        specs.extend(wanted)
        raise ConfigError("office", "seen", "no more")

    monkeypatch.setattr(_up, "Launcher", launcher)
    (tmp_path / "rank.py").write_text(RANK)
    rank = f"{tmp_path / 'rank.py'}:by_age"
    words = ["up", "--tray", "3", "--priority", rank, "--rules", "1998", "--level", "3"]
    words += ["--silent-people", "0.1", "--away", "0.2", "--missing-items", "0.3"]
    words += ["--profile", "hard", "--localizer", "pomdp", "--people-walking", "4", "--carts", "2"]
    words += ["--battery", "4", "--seed", "5", "--speed", "max", "--data", str(tmp_path)]
    assert "office is 'seen'" in (await run_command(app, *words)).err
    agent = arguments(specs, "rogue", app)
    assert (agent["planner"].tray, agent["planner"].priority) == (3, rank)
    assert (agent["planner"].rules, agent["planner"].level) == ("1998", 3)
    people = arguments(specs, "speech", xavier)
    assert (people["silent_people"], people["away"], people["missing_items"]) == (0.1, 0.2, 0.3)
    robot = arguments(specs, "xavier", xavier)
    world = robot["world"]
    assert (world.battery, world.seed, robot["speed"]) == (4.0, 5, "max")
    assert (world.profile, world.people_walking, world.carts) == ("hard", 4, 2)
    assert arguments(specs, "navigate", navigate)["localizer"] == "pomdp"


@pytest.mark.parametrize("profile", get_args(ProfileName))
@pytest.mark.parametrize("localizer", get_args(LocalizerName))
def test_every_robot_and_localizer_is_known_to_those_who_have_it(profile, localizer, tmp_path):
    options = OfficeOptions(data=tmp_path, profile=profile, localizer=localizer)
    specs = office_specs(options, BusOptions())
    assert arguments(specs, "xavier", xavier)["world"].profile == profile
    assert arguments(specs, "navigate", navigate)["localizer"] == localizer


async def test_a_priority_that_is_none_is_told_before_anything_starts(tmp_path):
    ran = await run_command(app, "up", "--priority", "nowhere:none", "--data", str(tmp_path))
    assert ran.code == 2
    assert "--priority is 'nowhere:none', expected MODULE:NAME" in ran.err


def arguments(specs, name, app):
    """What the command of a process is called with, as it reads its own words."""
    (spec,) = [spec for spec in specs if spec.name == name]
    _, bound, _ = app.parse_args(list(spec.argv[3:]), exit_on_error=False, print_error=False)
    return bound.arguments


@pytest.mark.parametrize("told", [Belief, Progress])
def test_the_policy_of_the_office_lets_a_robot_record_what_its_navigator_tells(told):
    policy = read_policy(office_policy())
    assert policy.rule("navigate", Right.SEND, told.wire_name)
    assert policy.rule("xavier", Right.LISTEN, told.wire_name)
    assert not policy.rule("stranger", Right.LISTEN, told.wire_name)
