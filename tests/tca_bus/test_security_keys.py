"""Keys on disk: made, listed, renewed, never overwritten, private ones private."""

from __future__ import annotations

import json
import shutil
import stat
from dataclasses import dataclass

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from tca_bus import BusOptions, ConfigError, RefusedError
from tca_bus._authority import Authority
from tca_bus._credentials import credentials_for, router_transport
from tca_bus._keyring import Keyring, is_owned, owner_among
from tca_bus.cli._flags import BusFlags, bus_options
from tca_bus.cli._run import run_app
from tca_bus.cli.tca import app
from tca_bus.launcher import provide_keys
from tca_bus.launcher._office import environment


@pytest.fixture
def folder(tmp_path):
    authority = Authority.make(tmp_path / "keys", hosts=["robot.local", "10.1.2.3"])
    authority.add_module("navigate")
    return authority.keyring.folder


def certificate(pair):
    return x509.load_pem_x509_certificate(pair.certificate.read_bytes())


@dataclass
class Ran:
    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def tca(capsys):
    """The command line, in this process."""

    def run(*words):
        with pytest.raises(SystemExit) as ended:
            run_app(app, words)
        return Ran(ended.value.code, *capsys.readouterr())

    return run


def test_private_files_are_readable_by_their_owner_only(folder):
    Authority(folder).add_password("navigate")
    private = {*folder.rglob("*.key"), folder / "users.txt", folder / "modules/navigate/password"}
    assert len(private) == 5
    assert {stat.S_IMODE(path.stat().st_mode) for path in private} == {0o600}
    assert {stat.S_IMODE(path.stat().st_mode) for path in folder.rglob("*.pem")} == {0o644}
    assert not [path for path in folder.rglob(".*") if path.is_file()]


def test_a_module_is_named_in_its_certificate_and_can_only_be_a_client(folder):
    ring = Keyring(folder)
    found = certificate(ring.module("navigate"))
    (name,) = found.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    assert name.value == "navigate"
    usage = found.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
    assert list(usage) == [ExtendedKeyUsageOID.CLIENT_AUTH]
    found.verify_directly_issued_by(certificate(ring.authority))


def test_the_router_has_the_hosts_at_which_it_is_reached(folder):
    found = certificate(Keyring(folder).router)
    names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert {"robot.local", "localhost"} <= set(names.get_values_for_type(x509.DNSName))
    addresses = map(str, names.get_values_for_type(x509.IPAddress))
    assert {"10.1.2.3", "127.0.0.1", "::1"} <= set(addresses)


def test_nothing_is_overwritten(folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(RefusedError, match="there already"):
        Authority.make(folder)
    with pytest.raises(RefusedError, match="there already"):
        Authority(folder).add_module("navigate")
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_a_password_is_added_beside_others_and_not_replaced(folder):
    authority = Authority(folder)
    authority.add_password("navigate")
    authority.add_password("rogue")
    ring = authority.keyring
    users = ring.read_users()
    assert users == {name: ring.read_password(name) for name in ("navigate", "rogue")}
    assert users["navigate"] != users["rogue"]
    with pytest.raises(RefusedError, match="there already"):
        authority.add_password("rogue")


def test_renewing_makes_new_keys_and_keeps_names_and_hosts(folder):
    ring = Keyring(folder)
    old = {pair: certificate(pair) for pair in (ring.router, ring.module("navigate"))}
    assert Authority(folder).renew(days=30, hosts=["second"]) == ["router", "navigate"]
    for pair, before in old.items():
        after = certificate(pair)
        assert after.public_key() != before.public_key()
        assert after.subject == before.subject
        assert after.not_valid_after_utc < before.not_valid_after_utc
    listed = {info.name: info for info in Authority(folder).list()}
    assert {"robot.local", "10.1.2.3", "second"} <= set(listed["router"].hosts)


def test_renewing_names_what_is_near(folder):
    with pytest.raises(ConfigError, match="Did you mean 'navigate'"):
        Authority(folder).renew(["navigat"])


@pytest.mark.parametrize("name", ["", "a/b", "-a", "x" * 65, "a:b", "../a"])
def test_a_name_that_cannot_stand_in_a_certificate_is_refused(folder, name):
    for add in (Authority(folder).add_module, Authority(folder).add_password):
        with pytest.raises(ConfigError, match="1 to 64 letters"):
            add(name)


@pytest.mark.parametrize(
    ("module", "owner"),
    [("tca", "tca"), ("tca-12", "tca"), ("tca-12-b", "tca"), ("tcab", None), ("a-b-1", "a-b")],
)
def test_a_module_goes_by_the_longest_name_that_it_extends(module, owner):
    assert owner_among(module, ["a", "tca", "a-b"]) == owner
    assert owner is None or is_owned(module, owner)


def test_an_encrypted_endpoint_takes_the_certificate_and_others_the_password(folder):
    Authority(folder).add_password("navigate")
    tls = credentials_for(BusOptions(connect="tls/localhost:1", keys=folder), "navigate-7")
    assert tls.transport["link"]["tls"]["connect_certificate"].endswith("navigate/certificate.pem")
    assert "auth" not in tls.transport
    tcp = credentials_for(BusOptions(keys=folder), "navigate")
    assert tcp.transport["auth"]["usrpwd"]["user"] == "navigate"
    assert tcp.password not in repr(tcp)


def test_user_and_password_go_before_the_folder(folder):
    options = BusOptions(keys=folder, user="me", password="secret")
    assert credentials_for(options, "navigate").user == "me"
    assert "secret" not in repr(options)


def test_what_is_missing_is_named(folder, tmp_path):
    tls = BusOptions(connect="tls/localhost:1")
    with pytest.raises(ConfigError, match="--keys is None"):
        credentials_for(tls, "navigate")
    at = tls.model_copy(update={"keys": folder})
    with pytest.raises(ConfigError, match="Did you mean 'navigate'"):
        credentials_for(at, "navigat-12")
    with pytest.raises(ConfigError, match=r"authority\.pem"):
        credentials_for(tls.model_copy(update={"keys": tmp_path}), "navigate")
    with pytest.raises(ConfigError, match="tls/HOST:PORT"):
        credentials_for(BusOptions(keys=folder), "navigate")
    with pytest.raises(ConfigError, match=r"users\.txt"):
        router_transport(folder, "tcp/localhost:1", "password")
    with pytest.raises(ConfigError, match="--auth"):
        router_transport(folder, "tcp/localhost:1", "certificate")
    with pytest.raises(ConfigError, match="both, or neither"):
        BusOptions(user="me")


def test_a_key_that_others_may_read_is_not_used(folder):
    key = Keyring(folder).module("navigate").private_key
    key.chmod(0o640)
    with pytest.raises(ConfigError, match="chmod 600"):
        credentials_for(BusOptions(connect="tls/localhost:1", keys=folder), "navigate")


def test_a_line_that_is_no_user_is_named(folder):
    (folder / "users.txt").write_text("navigate:x\nrogue\n")
    (folder / "users.txt").chmod(0o600)
    with pytest.raises(ConfigError, match="line 2"):
        Keyring(folder).read_users()


def test_what_is_no_certificate_is_told(folder):
    (folder / "authority.pem").write_text("nonsense")
    with pytest.raises(ConfigError, match="a PEM certificate"):
        Authority(folder)
    (folder / "authority.key").write_text("nonsense")
    with pytest.raises(ConfigError, match="a PEM "):
        Authority(folder)


def test_an_office_gets_the_keys_that_it_lacks_and_new_ones_in_time(tmp_path):
    policy = tmp_path / "policy.toml"
    policy.write_text("[modules.navigate]\n")
    folder = tmp_path / "keys"
    provide_keys(folder, policy)
    ring = Keyring(folder)
    assert ring.names() == ["central", "navigate"]
    kept = certificate(ring.module("central"))
    Authority(folder).renew(["navigate"], days=10)
    ending = certificate(ring.module("navigate"))
    policy.write_text("[modules.navigate]\n[modules.rogue]\n")
    provide_keys(folder, policy)
    assert ring.names() == ["central", "navigate", "rogue"]
    assert certificate(ring.module("central")) == kept
    assert certificate(ring.module("navigate")) != ending


def test_processes_inherit_keys_from_the_launcher(folder, monkeypatch):
    assert "TCA_KEYS" not in environment(BusOptions())
    monkeypatch.chdir(folder.parent)
    given = environment(BusOptions(keys=folder.name, user="u", password="p"))
    assert given["TCA_KEYS"] == str(folder)
    assert (given["TCA_USER"], given["TCA_PASSWORD"]) == ("u", "p")


def test_flags_become_options(folder):
    options = bus_options(BusFlags(keys=folder, user="me", password="secret"))
    assert options.keys == folder
    assert options.password is not None
    assert options.password.get_secret_value() == "secret"


def test_the_command_line_makes_adds_lists_and_renews(tca, tmp_path):
    folder = str(tmp_path / "keys")
    policy = tmp_path / "policy.toml"
    policy.write_text("[modules.navigate]\nserve = ['navigateToG']\n")
    made = tca("keys", "make", folder, "tca", "--policy", str(policy), "--host", "robot", "--json")
    assert made.returncode == 0, made.stderr
    rows = {row["name"]: row for row in json.loads(made.stdout)}
    assert list(rows) == ["TCA authority", "router", "central", "navigate", "tca"]
    assert "robot" in rows["router"]["hosts"]
    again = tca("keys", "make", folder)
    assert (again.returncode, "there already" in again.stderr) == (7, True)
    assert tca("keys", "add", folder, "rogue").returncode == 0
    assert tca("keys", "password", folder, "rogue").returncode == 0
    assert tca("keys", "renew", folder, "rogue", "--days", "9").returncode == 0
    listed = json.loads(tca("keys", "list", folder, "--json").stdout)
    assert listed[-2] == {
        "name": "rogue",
        "kind": "module",
        "expires": listed[-2]["expires"],
        "days": 8,
        "password": True,
        "hosts": [],
    }
    assert tca("keys", "add", folder).returncode == 2
    (tmp_path / "keys" / "authority.key").unlink()
    assert json.loads(tca("keys", "list", folder, "--json").stdout) == listed
    assert "authority.key" in tca("keys", "add", folder, "x").stderr
    shutil.rmtree(folder)
    assert "authority.pem" in tca("keys", "list", folder).stderr


def test_the_command_line_shows_and_asks_a_policy(tca, tmp_path):
    policy = tmp_path / "policy.toml"
    policy.write_text("[modules.navigate]\nserve = ['navigateToG']\nkill = ['*@rogue']\n")
    shown = json.loads(tca("policy", str(policy), "navigate", "--json").stdout)
    assert shown[0] == {"module": "navigate", "right": "serve", "patterns": ["navigateToG"]}
    yes = tca("policy", str(policy), "navigate", "kill", "drive", "--owner", "rogue")
    assert (yes.returncode, yes.stdout[:4]) == (0, "yes:")
    no = tca("policy", str(policy), "navigate", "serve", "drive")
    assert (no.returncode, "only 'navigateToG'" in no.stdout) == (7, True)
    assert tca("policy", str(policy), "rogue").returncode == 2
    policy.write_text("[modules.navigate]\nserv = []\n")
    wrong = tca("policy", str(policy))
    assert (wrong.returncode, "Did you mean 'serve'" in wrong.stderr) == (2, True)
