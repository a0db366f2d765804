"""What docs/security.md says is so."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from security_office import REALM, make_keys

from tca_bus import BusOptions, Guard, Module, Permissions, RefusedError, Right, Router, read_policy
from tca_bus._policy import Policy

TEXT = (Path(__file__).parents[2] / "docs" / "security.md").read_text(encoding="utf-8")


@pytest.fixture
def policy_file(tmp_path):
    (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    path = tmp_path / "policy.toml"
    path.write_text(example)
    return path


def test_the_example_is_read_and_uses_every_kind_of_table(policy_file):
    policy = read_policy(policy_file)
    assert set(tomllib.loads(policy_file.read_text())) == set(Policy.model_fields)
    assert policy.rule("planner", Right.KILL, "navigateToG", owner="tca-12")
    assert not policy.rule("planner", Right.KILL, "drive", owner="tca")
    assert policy.rule("guard", Right.TAP, "navigateToG", owner="planner")
    assert policy.rule("guard", Right.LISTEN, "robotState", owner="robot")
    assert not policy.rule("planner", Right.SEND, "drive")
    assert policy.rule("tca-1", Right.SEND, "drive")


def test_the_table_of_rights_is_complete():
    rows = re.findall(r"^\| `(\w+)` +\|.*\| ([\w@]+) +\|$", TEXT, re.MULTILINE)
    assert [name for name, _ in rows] == [right.value for right in Right]
    owned = {name for name, pattern in rows if "@" in pattern}
    assert owned == {right.value for right in Right if right.is_owned}


@pytest.mark.bus
async def test_the_example_is_in_force_behind_a_router(policy_file, tmp_path):
    policy = read_policy(policy_file)
    keys = make_keys(tmp_path / "keys", *policy.modules)
    async with Router("tls/127.0.0.1:0", guard=Guard(keys, policy, REALM)) as router:
        options = BusOptions(connect=router.endpoint, realm=REALM, keys=keys)
        async with Module("planner", options=options) as planner:
            assert isinstance(planner.permissions, Permissions)
            with pytest.raises(RefusedError, match="does not let module 'planner' send 'drive'"):
                await planner.query_json("drive", {})
