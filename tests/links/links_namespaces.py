"""Two network namespaces joined by a switch; links can be cut. Needs Linux, ``ip`` and root."""

from __future__ import annotations

import secrets
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

NEAR_ADDRESS = "10.213.0.1"
FAR_ADDRESS = "10.213.0.2"

Cut = Literal["down", "unplugged", "silent"]
"""How a link is cut: the near end is switched off; both ends see that they have no carrier; packets
vanish on the way, and both ends have their carrier."""


class NoNamespacesError(Exception):
    """Network namespaces cannot be made here."""


def ip(*arguments: str) -> None:
    """Run ``ip``.

    Raises:
        NoNamespacesError: It is not installed, or may not do this.
    """
    try:
        done = subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise NoNamespacesError("iproute2 is not installed") from error
    if done.returncode:
        raise NoNamespacesError(f"ip {' '.join(arguments)}: {done.stderr.strip()}")


@dataclass(frozen=True)
class Cable:
    """Two namespaces, ``near`` at 10.213.0.1 and ``far`` at 10.213.0.2, and the switch between."""

    near: str
    far: str
    switch: str

    def cut(self, how: Cut = "down") -> None:
        """No packet passes from here on, and no process is told."""
        if how == "down":
            ip("-n", self.near, "link", "set", "cable", "down")
        elif how == "unplugged":
            self._ports("down")
        else:
            ip("-n", self.switch, "link", "set", "far", "nomaster")

    def heal(self, how: Cut = "down") -> None:
        """Packets pass again."""
        if how == "down":
            ip("-n", self.near, "link", "set", "cable", "up")
        elif how == "unplugged":
            self._ports("up")
        else:
            ip("-n", self.switch, "link", "set", "far", "master", "switch")

    def inside(self, side: str, *command: str) -> tuple[str, ...]:
        """The command as it is run in the namespace of one side."""
        return ("ip", "netns", "exec", self.near if side == "near" else self.far, *command)

    def _ports(self, state: str) -> None:
        for port in ("near", "far"):
            ip("-n", self.switch, "link", "set", port, state)


@contextmanager
def cable() -> Iterator[Cable]:
    """Make the namespaces; they are removed with the block.

    Raises:
        NoNamespacesError: They cannot be made.
    """
    name = f"tca-{secrets.token_hex(3)}"
    made = Cable(f"{name}-near", f"{name}-far", f"{name}-switch")
    try:
        for namespace in (made.near, made.far, made.switch):
            ip("netns", "add", namespace)
        ip("-n", made.switch, "link", "add", "switch", "type", "bridge")
        ip("-n", made.switch, "link", "set", "switch", "up")
        _plug_in(made, "near", made.near, NEAR_ADDRESS)
        _plug_in(made, "far", made.far, FAR_ADDRESS)
        yield made
    finally:
        for namespace in (made.near, made.far, made.switch):
            subprocess.run(["ip", "netns", "delete", namespace], capture_output=True, check=False)


def _plug_in(made: Cable, port: str, namespace: str, address: str) -> None:
    ends = ("cable", "netns", namespace, "type", "veth", "peer", "name", port)
    ip("link", "add", *ends, "netns", made.switch)
    ip("-n", made.switch, "link", "set", port, "master", "switch")
    ip("-n", made.switch, "link", "set", port, "up")
    ip("-n", namespace, "address", "add", f"{address}/24", "dev", "cable")
    ip("-n", namespace, "link", "set", "lo", "up")
    ip("-n", namespace, "link", "set", "cable", "up")
