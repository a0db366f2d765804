"""The office of ``rogue up --secure``: keys for all, and a policy."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from tca_bus import BusOptions, ConfigError
from tca_bus.launcher import provide_keys

SECURE_ENDPOINT = "tls/127.0.0.1:7447"


SECURITY_GROUP = Group("Security", sort_key=40)


@Parameter(name="*", group=SECURITY_GROUP)
@dataclass(frozen=True, kw_only=True)
class SecurityFlags:
    """Who is let in."""

    secure: Annotated[bool, Parameter(negative="")] = False
    """Encrypt, let in only who has keys, and only to what the policy allows. Keys are made in the
    folder "keys" of --data, or of --keys, and the router listens on tls."""
    policy: Annotated[Path | None, Parameter(env_var="TCA_POLICY")] = None
    """Policy file that says who may do what; with --secure the office's own if not given."""

    def applied(self, bus: BusOptions, data: Path) -> tuple[BusOptions, Path | None]:
        """How all join the router, and the policy that it goes by.

        Raises:
            ConfigError: As `guarded`.
        """
        if not self.secure:
            return bus, self.policy
        policy = self.policy or office_policy()
        return guarded(bus, data, policy), policy


SECURITY = SecurityFlags()


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
