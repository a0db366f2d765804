"""``tca router``: the process that all others connect to."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tca_bus._credentials import Auth
from tca_bus._errors import ConfigError
from tca_bus._logs import configure_logging
from tca_bus._policy_file import read_policy
from tca_bus._router import LINK_TIMEOUT, Guard, Router
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags


async def router(
    *,
    policy: Annotated[Path | None, Parameter(env_var="TCA_POLICY")] = None,
    auth: Auth | None = None,
    link: Annotated[list[str] | None, Parameter(env_var="TCA_LINK", negative="")] = None,
    link_timeout: float = LINK_TIMEOUT,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the Zenoh router, which all processes connect to.

    It listens at --connect; tcp/127.0.0.1:0 picks a free port, which the log names. With --keys
    it lets in only who has keys of that folder's authority.

    Parameters
    ----------
    policy
        Policy file that says who may do what on --realm; without it, who is let in may do all.
    auth
        How modules prove who they are; certificate on tls and quic endpoints, else password.
    link
        Endpoint of a router on another host, which makes one bus with this one; may be given
        more than once. Either may start first, and the link is made again when it was cut.
    link_timeout
        Seconds that one try to reach such a router may take. More for links with round trips
        beyond 100 ms; a healed link is back within this and half a second.
    """
    configure_logging("router", level=flags.level, json=flags.json)
    guard = _guard(flags, policy, auth)
    async with Router(flags.connect, guard=guard, links=link or (), link_timeout=link_timeout):
        await asyncio.get_running_loop().create_future()


def _guard(flags: BusFlags, policy: Path | None, auth: Auth | None) -> Guard | None:
    read = None if policy is None else read_policy(policy)
    if flags.keys is not None:
        return Guard(flags.keys, read, flags.realm, auth)
    if policy is not None or auth is not None:
        expected = "a folder of 'tca keys': without it the router cannot know who sends"
        raise ConfigError("--keys", None, expected)
    return None
