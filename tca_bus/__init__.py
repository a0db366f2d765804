"""TCA, the Task Control Architecture, on Eclipse Zenoh: typed messages and a task tree."""

from typing import TYPE_CHECKING

from tca_bus._lazily import importer as _importer

if TYPE_CHECKING:
    from tca_bus._attaching import AttachmentHandle, catch, clean_up, tap
    from tca_bus._attachments import (
        Attachment,
        Catch,
        CleanUp,
        Resolution,
        Tap,
        TapCondition,
        TapNotice,
    )
    from tca_bus._clock import Clock
    from tca_bus._context import Context
    from tca_bus._errors import (
        BusGoneError,
        BusyError,
        ClosedError,
        ConfigError,
        DeadlockError,
        HandlerFailedError,
        InvalidMessageError,
        KilledError,
        LeaseLostError,
        NeverSetError,
        NoHandlerError,
        PeerLostError,
        PendingLimitError,
        RefusedError,
        TaskError,
        TaskFailedError,
        TcaError,
        TimedOutError,
        VariableChangedError,
        did_you_mean,
        near_matches,
        near_or_all,
    )
    from tca_bus._failure import Failure
    from tca_bus._handle import TaskHandle
    from tca_bus._json_views import json_view
    from tca_bus._lease import Acquisition, Lease
    from tca_bus._logs import configure_logging
    from tca_bus._messages import (
        Broadcast,
        Command,
        Demon,
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
    from tca_bus._monitor_spec import Condition, MonitorReport
    from tca_bus._multi import Answers
    from tca_bus._options import BusOptions
    from tca_bus._orders import HasPoints, Interval, Moment, Order, Point, TaskRef
    from tca_bus._permissions import Permissions
    from tca_bus._policy import Policy, Ruling
    from tca_bus._policy_file import read_policy
    from tca_bus._presence import PresenceChange, PresentModule
    from tca_bus._protocol import Constraint, TaskState, TaskStatus
    from tca_bus._record_stream import RecordFile, RecordStream, UnreadableError
    from tca_bus._rights import Right
    from tca_bus._router import Guard, Router
    from tca_bus._sending import SendOptions
    from tca_bus._steering import MonitorOptions
    from tca_bus._subscription import Subscription
    from tca_bus._task_context import ExceptionContext, MonitorContext, TaskContext
    from tca_bus._time_messages import TIME_GRAIN, AwaitTime, Settle, Settled, SimulatedTime
    from tca_bus._tree_queries import Relation
    from tca_bus._variable_watch import VariableWatch
    from tca_bus._variables import Reading, Variable, VariableState
    from tca_bus._wire import Payload, decode_message, encode_message

__all__ = [
    "TIME_GRAIN",
    "Acquisition",
    "Answers",
    "Attachment",
    "AttachmentHandle",
    "AwaitTime",
    "Broadcast",
    "BusGoneError",
    "BusOptions",
    "BusyError",
    "Catch",
    "CleanUp",
    "Clock",
    "ClosedError",
    "Command",
    "Condition",
    "ConfigError",
    "Constraint",
    "Context",
    "DeadlockError",
    "Demon",
    "ExceptionContext",
    "Failure",
    "Goal",
    "Guard",
    "HandlerFailedError",
    "HasPoints",
    "Inform",
    "Interval",
    "InvalidMessageError",
    "KilledError",
    "Lease",
    "LeaseLostError",
    "Message",
    "MessageClass",
    "Module",
    "Moment",
    "MonitorContext",
    "MonitorOptions",
    "MonitorReport",
    "MultiQuery",
    "NeverSetError",
    "NoHandlerError",
    "Order",
    "Payload",
    "PeerLostError",
    "PendingLimitError",
    "Permissions",
    "Point",
    "Policy",
    "PresenceChange",
    "PresentModule",
    "Query",
    "Reading",
    "RecordFile",
    "RecordStream",
    "RefusedError",
    "Relation",
    "Resolution",
    "Right",
    "Router",
    "Ruling",
    "SendOptions",
    "Settle",
    "Settled",
    "SimulatedTime",
    "Subscription",
    "Tap",
    "TapCondition",
    "TapNotice",
    "TaskContext",
    "TaskError",
    "TaskFailedError",
    "TaskHandle",
    "TaskMessage",
    "TaskRef",
    "TaskState",
    "TaskStatus",
    "TcaError",
    "TcaException",
    "TimedOutError",
    "UnreadableError",
    "Variable",
    "VariableChangedError",
    "VariableState",
    "VariableWatch",
    "catch",
    "clean_up",
    "configure_logging",
    "decode_message",
    "did_you_mean",
    "encode_message",
    "json_view",
    "near_matches",
    "near_or_all",
    "read_policy",
    "tap",
]

_HOMES = {
    "_attaching": ("AttachmentHandle", "catch", "clean_up", "tap"),
    "_attachments": (
        "Attachment",
        "Catch",
        "CleanUp",
        "Resolution",
        "Tap",
        "TapCondition",
        "TapNotice",
    ),
    "_clock": ("Clock",),
    "_context": ("Context",),
    "_errors": (
        "BusGoneError",
        "BusyError",
        "ClosedError",
        "ConfigError",
        "DeadlockError",
        "HandlerFailedError",
        "InvalidMessageError",
        "KilledError",
        "LeaseLostError",
        "NeverSetError",
        "NoHandlerError",
        "PeerLostError",
        "PendingLimitError",
        "RefusedError",
        "TaskError",
        "TaskFailedError",
        "TcaError",
        "TimedOutError",
        "VariableChangedError",
        "did_you_mean",
        "near_matches",
        "near_or_all",
    ),
    "_failure": ("Failure",),
    "_handle": ("TaskHandle",),
    "_json_views": ("json_view",),
    "_lease": ("Acquisition", "Lease"),
    "_logs": ("configure_logging",),
    "_messages": (
        "Broadcast",
        "Command",
        "Demon",
        "Goal",
        "Inform",
        "Message",
        "MessageClass",
        "MultiQuery",
        "Query",
        "TaskMessage",
        "TcaException",
    ),
    "_module": ("Module",),
    "_monitor_spec": ("Condition", "MonitorReport"),
    "_multi": ("Answers",),
    "_options": ("BusOptions",),
    "_orders": ("HasPoints", "Interval", "Moment", "Order", "Point", "TaskRef"),
    "_permissions": ("Permissions",),
    "_policy": ("Policy", "Ruling"),
    "_policy_file": ("read_policy",),
    "_presence": ("PresenceChange", "PresentModule"),
    "_protocol": ("Constraint", "TaskState", "TaskStatus"),
    "_record_stream": ("RecordFile", "RecordStream", "UnreadableError"),
    "_rights": ("Right",),
    "_router": ("Guard", "Router"),
    "_sending": ("SendOptions",),
    "_steering": ("MonitorOptions",),
    "_subscription": ("Subscription",),
    "_task_context": ("ExceptionContext", "MonitorContext", "TaskContext"),
    "_time_messages": ("TIME_GRAIN", "AwaitTime", "Settle", "Settled", "SimulatedTime"),
    "_tree_queries": ("Relation",),
    "_variable_watch": ("VariableWatch",),
    "_variables": ("Reading", "Variable", "VariableState"),
    "_wire": ("Payload", "decode_message", "encode_message"),
}
"""Where each name comes from; a command that shows its help loads none of them."""

__getattr__ = _importer(__name__, _HOMES)
