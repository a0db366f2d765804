"""Two network namespaces joined by a cable that can be cut; needs Linux, ``ip`` and root."""

from __future__ import annotations

import secrets
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

NEAR_ADDRESS = "10.213.0.1"
FAR_ADDRESS = "10.213.0.2"


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
    """Two namespaces, ``near`` at 10.213.0.1 and ``far`` at 10.213.0.2, and the link between."""

    near: str
    far: str

    def cut(self) -> None:
        """No packet passes from here on, and nobody is told."""
        ip("-n", self.near, "link", "set", "cable", "down")

    def heal(self) -> None:
        """Packets pass again."""
        ip("-n", self.near, "link", "set", "cable", "up")

    def inside(self, side: str, *command: str) -> tuple[str, ...]:
        """The command as it is run in the namespace of one side."""
        return ("ip", "netns", "exec", self.near if side == "near" else self.far, *command)


@contextmanager
def cable() -> Iterator[Cable]:
    """Make both namespaces; they are removed with the block.

    Raises:
        NoNamespacesError: They cannot be made.
    """
    name = f"tca-{secrets.token_hex(3)}"
    made = Cable(f"{name}-near", f"{name}-far")
    try:
        ip("netns", "add", made.near)
        ip("netns", "add", made.far)
        ends = ("cable", "netns", made.near, "type", "veth", "peer", "name", "cable")
        ip("link", "add", *ends, "netns", made.far)
        for side, address in ((made.near, NEAR_ADDRESS), (made.far, FAR_ADDRESS)):
            ip("-n", side, "address", "add", f"{address}/24", "dev", "cable")
            ip("-n", side, "link", "set", "lo", "up")
            ip("-n", side, "link", "set", "cable", "up")
        yield made
    finally:
        for side in (made.near, made.far):
            subprocess.run(["ip", "netns", "delete", side], capture_output=True, check=False)
