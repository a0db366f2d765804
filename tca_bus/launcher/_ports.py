"""A port for a router that is still to be started."""

from __future__ import annotations

import random
import socket

from tca_bus.launcher._errors import NoPortError

LOWEST, HIGHEST = 20_000, 32_000
"""Below the ports that systems give to outgoing connections by themselves: one of those may be gone
before the process that was to listen there has started."""

TRIES = 100


def free_port(host: str = "127.0.0.1") -> int:
    """Find a TCP port at which nobody listens, and that hardly anybody takes by chance.

    Raises:
        NoPortError: There is none to be found.
    """
    for _ in range(TRIES):
        port = random.randint(LOWEST, HIGHEST)
        with socket.socket() as probe:
            try:
                probe.bind((host, port))
            except OSError:
                continue
            return port
    raise NoPortError(host, TRIES)
