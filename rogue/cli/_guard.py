"""The office of ``rogue up --secure``: keys for all, and a policy."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from tca_bus import BusOptions, ConfigError
from tca_bus.launcher import provide_keys

SECURE_ENDPOINT = "tls/127.0.0.1:7447"


def office_policy() -> Path:
    """The policy file of the office."""
    return Path(str(resources.files("rogue") / "policy.toml"))


def guarded(bus: BusOptions, data: Path, policy: Path) -> BusOptions:
    """The options with which all join a guarded router; makes the keys that are missing.

    They lie in the folder ``keys`` of ``data`` unless the options name another.

    Raises:
        ConfigError: The endpoint is not encrypted, or the keys or the policy cannot be used.
    """
    connect = SECURE_ENDPOINT if bus.connect == BusOptions().connect else bus.connect
    if not connect.startswith(("tls/", "quic/")):
        raise ConfigError("--connect", bus.connect, "tls/HOST:PORT, with --secure")
    keys = bus.keys or data / "keys"
    provide_keys(keys, policy)
    return bus.model_copy(update={"connect": connect, "keys": keys})
