"""A folder of keys: where what lies, and which of them a module joins with.

::

    authority.pem                  the authority's certificate; every process needs it
    authority.key                  its private key; only who makes keys needs it
    router/certificate.pem, private.key
    modules/NAME/certificate.pem, private.key, password
    users.txt                      NAME:password of all; only the router needs it

A module NAME joins with the keys of NAME. A tool that adds a number to its name, such as
``tca-4711``, joins with the longest name that it begins with before a ``-``.
"""

from __future__ import annotations

import re
import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from tca_bus._errors import ConfigError, did_you_mean
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN

LONGEST_COMMON_NAME = 64
"""Letters of a name in a certificate, after RFC 5280."""

_OTHERS_MAY_READ = stat.S_IRWXG | stat.S_IRWXO

_NUMBER = re.compile(r"-\d+$")

_PASSWORD_LINE = re.compile(r"^(?P<name>[^:\s]+):(?P<password>\S+)$")


@dataclass(frozen=True, slots=True)
class KeyPair:
    """Where a certificate and its private key lie."""

    certificate: Path
    private_key: Path


@dataclass(frozen=True, slots=True)
class Keyring:
    """The places in a folder of keys; none of them need be there."""

    folder: Path

    @property
    def authority(self) -> KeyPair:
        """The authority that has signed all others."""
        return KeyPair(self.folder / "authority.pem", self.folder / "authority.key")

    @property
    def router(self) -> KeyPair:
        """The router's."""
        return _pair(self.folder / "router")

    @property
    def users(self) -> Path:
        """The users and passwords that the router takes."""
        return self.folder / "users.txt"

    def module(self, name: str) -> KeyPair:
        """Those of one module."""
        return _pair(self.folder / "modules" / name)

    def password_file(self, name: str) -> Path:
        """Where the password of one module lies."""
        return self.folder / "modules" / name / "password"

    def names(self) -> list[str]:
        """The modules that have a certificate or a password here."""
        return sorted(entry.name for entry in (self.folder / "modules").glob("*") if entry.is_dir())

    def owner_of(self, module: str) -> str:
        """The name whose keys a module joins with.

        Raises:
            ConfigError: There are none for it.
        """
        known = self.names()
        owner = owner_among(module, known)
        if owner is None:
            have = ", ".join(known) or "none"
            expected = f"a folder with the keys of module {module!r}; it has those of: {have}."
            plain = _NUMBER.sub("", module)
            more = did_you_mean(plain, known) or f" 'tca keys add' makes them for {plain!r}."
            raise ConfigError("--keys", str(self.folder), expected + more)
        return owner

    def check_private(self, path: Path) -> Path:
        """Give back a file that is there and that its owner alone may read.

        Raises:
            ConfigError: It is not there, or others may read it.
        """
        try:
            mode = path.stat().st_mode
        except OSError as error:
            raise ConfigError("--keys", str(self.folder), _expected(path, error)) from error
        if mode & _OTHERS_MAY_READ:
            expected = f"a folder whose {path.name} nobody else may read: chmod 600 {path}"
            raise ConfigError("--keys", str(self.folder), expected)
        return path

    def check_public(self, path: Path) -> Path:
        """Give back a file that is there.

        Raises:
            ConfigError: It is not there.
        """
        if not path.is_file():
            raise ConfigError("--keys", str(self.folder), f"a folder of 'tca keys', with {path}")
        return path

    def read_password(self, owner: str) -> str:
        """The password of a module.

        Raises:
            ConfigError: It has none, or others may read it.
        """
        return self.check_private(self.password_file(owner)).read_text(encoding="utf-8").strip()

    def read_users(self) -> dict[str, str]:
        """The passwords that the router takes, by name.

        Raises:
            ConfigError: There is no such file, others may read it, or a line is no entry.
        """
        path = self.check_private(self.users)
        found: dict[str, str] = {}
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            match = _PASSWORD_LINE.fullmatch(line)
            if match is None:
                raise ConfigError(f"{path}, line {number}", "...", "NAME:PASSWORD")
            found[match["name"]] = match["password"]
        return found


def owner_among(module: str, names: Iterable[str]) -> str | None:
    """The name that a module goes by: its own, or the longest that it extends by ``-``."""
    fitting = [name for name in names if is_owned(module, name)]
    return max(fitting, key=len, default=None)


def is_owned(module: str, owner: str) -> bool:
    """Whether a module may join with the keys of ``owner``."""
    return module == owner or module.startswith(f"{owner}-")


def check_name(name: str) -> str:
    """Give back a name that a certificate can have.

    Raises:
        ConfigError: It is none.
    """
    if not CHUNK_PATTERN.fullmatch(name) or len(name) > LONGEST_COMMON_NAME:
        expected = CHUNK_EXPECTED.replace("100", str(LONGEST_COMMON_NAME))
        raise ConfigError("name of a module", name, expected)
    return name


def _pair(folder: Path) -> KeyPair:
    return KeyPair(folder / "certificate.pem", folder / "private.key")


def _expected(path: Path, error: OSError) -> str:
    return f"a folder of 'tca keys', with {path} ({error.strerror})"
