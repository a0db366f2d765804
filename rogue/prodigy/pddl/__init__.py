"""PDDL domains and problems, planned by PRODIGY.

Read are STRIPS, types with ``either``, negative, disjunctive and quantified preconditions,
equality, conditional and universal effects, constants, derived predicates, and action costs.
Anything else is refused where it stands.
"""

from __future__ import annotations

from rogue.prodigy.pddl._read_domain import SUPPORTED, PddlDomain, read_domain
from rogue.prodigy.pddl._read_problem import read_problem

__all__ = ["SUPPORTED", "PddlDomain", "read_domain", "read_problem"]
