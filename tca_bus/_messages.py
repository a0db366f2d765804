"""The message classes of TCA as pydantic models.

A message type is a subclass of its TCA class; awaiting a ``Query[Reply]`` gives a ``Reply``
to a type checker too. Source: Simmons, *Structured control for autonomous robots* (1994).
"""

from __future__ import annotations

import enum
from collections.abc import Collection
from typing import Any, ClassVar, Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict

ReplyT = TypeVar("ReplyT")
ResultT = TypeVar("ResultT")

ModuleLostPolicy = Literal["fail", "resend", "hold"]
"""What becomes of a task whose handling module dies: it fails with ``module_lost``, is sent again
to the next provider, or is held until a module of the same name is back."""

UnhandledPolicy = Literal["fail_parent", "go_on"]
"""What a failure does that no exception handler took: it fails the parent too and so in the end
the top-level task, or only this task (as in TCM) while the rest goes on."""


class MessageClass(enum.StrEnum):
    """The TCA class of a message type."""

    INFORM = "inform"
    """One way, to the modules that handle it."""
    BROADCAST = "broadcast"
    """One way, to whoever listens; no listener is no error."""
    QUERY = "query"
    """Asked and answered, outside the task tree."""
    MULTI_QUERY = "multi_query"
    """A query to every handler; the replies come fastest first."""
    GOAL = "goal"
    """A node of the task tree that a handler expands."""
    COMMAND = "command"
    """A node of the task tree that a handler executes."""
    EXCEPTION = "exception"
    """A named failure with data that handlers up the tree may catch."""
    DEMON = "demon"
    """A monitor whose handler watches by itself and fires."""


class Message(BaseModel):
    """Base of all message types.

    ``wire_name`` is the name on the bus; it defaults to the class name with a small initial.
    ``revision`` grows when the fields change, but for a field that is added with a default.
    ``accepts`` are the older revisions that this one understands too: `upgrade` and
    `downgrade_answer` say how.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, ser_json_inf_nan="constants")

    message_class: ClassVar[MessageClass]
    wire_name: ClassVar[str] = ""
    revision: ClassVar[int] = 1
    accepts: ClassVar[Collection[int]] = ()

    @classmethod
    def upgrade(cls, revision: int, data: dict[str, Any]) -> dict[str, Any]:
        """Turn the fields of an older revision, as JSON values, into those of this one."""
        del revision
        return data

    @classmethod
    def downgrade_answer(cls, revision: int, answer: Any) -> Any:
        """Turn an answer, as JSON values, into what a sender of an older revision understands."""
        del revision
        return answer

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Give a wire name to a type that did not choose one."""
        super().__pydantic_init_subclass__(**kwargs)
        if "wire_name" not in cls.__dict__:
            cls.wire_name = cls.__name__[:1].lower() + cls.__name__[1:]


class Inform(Message):
    """A one-way message to the modules that handle it."""

    message_class = MessageClass.INFORM


class Broadcast(Message):
    """A one-way message to every module that listens."""

    message_class = MessageClass.BROADCAST


class Query(Message, Generic[ReplyT]):
    """A question that one module answers with a ``ReplyT``."""

    message_class = MessageClass.QUERY


class MultiQuery(Message, Generic[ReplyT]):
    """A question that all handling modules answer with a ``ReplyT`` each."""

    message_class = MessageClass.MULTI_QUERY


class TaskMessage(Message, Generic[ResultT]):
    """A message that becomes a node of the task tree: a goal or a command.

    ``on_module_lost`` says what becomes of a node whose handling module dies, ``on_unhandled``
    what a failure of it does that no exception handler takes. ``priority`` is the default of its
    priority, ``grace`` how many wall seconds its handler has to end when it is told to stop.
    """

    on_module_lost: ClassVar[ModuleLostPolicy] = "fail"
    on_unhandled: ClassVar[UnhandledPolicy] = "fail_parent"
    priority: ClassVar[int] = 0
    grace: ClassVar[float] = 10.0


class Goal(TaskMessage[ResultT], Generic[ResultT]):
    """A node that its handler expands; handling starts when planning starts."""

    message_class = MessageClass.GOAL


class Command(TaskMessage[ResultT], Generic[ResultT]):
    """A node that its handler executes; handling starts when achievement starts."""

    message_class = MessageClass.COMMAND


class TcaException(Message):
    """A named failure that carries data up the task tree.

    A handler raises ``TaskError(DoorBlocked(room="r-5303"))``. A subclass is caught by handlers
    of its bases too.
    """

    message_class = MessageClass.EXCEPTION

    @classmethod
    def kinds(cls) -> tuple[str, ...]:
        """The wire names of the class and of its bases that are exceptions, the nearest first."""
        found = [base for base in cls.__mro__ if issubclass(base, TcaException)]
        return tuple(base.wire_name for base in found if base is not TcaException)


class Demon(Message):
    """A monitor whose handler watches by itself: it runs while the monitor lives, and fires.

    Source: TCA's demon monitors, whose set-up, firing and cancel are here one coroutine.
    """

    message_class = MessageClass.DEMON
