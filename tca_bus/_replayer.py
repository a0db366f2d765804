"""Replays a recording: puts on the bus what passed, at its own pace or another."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice

import zenoh

from tca_bus._errors import ConfigError, RefusedError
from tca_bus._module import Module
from tca_bus._recording import PRESENCE, Passed
from tca_bus._selection import Selection

READ_AHEAD = 256
"""Messages that are read from the file at a time."""


@dataclass(frozen=True, slots=True)
class Remap:
    """Replaces the beginnings of keys, the first that fits; ``rules`` are pairs of old and new."""

    rules: tuple[tuple[str, str], ...] = ()

    @classmethod
    def parse(cls, words: Sequence[str]) -> Remap:
        """Read rules such as ``broadcast/pose=broadcast/oldPose``.

        Raises:
            ConfigError: One is no rule, or makes no key.
        """
        return cls(tuple(_rule(word) for word in words))

    def apply(self, key: str) -> str:
        """The key under which to replay what passed under ``key``."""
        for old, new in self.rules:
            if key == old or key.startswith(f"{old}/"):
                return new + key[len(old) :]
        return key


def _rule(word: str) -> tuple[str, str]:
    old, sign, new = word.partition("=")
    old, new = old.strip("/"), new.strip("/")
    expected = "OLD=NEW, two beginnings of keys without the realm and without wildcards"
    if not sign or not old or "*" in word:
        raise ConfigError("--remap", word, expected)
    try:
        zenoh.KeyExpr(new)
    except zenoh.ZError:
        raise ConfigError("--remap", word, expected) from None
    return old, new


def parse_speed(text: str) -> float:
    """Read how many times as fast as it was to replay; infinite for ``max``.

    Raises:
        ConfigError: It is neither a number above zero nor ``max``.
    """
    if text == "max":
        return math.inf
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not 0 < speed < math.inf:
        raise ConfigError("--speed", text, "a number above zero, or max")
    return speed


@dataclass
class Replayer:
    """Puts messages on the realm of an open module, under the names of those who sent them.

    ``skip`` is how many seconds of the beginning are left out. Tokens of modules are replayed
    only with ``with_presence``: others call a module whose token they see.
    """

    module: Module
    selection: Selection = field(default_factory=Selection)
    remap: Remap = field(default_factory=Remap)
    speed: float = 1.0
    skip: float = 0.0
    with_presence: bool = False
    sent: int = 0
    _tokens: dict[str, zenoh.LivelinessToken] = field(default_factory=dict)

    async def run(self, recording: Iterable[Passed]) -> None:
        """Replay until the end of the recording.

        Raises:
            RecordingError: The recording is damaged; what comes before was replayed.
            RefusedError: There is a policy: nobody sends in the names of others.
        """
        if self.module.permissions.policy is not None:
            why = "it sends in the names of others, and the router has a policy; use one without"
            raise RefusedError("a replay", why)
        messages = iter(recording)
        begin, first = asyncio.get_running_loop().time(), None
        try:
            while batch := await asyncio.to_thread(_some, messages):
                for passed in batch:
                    first = passed.seen if first is None else first
                    offset = (passed.seen - first) / 1e9 - self.skip
                    if offset < 0 and not self._is_token(passed):
                        continue
                    await self._reach(begin + max(offset, 0.0) / self.speed)
                    begin += await self._outage()
                    self._put(passed)
                    await asyncio.sleep(0)
        finally:
            for token in self._tokens.values():
                self.module.core.session.undeclare(token)

    async def _reach(self, due: float) -> None:
        left = due - asyncio.get_running_loop().time()
        if left > 0:
            await asyncio.sleep(left)

    async def _outage(self) -> float:
        """Wait for the router; gives the wall seconds that it was away."""
        clock = asyncio.get_running_loop().time
        since = clock()
        if not self.module.is_connected:
            await self.module.connected()
        return clock() - since

    def _is_token(self, passed: Passed) -> bool:
        return passed.topic == PRESENCE

    def _put(self, passed: Passed) -> None:
        if not self.selection.includes(passed.key):
            return
        key = f"{self.module.options.realm}/{self.remap.apply(passed.key)}"
        if self._is_token(passed):
            self._put_token(key, is_gone=passed.is_gone)
            return
        session = self.module.core.session.zenoh
        attachment = passed.attachment
        if passed.is_gone:
            session.delete(key, attachment=attachment)
        else:
            session.put(
                key,
                passed.payload.data,
                encoding=passed.payload.encoding,
                attachment=attachment,
                congestion_control=zenoh.CongestionControl.BLOCK,
            )
        self.sent += 1

    def _put_token(self, key: str, *, is_gone: bool) -> None:
        if not self.with_presence:
            return
        known = self._tokens.pop(key, None)
        if known is not None:
            self.module.core.session.undeclare(known)
        if not is_gone:
            self._tokens[key] = self.module.core.session.declare_token(key)
        self.sent += 1


def _some(messages: Iterator[Passed]) -> list[Passed]:
    """The next messages; what the recording ends with comes out when these are done."""
    return list(islice(messages, READ_AHEAD))
