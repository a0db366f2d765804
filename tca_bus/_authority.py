"""A small certificate authority: makes, renews and lists the keys in a `Keyring`."""

from __future__ import annotations

import datetime as dt
import ipaddress
import os
import secrets
import socket
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from tca_bus._errors import ConfigError, RefusedError, did_you_mean
from tca_bus._keyring import KeyPair, Keyring, check_name

AUTHORITY_NAME = "TCA authority"
ROUTER_NAME = "router"

AUTHORITY_DAYS = 3650
DEFAULT_DAYS = 365

BACKDATED = dt.timedelta(minutes=10)
"""Certificates are valid a little before they are made: clocks differ."""

PRIVATE = 0o600
PUBLIC = 0o644

LOCAL_HOSTS = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True, slots=True)
class KeyInfo:
    """A certificate in a folder of keys; ``hosts`` are those that a router's names."""

    name: str
    kind: Literal["authority", "router", "module"]
    expires: dt.datetime | None
    hosts: tuple[str, ...]
    has_password: bool


@dataclass(frozen=True, slots=True)
class _Signer:
    certificate: x509.Certificate
    private_key: ec.EllipticCurvePrivateKey


class Authority:
    """Signs certificates with the private key in a folder; `make` begins one.

    Raises:
        ConfigError: The folder has no authority, or what it has cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.keyring = Keyring(folder)
        pair = self.keyring.authority
        self.keyring.check_private(pair.private_key)
        self._signer = _Signer(_read_certificate(pair.certificate), _read_key(pair.private_key))

    @classmethod
    def make(
        cls, folder: Path, *, hosts: Sequence[str] = (), days: int = DEFAULT_DAYS
    ) -> Authority:
        """Make an authority in a folder and the router's certificate for some hosts.

        ``hosts`` are names and addresses at which clients reach the router; this machine's name
        and loopback are always among them.

        Raises:
            RefusedError: The folder has an authority already.
            ConfigError: The folder cannot be written.
        """
        pair = Keyring(folder).authority
        for path in (pair.certificate, pair.private_key):
            _refuse_overwriting(path)
        private_key = ec.generate_private_key(ec.SECP256R1())
        certificate = _self_signed(private_key)
        _write_pair(pair, certificate, private_key)
        authority = cls(folder)
        authority.add_router(hosts=hosts, days=days)
        return authority

    def add_module(self, name: str, *, days: int = DEFAULT_DAYS) -> None:
        """Make a certificate with which a module joins.

        Raises:
            RefusedError: It has one.
            ConfigError: It cannot be the name of a module.
        """
        pair = self.keyring.module(check_name(name))
        _refuse_overwriting(pair.certificate)
        _refuse_overwriting(pair.private_key)
        self._issue(pair, name, days, replace=False)

    def add_router(self, *, hosts: Sequence[str] = (), days: int = DEFAULT_DAYS) -> None:
        """Make the router's certificate.

        Raises:
            RefusedError: It has one.
        """
        pair = self.keyring.router
        _refuse_overwriting(pair.certificate)
        self._issue(pair, ROUTER_NAME, days, hosts=_all_hosts(hosts), replace=False)

    def add_password(self, name: str) -> None:
        """Make a password with which a module joins where there are no certificates.

        Raises:
            RefusedError: It has one.
            ConfigError: It cannot be the name of a module.
        """
        path = self.keyring.password_file(check_name(name))
        _refuse_overwriting(path)
        password = secrets.token_urlsafe(24)
        users = self.keyring.read_users() if self.keyring.users.exists() else {}
        users[name] = password
        _write(path, f"{password}\n".encode(), PRIVATE)
        lines = "".join(f"{user}:{word}\n" for user, word in sorted(users.items()))
        _write(self.keyring.users, lines.encode(), PRIVATE, replace=True)

    def renew(
        self,
        names: Iterable[str] = (),
        *,
        days: int = DEFAULT_DAYS,
        hosts: Sequence[str] = (),
    ) -> list[str]:
        """Make new keys and certificates in place of old ones; of all when none are named.

        Gives the names. The router's certificate keeps its hosts and gets ``hosts`` besides.
        Processes that run keep what they have read; the old certificates stay valid until they
        expire.

        Raises:
            ConfigError: One of the names has no certificate here.
        """
        known = [info.name for info in self.list() if info.kind != "authority"]
        chosen = list(names) or known
        for name in chosen:
            if name not in known:
                hint = did_you_mean(name, known)
                raise ConfigError("name", name, f"one that has a certificate here.{hint}")
        for name in chosen:
            self._renew(name, days, hosts)
        return chosen

    def list(self) -> list[KeyInfo]:
        """What `list_keys` finds."""
        return list_keys(self.keyring)

    def _renew(self, name: str, days: int, more_hosts: Sequence[str]) -> None:
        ring = self.keyring
        if name == ROUTER_NAME:
            hosts = [*more_hosts, *_hosts_of(_read_certificate(ring.router.certificate))]
            self._issue(ring.router, name, days, hosts=_all_hosts(hosts), replace=True)
        else:
            self._issue(ring.module(name), name, days, replace=True)

    def _issue(
        self, pair: KeyPair, name: str, days: int, *, hosts: Sequence[str] = (), replace: bool
    ) -> None:
        private_key = ec.generate_private_key(ec.SECP256R1())
        usage = ExtendedKeyUsageOID.SERVER_AUTH if hosts else ExtendedKeyUsageOID.CLIENT_AUTH
        authority = self._signer.certificate
        builder = _builder(name, private_key.public_key(), days, issuer=authority.subject)
        builder = builder.add_extension(x509.ExtendedKeyUsage([usage]), critical=False)
        builder = builder.add_extension(_basic(is_authority=False), critical=True)
        if hosts:
            names = x509.SubjectAlternativeName([_general_name(host) for host in hosts])
            builder = builder.add_extension(names, critical=False)
        signed = builder.sign(self._signer.private_key, hashes.SHA256())
        _write_pair(pair, signed, private_key, replace=replace)


def list_keys(ring: Keyring) -> list[KeyInfo]:
    """The authority, the router and the modules, with the ends of their validity.

    Raises:
        ConfigError: A certificate cannot be read.
    """
    found = [_info(AUTHORITY_NAME, "authority", ring.check_public(ring.authority.certificate))]
    if ring.router.certificate.exists():
        found.append(_info(ROUTER_NAME, "router", ring.router.certificate))
    for name in ring.names():
        password = ring.password_file(name).exists()
        found.append(_info(name, "module", ring.module(name).certificate, password=password))
    return found


def _self_signed(private_key: ec.EllipticCurvePrivateKey) -> x509.Certificate:
    name = _name(AUTHORITY_NAME)
    builder = _builder(AUTHORITY_NAME, private_key.public_key(), AUTHORITY_DAYS, issuer=name)
    builder = builder.add_extension(_basic(is_authority=True), critical=True)
    builder = builder.add_extension(_signs_certificates(), critical=True)
    return builder.sign(private_key, hashes.SHA256())


def _builder(
    name: str, public_key: ec.EllipticCurvePublicKey, days: int, *, issuer: x509.Name
) -> x509.CertificateBuilder:
    now = dt.datetime.now(dt.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(_name(name))
        .issuer_name(issuer)
        .public_key(public_key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - BACKDATED)
        .not_valid_after(now + dt.timedelta(days=days))
    )


def _name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _basic(*, is_authority: bool) -> x509.BasicConstraints:
    return x509.BasicConstraints(ca=is_authority, path_length=0 if is_authority else None)


def _signs_certificates() -> x509.KeyUsage:
    may = {"key_cert_sign": True, "crl_sign": True}
    rest = ("digital_signature", "content_commitment", "key_encipherment", "data_encipherment")
    agreement = ("key_agreement", "encipher_only", "decipher_only")
    return x509.KeyUsage(**may, **dict.fromkeys((*rest, *agreement), False))


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host.strip("[]")))
    except ValueError:
        return x509.DNSName(host)


def _all_hosts(hosts: Sequence[str]) -> list[str]:
    return list(dict.fromkeys([*hosts, *LOCAL_HOSTS, socket.gethostname()]))


def _hosts_of(certificate: x509.Certificate) -> list[str]:
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return []
    return [str(name.value) for name in names]


def _info(
    name: str,
    kind: Literal["authority", "router", "module"],
    path: Path,
    *,
    password: bool = False,
) -> KeyInfo:
    if not path.exists():
        return KeyInfo(name, kind, None, (), password)
    certificate = _read_certificate(path)
    hosts = tuple(_hosts_of(certificate))
    return KeyInfo(name, kind, certificate.not_valid_after_utc, hosts, password)


def _read_certificate(path: Path) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(path.read_bytes())
    except OSError as error:
        raise ConfigError("certificate", str(path), f"a file ({error.strerror})") from error
    except ValueError as error:
        raise ConfigError("certificate", str(path), f"a PEM certificate ({error})") from error


def _read_key(path: Path) -> ec.EllipticCurvePrivateKey:
    try:
        key = serialization.load_pem_private_key(path.read_bytes(), password=None)
    except (TypeError, ValueError) as error:
        raise ConfigError("private key", str(path), f"a PEM private key ({error})") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise ConfigError("private key", str(path), "one that 'tca keys' made (elliptic curve)")
    return key


def _write_pair(
    pair: KeyPair,
    certificate: x509.Certificate,
    private_key: ec.EllipticCurvePrivateKey,
    *,
    replace: bool = False,
) -> None:
    secret = private_key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    _write(pair.private_key, secret, PRIVATE, replace=replace)
    shown = certificate.public_bytes(serialization.Encoding.PEM)
    _write(pair.certificate, shown, PUBLIC, replace=replace)


def _write(path: Path, data: bytes, mode: int, *, replace: bool = False) -> None:
    """Write a file whole or not at all, never readable by more than ``mode`` says."""
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        descriptor = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        if replace:
            partial.replace(path)
        else:
            path.hardlink_to(partial)
            partial.unlink()
    except FileExistsError as error:
        partial.unlink(missing_ok=True)
        raise _exists(path) from error
    except OSError as error:
        partial.unlink(missing_ok=True)
        expected = f"a place that can be written ({error.strerror})"
        raise ConfigError("folder of keys", str(path), expected) from error


def _refuse_overwriting(path: Path) -> None:
    if path.exists():
        raise _exists(path)


def _exists(path: Path) -> RefusedError:
    return RefusedError(f"making {path}", "it is there already; 'tca keys renew' replaces keys")
