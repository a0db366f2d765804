"""What modules ask of central about the task tree, beyond sending and killing."""

from __future__ import annotations

import enum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus._attachments import ATTACHMENT_ID_PATTERN, Attachment
from tca_bus._messages import Query
from tca_bus._orders import TASK_ID_PATTERN, Order
from tca_bus._protocol import TaskStatus


class PrepareTask(Query[TaskStatus]):
    """Make a place for a task that is sent later under the same id.

    Constraints and attachments can name it from then on, and its parent waits for it. It is let
    go when it is killed, or when its sender is lost before it has sent it.
    """

    wire_name = "tca.prepare"

    id: str = Field(pattern=TASK_ID_PATTERN)
    name: str
    task_class: Literal["goal", "command"]
    sender: str
    parent: str | None = None


class ConstrainTasks(Query[int]):
    """Add constraints, all or none; gives how many still hold something.

    Those whose earlier point has passed already hold nothing. Refused, naming the points, when
    one cannot be kept any more or would make points wait for each other.
    """

    wire_name = "tca.constrain"

    orders: tuple[Order, ...] = Field(min_length=1)


class SuspendTask(Query[TaskStatus]):
    """Suspend a task and all below it, or resume it.

    What is suspended is not given to a handler; handlers that run go on. It can still be killed.
    """

    wire_name = "tca.suspend"

    id: str = Field(pattern=TASK_ID_PATTERN)
    resume: bool = False


class PrioritizeTask(Query[TaskStatus]):
    """Change the priority of a task; what waits is put in order again."""

    wire_name = "tca.prioritize"

    id: str = Field(pattern=TASK_ID_PATTERN)
    priority: int


class RetryTask(Query[TaskStatus]):
    """Stop what runs of a living task and below it, and have it handled again."""

    wire_name = "tca.retry"

    id: str = Field(pattern=TASK_ID_PATTERN)


class Attached(BaseModel):
    """An attachment and what it is attached to: a task, or all tasks of a message."""

    model_config = ConfigDict(frozen=True)

    to_task: str | None
    to_message: str | None
    what: Attachment


class Attach(Query[Attached]):
    """Attach a tap, an exception handler or a clean-up to a task or to a message.

    What is attached to a message ends with the module that attached it. Attached twice under one
    id it is there once.
    """

    wire_name = "tca.attach"

    to_task: str | None = Field(default=None, pattern=TASK_ID_PATTERN)
    to_message: str | None = None
    what: Attachment


class Detach(Query[bool]):
    """Take an attachment away again; gives whether it was there."""

    wire_name = "tca.detach"

    id: str = Field(pattern=ATTACHMENT_ID_PATTERN)


class ListAttachments(Query[list[Attached]]):
    """The attachments to messages, and those to tasks that are alive."""

    wire_name = "tca.attachments"


class Trigger(Query[bool]):
    """The module that tests a monitor's condition to central: it is satisfied.

    ``number`` counts the satisfied tests of one attempt from 1, so that one told twice counts
    once. Gives whether the monitor goes on.
    """

    wire_name = "tca.trigger"

    id: str = Field(pattern=TASK_ID_PATTERN)
    attempt: int = Field(ge=1)
    number: int = Field(ge=1)
    data: dict[str, Any] = Field(default_factory=dict)


class Relation(enum.StrEnum):
    """Where a task stands to another in the tree."""

    PARENT = "parent"
    TOP_LEVEL = "top_level"
    """The ancestor just below the root, perhaps the task itself."""
    ANCESTOR = "ancestor"
    """The nearest above with the given name."""
    CHILD = "child"
    """The first child with the given name."""
    FIRST_CHILD = "first_child"
    LAST_CHILD = "last_child"
    NEXT = "next"
    """The sibling sent after it; taps are passed over."""
    PREVIOUS = "previous"
    FAILED = "failed"
    """From an exception handler's node, the task that failed."""
    TAPPED = "tapped"
    """From a tap's listener node, the task that is tapped."""


class FindRelative(Query[TaskStatus | None]):
    """Walk the tree: the task that stands in a relation to ``id``; None when there is none."""

    wire_name = "tca.relative"

    id: str = Field(pattern=TASK_ID_PATTERN)
    relation: Relation
    name: str | None = None
