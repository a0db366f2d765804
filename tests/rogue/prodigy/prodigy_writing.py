"""Domains as values and as text, for tests that read back what they wrote."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.prodigy import Domain, Effect, InferenceMode, InferenceRule, Operator, Problem
from rogue.prodigy._expressions import (
    TRUE,
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
)


def domain_text(domain: Domain) -> str:
    """Return a domain without control rules in PRODIGY's language."""
    types = [f"(ptype-of {name} :{above})" for name, above in domain.types.parents.items()]
    infinite = [f"(infinite-type {n} #'{test})" for n, test in domain.types.infinite.items()]
    constants = [f"(pinstance-of {name} {kind})" for name, kind in domain.constants.items()]
    forms = [
        f"(create-problem-space '{domain.name} :current t)",
        *types,
        *infinite,
        *constants,
        *map(_operator, domain.operators),
        *map(_operator, domain.inference_rules),
    ]
    return "\n".join(forms)


def problem_text(problem: Problem) -> str:
    """Return a problem in PRODIGY's language."""
    objects = "".join(f"({name} {kind})" for name, kind in problem.objects.types_of.items())
    facts = _joined(map(str, problem.state.facts()))
    goal = f"{_variables(problem.variables)} {_expression(problem.goal)}"
    return (
        f"(setf (current-problem) (create-problem (name {problem.name})\n"
        f"  (objects {objects})\n  (state (and {facts}))\n  (goal {goal})))"
    )


def _operator(operator: Operator) -> str:
    kind, mode = "OPERATOR", ""
    if isinstance(operator, InferenceRule):
        eager = operator.mode is not InferenceMode.LAZY
        kind, mode = "Inference-Rule", "(mode eager)" if eager else "(mode lazy)"
    return (
        f"({kind} {operator.name} {mode} (params {' '.join(operator.params)})\n"
        f"  (preconds {_variables(operator.variables)} {_expression(operator.precondition)})\n"
        f"  (effects () ({_joined(map(_effect, operator.effects))})))"
    )


def _effect(effect: Effect) -> str:
    change = f"({'add' if effect.adds else 'del'} {effect.atom})"
    if effect.variables:
        variables = _variables(effect.variables)
        return f"(forall {variables} {_expression(effect.condition)} ({change}))"
    return (
        change if effect.condition == TRUE else f"(if {_expression(effect.condition)} ({change}))"
    )


def _variables(specs: Iterable[VariableSpec]) -> str:
    return f"({_joined(map(_variable, specs))})"


def _variable(spec: VariableSpec) -> str:
    if not spec.calls:
        return f"({spec.name} {spec.types})"
    return f"({spec.name} (and {spec.types} {_joined(map(_call, spec.calls))}))"


def _call(call: Call) -> str:
    if call.pattern is not None:
        return f"({call.function} '{call.pattern})"
    return f"({call.function} {_joined(map(str, call.terms))})"


def _expression(expression: Expression) -> str:
    match expression:
        case Holds(atom):
            return str(atom)
        case Not(part):
            return f"(~ {_expression(part)})"
        case And(parts):
            return f"(and {_joined(map(_expression, parts))})"
        case Or(parts):
            return f"(or {_joined(map(_expression, parts))})"
        case Exists(specs, part):
            return f"(exists {_variables(specs)} {_expression(part)})"
        case Forall(specs, part):
            return f"(forall {_variables(specs)} {_expression(part)})"


def _joined(texts: Iterable[str]) -> str:
    return " ".join(texts)
