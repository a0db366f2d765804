"""The flags that every command has, and the bus options they stand for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter
from pydantic import SecretStr

from tca_bus._options import BusOptions

BUS_GROUP = Group("Bus", sort_key=100)

LogLevel = Literal["debug", "info", "warning", "error"]


@Parameter(name="*", group=BUS_GROUP)
@dataclass(frozen=True, kw_only=True)
class BusFlags:
    """The shared flags of all command lines.

    Take it as a keyword-only parameter ``flags: BusFlags = DEFAULT_FLAGS``. A value comes from
    the command line, else from the environment, else from the file named by ``--config``.
    """

    connect: Annotated[str, Parameter(env_var="TCA_CONNECT")] = "tcp/127.0.0.1:7447"
    """Zenoh endpoint of the router."""
    realm: Annotated[str, Parameter(env_var="TCA_REALM")] = "xavier"
    """First part of all keys: one realm per robot."""
    config: Annotated[Path | None, Parameter(env_var="TCA_CONFIG")] = None
    """TOML file with values for flags; those of one command in a table [TOOL.COMMAND]."""
    json: Annotated[bool, Parameter(negative="", env_var="TCA_JSON")] = False
    """Print JSON instead of tables."""
    log_level: Annotated[LogLevel, Parameter(env_var="TCA_LOG_LEVEL")] = "info"
    """Least level of what is logged on standard error."""
    verbose: Annotated[bool, Parameter(name=["--verbose", "-v"], negative="")] = False
    """Log everything, same as --log-level debug."""
    clock: Annotated[Literal["wall", "sim"], Parameter(env_var="TCA_CLOCK")] = "wall"
    """Time base of what waits for the world."""
    keys: Annotated[Path | None, Parameter(env_var="TCA_KEYS")] = None
    """Folder of 'tca keys' with what this process joins a guarded router with."""
    user: Annotated[str | None, Parameter(env_var="TCA_USER")] = None
    """Name with which to join a router that asks for one; without it that of --keys."""
    password: Annotated[str | None, Parameter(env_var="TCA_PASSWORD")] = None
    """Password of --user; better in the environment, where others do not see it."""
    links: Annotated[Literal["router", "direct"], Parameter(env_var="TCA_LINKS")] = "router"
    """How messages travel: through the router, or directly between modules of this host."""

    @property
    def level(self) -> str:
        """The log level in force."""
        return "debug" if self.verbose else self.log_level


DEFAULT_FLAGS = BusFlags()


def bus_options(flags: BusFlags) -> BusOptions:
    """Turn the flags into the options of a `tca_bus.Module`.

    Raises:
        ConfigError: the realm, the endpoint or the user cannot be used.
    """
    return BusOptions(
        connect=flags.connect,
        realm=flags.realm,
        clock=flags.clock,
        keys=flags.keys,
        user=flags.user,
        password=None if flags.password is None else SecretStr(flags.password),
        links=flags.links,
    )
