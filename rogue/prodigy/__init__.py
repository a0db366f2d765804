"""PRODIGY4.0 as a library: a means-ends planner that can be interrupted and can execute.

Pure and synchronous: no asyncio, no input or output beyond reading domain and problem texts.
``Search`` is driven by its caller one event at a time; ``solve`` runs one to its end.
"""

from __future__ import annotations

from rogue.prodigy._costs import Costs
from rogue.prodigy._domain import Domain, Effect, InferenceMode, InferenceRule, Operator
from rogue.prodigy._errors import (
    FunctionError,
    InferenceError,
    LiteralError,
    PdlError,
    Position,
    ProdigyError,
    SequenceError,
    TooManyValuesError,
    UnknownNameError,
)
from rogue.prodigy._events import (
    Announced,
    Choice,
    Decided,
    Event,
    Execute,
    Executed,
    Failed,
    Finished,
    Found,
    NodeKind,
    NodeView,
    Poll,
    Rerooted,
    RuleFired,
    StepView,
)
from rogue.prodigy._functions import Function, generator
from rogue.prodigy._goal_tree import GoalTree, Standing, TreeNode, TreeStep, goal_tree
from rogue.prodigy._instance import Instance
from rogue.prodigy._load import load_domain, load_problem, load_task
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._options import Mode, PollPoint, SearchOptions, Solutions
from rogue.prodigy._parse_domain import parse_domain
from rogue.prodigy._parse_problem import parse_literal, parse_problem
from rogue.prodigy._problem import Problem
from rogue.prodigy._render import render_tree
from rogue.prodigy._result import Limit, LimitKind, SearchResult, Status, Stop
from rogue.prodigy._rules import Action, Candidate, DecideRule, PreferRule, Rule, RuleSet
from rogue.prodigy._search import Handler, Search
from rogue.prodigy._snapshot import NodeState, SnapshotNode, TreeSnapshot
from rogue.prodigy._solve import Solution, solutions, solve
from rogue.prodigy._state import State
from rogue.prodigy._task import Task
from rogue.prodigy._terms import Literal, Value, Variable
from rogue.prodigy._types import Objects
from rogue.prodigy._validate import PlanFault, validate_plan
from rogue.prodigy._view import SearchView

__all__ = [
    "Action",
    "Announced",
    "Candidate",
    "Choice",
    "Costs",
    "DecideRule",
    "Decided",
    "Domain",
    "Effect",
    "Event",
    "Execute",
    "Executed",
    "Failed",
    "Finished",
    "Found",
    "Function",
    "FunctionError",
    "GoalTree",
    "Handler",
    "InferenceError",
    "InferenceMode",
    "InferenceRule",
    "Instance",
    "Limit",
    "LimitKind",
    "Literal",
    "LiteralError",
    "MetaPredicate",
    "Mode",
    "NodeKind",
    "NodeState",
    "NodeView",
    "Objects",
    "Operator",
    "PdlError",
    "PlanFault",
    "Poll",
    "PollPoint",
    "Position",
    "PreferRule",
    "Problem",
    "ProdigyError",
    "Rerooted",
    "Rule",
    "RuleFired",
    "RuleSet",
    "Search",
    "SearchOptions",
    "SearchResult",
    "SearchView",
    "SequenceError",
    "SnapshotNode",
    "Solution",
    "Solutions",
    "Standing",
    "State",
    "Status",
    "StepView",
    "Stop",
    "Task",
    "TooManyValuesError",
    "TreeNode",
    "TreeSnapshot",
    "TreeStep",
    "UnknownNameError",
    "Value",
    "Variable",
    "generator",
    "goal_tree",
    "load_domain",
    "load_problem",
    "load_task",
    "parse_domain",
    "parse_literal",
    "parse_problem",
    "render_tree",
    "solutions",
    "solve",
    "validate_plan",
]
