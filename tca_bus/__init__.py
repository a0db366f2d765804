"""TCA, the Task Control Architecture, on Eclipse Zenoh: typed messages and a task tree."""

from tca_bus._clock import Clock
from tca_bus._context import Context, TaskContext
from tca_bus._errors import (
    BusGoneError,
    BusyError,
    ClosedError,
    ConfigError,
    HandlerFailedError,
    InvalidMessageError,
    KilledError,
    NoHandlerError,
    PeerLostError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TcaError,
    TimedOutError,
    did_you_mean,
    near_matches,
    near_or_all,
)
from tca_bus._failure import Failure
from tca_bus._handle import TaskHandle
from tca_bus._logs import configure_logging
from tca_bus._messages import (
    Broadcast,
    Command,
    Goal,
    Inform,
    Message,
    MessageClass,
    MultiQuery,
    Query,
    TaskMessage,
    TcaException,
)
from tca_bus._module import Module
from tca_bus._options import BusOptions
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import AwaitTime, Constraint, SimulatedTime, TaskState, TaskStatus
from tca_bus._router import Router
from tca_bus._subscription import Subscription

__all__ = [
    "AwaitTime",
    "Broadcast",
    "BusGoneError",
    "BusOptions",
    "BusyError",
    "Clock",
    "ClosedError",
    "Command",
    "ConfigError",
    "Constraint",
    "Context",
    "Failure",
    "Goal",
    "HandlerFailedError",
    "Inform",
    "InvalidMessageError",
    "KilledError",
    "Message",
    "MessageClass",
    "Module",
    "MultiQuery",
    "NoHandlerError",
    "PeerLostError",
    "PresenceChange",
    "PresentModule",
    "Query",
    "RefusedError",
    "Router",
    "SimulatedTime",
    "Subscription",
    "TaskContext",
    "TaskError",
    "TaskFailedError",
    "TaskHandle",
    "TaskMessage",
    "TaskState",
    "TaskStatus",
    "TcaError",
    "TcaException",
    "TimedOutError",
    "configure_logging",
    "did_you_mean",
    "near_matches",
    "near_or_all",
]
