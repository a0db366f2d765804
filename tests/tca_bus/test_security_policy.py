"""The policy by itself: what it says, and that the router's rules say the same."""

from __future__ import annotations

import itertools
import json
import re

import pytest
import zenoh
from hypothesis import given, settings
from hypothesis import strategies as st

from tca_bus import ConfigError, RefusedError
from tca_bus._access import access_control, rate_limits, size_limits
from tca_bus._keyring import is_owned, owner_among
from tca_bus._keys import Keys
from tca_bus._limits import MOST_MESSAGE_BYTES, Meter
from tca_bus._permissions import Permissions
from tca_bus._policy import FROM_CENTRAL, Grant, Limit, ModuleGrant, Policy
from tca_bus._policy_file import read_policy
from tca_bus._presence import PresentModule
from tca_bus._rights import OWN_TASKS, OWNED, Right, as_chunk, is_pattern, matches, matches_module

OFFICE = Policy.model_validate(
    {
        "everyone": {"listen": ["clock"]},
        "roles": {"operator": {"send": ["*"], "kill": ["*"], "watch": ["*"]}},
        "modules": {
            "navigate": {"serve": ["navigate*"], "send": ["drive"], "listen": ["sensors@xavier"]},
            "rogue": {"send": ["navigateToG"], "kill": ["navigate*@tca"]},
            "tca": {"roles": ["operator"]},
            "xavier": {"send": ["sensors", "tca.simTime"], "serve": ["drive"]},
        },
        "limits": {"drive": {"bytes": 500, "hertz": 50}, "sensors@xavier": {"bytes": 9000}},
    }
)

CHUNKS = st.sampled_from(["a", "ab", "b", "tca.x", "tca.simTime", "nav", "navGo", "go"])
MODULES = ("a", "b", "nav", "tca")
PATTERNS = st.sampled_from(
    ["*", "a", "a*", "*b", "n*Go", "go", "tca.*", "tca.simTime", "nav", "*o", "navGo"]
)
OWNED_PATTERNS = st.one_of(PATTERNS, st.builds("{}@{}".format, PATTERNS, st.sampled_from(MODULES)))


FEW = settings(max_examples=60, deadline=None)

SOME_RIGHTS = (Right.SEND, Right.SERVE, Right.LISTEN, Right.WATCH, Right.KILL, Right.READ)


def grants(kind=Grant):
    some = {r: OWNED_PATTERNS if r in OWNED else PATTERNS for r in SOME_RIGHTS}
    return st.builds(kind, **{r.value: st.lists(p, max_size=2) for r, p in some.items()})


POLICIES = st.builds(
    Policy,
    everyone=grants(),
    modules=st.dictionaries(st.sampled_from(MODULES), grants(ModuleGrant), max_size=2),
)
SENDERS = st.sampled_from([*MODULES, "a-1", "tca-4711", "nav-x-2", "stranger"])
OWNERS = st.one_of(st.none(), SENDERS)


@pytest.mark.parametrize(
    ("question", "owner", "allowed", "reason"),
    [
        (("navigate", Right.SERVE, "navigateToG"), None, True, "modules.navigate.serve has"),
        (("navigate", Right.SERVE, "drive"), None, False, "serve: only 'navigate*'"),
        (("navigate-12", Right.SEND, "drive"), None, True, "'drive'"),
        (("navigate2", Right.SEND, "drive"), None, False, "no module 'navigate2'"),
        (("navigate", Right.LISTEN, "sensors"), "xavier", True, "'sensors@xavier'"),
        (("navigate", Right.LISTEN, "sensors"), "xavier-3", True, "'sensors@xavier'"),
        (("navigate", Right.LISTEN, "sensors"), "rogue", False, "of 'rogue'"),
        (("navigate", Right.LISTEN, "clock"), "xavier", True, "everyone.listen"),
        (("rogue", Right.KILL, "navigateToG"), "tca-99", True, "'navigate*@tca'"),
        (("rogue", Right.KILL, "navigateToG"), "navigate", False, "not let module 'rogue' kill"),
        (("rogue", Right.KILL, "anything"), "rogue", True, "itself"),
        (("rogue-1", Right.WATCH, "rogue"), None, True, "itself"),
        (("rogue", Right.WATCH, "tca"), None, False, "nothing of that kind"),
        (("tca-7", Right.SEND, "drive"), None, True, "roles.operator.send has '*'"),
        (("tca", Right.SEND, "tca.handle"), None, False, "only central may send"),
        (("tca", Right.SEND, "tca.simTime"), None, False, "does not let module 'tca' send"),
        (("xavier", Right.SEND, "tca.simTime"), None, True, "modules.xavier.send"),
        (("rogue", Right.SEND, "tca.submit"), None, True, "message of the bus itself"),
        (("central", Right.SEND, "tca.handle"), None, True, "central may do everything"),
        (("roge", Right.SEND, "drive"), None, False, "Did you mean 'rogue'?"),
    ],
)
def test_a_question_gets_an_answer_with_its_reason(question, owner, allowed, reason):
    ruling = OFFICE.rule(*question, owner=owner)
    assert ruling.allowed is allowed
    assert reason in ruling.reason


@FEW
@given(SENDERS, st.sampled_from(Right), CHUNKS, OWNERS)
def test_an_empty_policy_refuses_everything_to_everybody(sender, right, name, owner):
    assert not Policy().rule(sender, right, name, owner=owner)


@FEW
@given(POLICIES, SENDERS, st.sampled_from(SOME_RIGHTS), CHUNKS, OWNERS)
def test_what_is_allowed_is_listed_owned_or_of_the_bus(policy, sender, right, name, owner):
    ruling = policy.rule(sender, right, name, owner=owner)
    module = owner_among(sender, policy.modules)
    if module is None:
        assert not ruling
        return
    owned = name if right == Right.WATCH else owner
    is_own = right in OWN_TASKS and owned is not None and is_owned(owned, module)
    of_the_bus = name.startswith("tca.") and right in {Right.SEND, Right.SERVE, Right.LISTEN}
    names = [p.partition("@")[0] for p in policy.patterns(module, right)]
    fits = matches_module if right == Right.WATCH else matches
    assert not ruling or is_own or of_the_bus or any(fits(p, name) for p in names)


@FEW
@given(POLICIES, PATTERNS, SENDERS, st.sampled_from(SOME_RIGHTS), st.tuples(CHUNKS, OWNERS))
def test_a_pattern_more_takes_nothing_away(policy, pattern, sender, right, about):
    name, owner = about
    wider = policy.everyone.model_copy(
        update={right.value: (*policy.everyone.patterns(right), pattern)}
    )
    before = policy.rule(sender, right, name, owner=owner)
    after = policy.model_copy(update={"everyone": wider}).rule(sender, right, name, owner=owner)
    assert after or not before


@FEW
@given(POLICIES, SENDERS, st.sampled_from(SOME_RIGHTS), CHUNKS, OWNERS)
def test_a_policy_says_the_same_after_its_way_over_the_bus(policy, sender, right, name, owner):
    again = Policy.model_validate_json(policy.model_dump_json())
    assert again.rule(sender, right, name, owner=owner) == policy.rule(
        sender, right, name, owner=owner
    )


@FEW
@given(st.text("ab.-_*", max_size=8), st.text("ab.-_", min_size=1, max_size=8))
def test_a_pattern_is_read_as_zenoh_reads_it(pattern, name):
    if is_pattern(pattern):
        ours = matches(pattern, name)
        assert zenoh.KeyExpr(as_chunk(pattern)).includes(zenoh.KeyExpr(name)) is ours


class RouterRules:
    """The access rules as Zenoh applies them to one who is connected."""

    def __init__(self, policy, realm, common_name):
        table = access_control(policy, realm, by="cert_common_names")
        assert table["default_permission"] == "deny"
        subjects = [
            subject["id"]
            for subject in table["subjects"]
            if common_name in subject.get("cert_common_names", [common_name])
        ]
        ids = {
            rule
            for entry in table["policies"]
            if set(entry["subjects"]) & set(subjects)
            for rule in entry["rules"]
        }
        self.rules = [rule for rule in table["rules"] if rule["id"] in ids]

    def lets(self, message, flow, key):
        wanted = zenoh.KeyExpr(key)
        hits = {
            rule["permission"]
            for rule in self.rules
            if message in rule["messages"]
            and flow in rule["flows"]
            and any(zenoh.KeyExpr(k).includes(wanted) for k in rule["key_exprs"])
        }
        return hits == {"allow"}


KEYS = Keys("realm")


def callee(name):
    return PresentModule(name, "1", "host", 1, ())


@FEW
@given(POLICIES, st.sampled_from(MODULES), SENDERS, CHUNKS)
def test_the_router_lets_pass_what_the_policy_lets_send(policy, me, claimed, name):
    router = RouterRules(policy, "realm", me)
    may = is_owned(claimed, me) and me in policy.modules
    may = may and policy.rule(claimed, Right.SEND, name).allowed
    for key, carrier in (
        (KEYS.query(callee("b"), name, claimed), "query"),
        (KEYS.one_way("inform", name, claimed), "put"),
        (KEYS.one_way("broadcast", name, claimed), "put"),
    ):
        assert router.lets(carrier, "ingress", key) is may


@FEW
@given(POLICIES, st.sampled_from(MODULES), SENDERS, CHUNKS, SENDERS)
def test_the_router_hands_over_what_the_policy_lets_serve_and_hear(
    policy, me, claimed, name, sender
):
    router = RouterRules(policy, "realm", me)
    is_me = is_owned(claimed, me) and me in policy.modules
    serves = policy.rule(me, Right.SERVE, name).allowed
    hears = policy.rule(me, Right.LISTEN, name, owner=sender).allowed
    query = KEYS.query(callee(claimed), name, sender)
    assert router.lets("query", "egress", query) is (is_me and serves)
    assert router.lets("reply", "ingress", query) is (is_me and serves)
    is_listed = me in policy.modules
    broadcast = KEYS.one_way("broadcast", name, sender)
    assert router.lets("put", "egress", broadcast) is (is_listed and hears)
    inform = KEYS.one_way("inform", name, sender)
    assert router.lets("put", "egress", inform) is (is_listed and (hears or serves))


@FEW
@given(POLICIES, st.sampled_from(MODULES), SENDERS)
def test_the_router_shows_the_tasks_that_the_policy_lets_watch(policy, me, owner):
    router = RouterRules(policy, "realm", me)
    may = me in policy.modules and policy.rule(me, Right.WATCH, owner).allowed
    key = KEYS.task(owner, "task-1")
    assert router.lets("put", "egress", key) is may
    assert router.lets("query", "ingress", key) is may
    assert not router.lets("put", "ingress", key)


@FEW
@given(POLICIES, st.sampled_from(MODULES), SENDERS)
def test_the_router_binds_a_presence_to_its_name(policy, me, claimed):
    router = RouterRules(policy, "realm", me)
    may = me in policy.modules and is_owned(claimed, me)
    assert router.lets("liveliness_token", "ingress", KEYS.presence(callee(claimed))) is may
    assert router.lets("query", "ingress", KEYS.policy(claimed)) is may
    assert router.lets("query", "ingress", KEYS.policy())


@FEW
@given(POLICIES, st.sampled_from(MODULES), CHUNKS)
def test_the_router_shows_the_variables_that_the_policy_lets_read(policy, me, name):
    router = RouterRules(policy, "realm", me)
    may = me in policy.modules and policy.rule(me, Right.READ, name).allowed
    assert router.lets("put", "egress", KEYS.variable(name)) is may
    assert router.lets("query", "ingress", KEYS.variable(name)) is may
    assert not router.lets("put", "ingress", KEYS.variable(name))


@FEW
@given(POLICIES, st.sampled_from(MODULES), CHUNKS)
def test_nothing_passes_on_another_realm(policy, me, name):
    router = RouterRules(policy, "realm", me)
    assert not router.lets("put", "ingress", Keys("other").one_way("inform", name, me))
    assert not router.lets("put", "ingress", f"@/router/{name}")


@FEW
@given(POLICIES, st.sampled_from(MODULES), SENDERS, SENDERS)
def test_calls_and_answers_go_from_and_to_their_names_only(policy, me, claimed, other):
    router = RouterRules(policy, "realm", me)
    is_me = me in policy.modules and is_owned(claimed, me)
    assert router.lets("put", "ingress", f"realm/answer/{other}/1/{claimed}") is is_me
    assert router.lets("put", "egress", f"realm/answer/{claimed}/1/{other}") is is_me
    assert router.lets("declare_subscriber", "ingress", f"realm/answer/{claimed}/1/*") is is_me
    assert router.lets("declare_subscriber", "ingress", f"realm/call/{claimed}/1/*/*") is is_me
    may = is_me and policy.rule(claimed, Right.SEND, "go").allowed
    assert router.lets("put", "ingress", f"realm/call/{other}/1/go/{claimed}") is may


def test_only_central_orders_modules_about_whatever_a_star_allows():
    policy = Policy(modules={"tca": ModuleGrant(send=("*", "tca.*"))})
    for name in FROM_CENTRAL:
        key = KEYS.query(callee("robot"), name, "tca")
        assert not RouterRules(policy, "realm", "tca").lets("query", "ingress", key)
        order = KEYS.query(callee("robot"), name, "central")
        assert RouterRules(policy, "realm", "central").lets("query", "ingress", order)


def test_the_rules_are_taken_by_zenoh():
    settings = {
        "access_control": access_control(OFFICE, "realm", by="usernames"),
        "low_pass_filter": size_limits(OFFICE, "realm"),
        "downsampling": rate_limits(OFFICE, "realm"),
    }
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    ids = [rule["id"] for rule in settings["access_control"]["rules"]]
    assert len(ids) == len(set(ids))


WRONG_FILES = [
    ("[modules.nav]\nserv = ['a']", "modules.nav.serv", "Did you mean 'serve'"),
    ("[module.nav]", "module is", "Did you mean 'modules'"),
    ("[modules.nav]\nserve = 'a'", "modules.nav.serve is 'a'", "expected a list of patterns"),
    ("[modules.nav]\nserve = ['a/b']", "modules.nav.serve.0 is 'a/b'", "a name in which"),
    ("[modules.nav]\nserve = ['a**']", "modules.nav.serve.0 is 'a**'", "a name in which"),
    ("[modules.nav]\nsend = ['a@b']", "modules.nav.send.0 is 'a@b'", "a name in which"),
    ("[modules.nav]\nkill = ['a@']", "modules.nav.kill.0 is 'a@'", "with '@' and a module"),
    ("[modules.nav]\nroles = ['x']\n[roles.xx]", "no role 'x'", "Did you mean 'xx'?"),
    ("[modules.a]\n[modules.a-b]", "modules.a-b", "module 'a' may use this name too"),
    ("[modules.'a b']", "modules.a b", "letters, digits"),
    ("[modules.central]", "modules.central", "leave it out"),
    ("modules = 3", "modules is 3", "expected a table"),
    ("[limits]\nx = {bytes = 3}", "limits.x.bytes is 3", "greater than or equal to 256"),
    ("[limits]\nx = {}", "limits.x is {}", "expected bytes, hertz, or both"),
    ("[limits]\nx = {byte = 1000}", "limits.x.byte is 1000", "Did you mean 'bytes'"),
    ("[limits]\n'*' = {hertz = 3}", "limits.*.hertz", "begins with a letter"),
    ("[limits]\nx = {hertz = inf}", "limits.x.hertz is inf", "finite"),
    ("modules = ", "policy is", "a TOML file"),
]


@pytest.mark.parametrize(("text", "field", "expected"), WRONG_FILES)
def test_a_wrong_file_is_told_with_file_field_value_and_what_was_expected(
    tmp_path, text, field, expected
):
    path = tmp_path / "policy.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_policy(path)
    for word in (str(path), field, expected):
        assert word in str(caught.value)


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(ConfigError, match="No such file"):
        read_policy(tmp_path / "policy.toml")


def test_permissions_without_a_policy_allow_everything():
    lax, strict = Permissions(), Permissions(OFFICE)
    for right in Right:
        assert lax.may("anybody", right, "anything", owner="somebody")
        assert not strict.may("anybody", right, "anything", owner="somebody")
    lax.check("anybody", Right.KILL, "anything", owner="somebody")
    lax.check_listening("anybody", "anything", is_inform=False)
    with pytest.raises(RefusedError):
        strict.check_listening("anybody", "anything", is_inform=False)


def test_a_refusal_says_who_may_not_do_what():
    with pytest.raises(RefusedError, match=re.escape("to kill 'drive' was refused")) as caught:
        Permissions(OFFICE).check("rogue", Right.KILL, "drive", owner="tca")
    assert "does not let module 'rogue' kill 'drive' of 'tca'" in str(caught.value)
    assert caught.value.exit_code == 7


def test_a_module_is_vouched_for_only_what_it_may_serve():
    said = PresentModule("navigate", "1", "host", 1, ("drive", "navigateToG", "tca.describe"))
    vouched = Permissions(OFFICE).vouch(said)
    assert vouched.provides == ("navigateToG", "tca.describe")
    assert Permissions().vouch(said) is said


def test_limits_are_told_with_size_and_limit():
    permissions = Permissions(OFFICE)
    permissions.check_sending("navigate", "drive", 500)
    with pytest.raises(RefusedError, match=r"501 bytes, and the policy allows 500 \(limits.drive"):
        permissions.check_sending("navigate", "drive", 501)
    with pytest.raises(RefusedError, match="routers take"):
        Permissions().check_sending("anybody", "anything", MOST_MESSAGE_BYTES)


@FEW
@given(st.floats(0.5, 1000), st.lists(st.floats(0, 2), max_size=30))
def test_a_rate_is_kept_whatever_the_gaps(hertz, gaps):
    now = 0.0
    meter = Meter(lambda: now)
    limits = {"x": Limit(hertz=hertz)}
    passed, refused = [], []
    for gap in gaps:
        now += gap
        try:
            meter.check("x", 1, limits)
        except RefusedError:
            refused.append(now - passed[-1])
        else:
            passed.append(now)
    assert all(since < 1 / hertz for since in refused)
    assert all(after - before > 0.999 / hertz for before, after in itertools.pairwise(passed))
