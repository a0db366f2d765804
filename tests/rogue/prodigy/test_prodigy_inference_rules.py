"""Inference rules as text: their modes, and what they make changeable."""

from __future__ import annotations

import pytest

from rogue.prodigy import InferenceMode, PdlError, parse_domain

ROOMS = """
(ptype-of room :top-type)
(OPERATOR go (params <to>)
  (preconds ((<from> room) (<to> room)) (and (at <from>) (linked <from> <to>)))
  (effects () ((del (at <from>)) (add (at <to>)))))
"""


def rule(name: str, mode: str, condition: str, effect: str) -> str:
    return (
        f"(INFERENCE-RULE {name} {mode} (params <a> <b>)\n"
        f"  (preconds ((<a> room) (<b> room)) {condition})\n"
        f"  (effects () ({effect})))\n"
    )


SYMMETRIC = rule("symmetric", "(mode eager)", "(linked <a> <b>)", "(add (linked <b> <a>))")
SEES = rule("sees", "(mode eager)", "(and (at <a>) (linked <a> <b>))", "(add (sees <b>))")
NEAR = rule("near", "", "(or (at <a>) (sees <b>))", "(add (near <b>))")


def test_rules_keep_their_order_and_their_modes() -> None:
    domain = parse_domain(ROOMS + NEAR + SYMMETRIC + SEES)
    modes = [(r.name, r.mode) for r in domain.inference_rules]
    assert modes == [
        ("near", InferenceMode.LAZY),
        ("symmetric", InferenceMode.STATIC),
        ("sees", InferenceMode.EAGER),
    ]
    assert domain.inference_rule("near") is domain.inference_rules[0]
    assert [o.name for o in domain.operators] == ["go"]


def test_what_rules_infer_may_become_true_and_false() -> None:
    domain = parse_domain(ROOMS + SEES + NEAR + SYMMETRIC)
    assert {("sees", True), ("sees", False), ("near", False)} <= domain.changed
    assert domain.is_static("linked")
    assert not domain.is_static("near")


def test_an_eager_rule_upon_one_that_is_not_static_is_not_static() -> None:
    sightseen = rule("sightseen", "(mode eager)", "(and (sees <a>) (sees <b>))", "(add (proud))")
    domain = parse_domain(ROOMS + sightseen + SEES)
    assert {r.mode for r in domain.inference_rules} == {InferenceMode.EAGER}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (NEAR.replace("near ", "near (mode lasy) ", 1), "did you mean lazy?"),
        (NEAR.replace("near", "go", 1), "a name that no operator and no inference rule has yet"),
        (NEAR.replace("(params", "(mode lazy) (mode eager) (params"), "(mode ...) only once"),
        (NEAR.replace("(effects", "(efects"), "did you mean"),
    ],
)
def test_an_error_in_a_rule_is_found(text: str, message: str) -> None:
    with pytest.raises(PdlError) as caught:
        parse_domain(ROOMS + text)
    assert message in str(caught.value)
    assert caught.value.position.line >= ROOMS.count("\n")
