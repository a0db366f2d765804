"""Writes a recording: messages as they were on the wire, and beside them what Foxglove shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import IO

from pydantic import BaseModel

from tca_bus import Payload, TaskStatus
from xavier_sim.messages import Sensors, Standing, TrueLocation
from xavier_sim.recording._channels import Channels, strict_json
from xavier_sim.recording._format import (
    BEGINNING,
    BELIEF,
    END,
    PROGRESS,
    TASKS,
    WIRE,
    Beginning,
    nanoseconds,
)
from xavier_sim.recording._heard import Belief, Progress
from xavier_sim.recording._schemas import viewer_schema
from xavier_sim.recording._views import Views
from xavier_sim.recording._wire_names import encode, wire_name


class Tape:
    """A recording that is being written to a binary stream, in the order of the calls.

    What was flushed can be read whatever happens after that. No clock, no thread: whoever runs a
    world in a plain loop can use it as it is.
    """

    def __init__(self, stream: IO[bytes], beginning: Beginning) -> None:
        self._channels, self._views = Channels(stream), Views(beginning)
        self._time = nanoseconds(beginning.time)
        self._put_model(BEGINNING, beginning)
        for topic, view in self._views.begin(self._time):
            self._channels.put_proto(topic, view, self._time)

    @property
    def written(self) -> int:
        """How many records there are."""
        return self._channels.written

    def sense(
        self, sensors: Sensors, truth: TrueLocation, standing: Sequence[Standing] = ()
    ) -> None:
        """A tick: what the robot sensed, where it really was, and who and what stood about."""
        self._time = max(self._time, nanoseconds(sensors.time))
        self._put_wire(sensors)
        self._put_wire(truth)
        for topic, view in self._views.sense(sensors, truth, standing):
            self._channels.put_proto(topic, view, self._time)

    def note(self, message: BaseModel, time: float) -> None:
        """Something else that the robot did or said, at a time in seconds since the epoch."""
        self._time = max(self._time, nanoseconds(time))
        self._put_wire(message)
        for topic, view in self._views.note(message, self._time):
            self._channels.put_proto(topic, view, self._time)

    def believe(self, belief: Belief) -> None:
        """What the navigator believes: heard at the last tick, and so is its time."""
        self._put_model(BELIEF, belief.state)
        for topic, view in self._views.believe(belief.state, self._time):
            self._channels.put_proto(topic, view, self._time)

    def advance(self, progress: Progress) -> None:
        """How the drive under way goes: heard at the last tick, and so is its time."""
        self._put_model(PROGRESS, progress.drive)

    def hear(self, status: TaskStatus) -> None:
        """The state of a task: heard at the last tick, and so is its time."""
        self._put_model(TASKS, status)

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._channels.flush()

    def finish(self, *, dropped: int) -> None:
        """Write how many messages were lost on the way here, and the indexes."""
        self.flush()
        told = {"records": str(self.written), "dropped": str(dropped)}
        self._channels.put_metadata(END, told)
        self._channels.finish()

    def _put_wire(self, message: BaseModel) -> None:
        kind = type(message)
        topic, schema = WIRE + wire_name(kind), viewer_schema(kind, wire_name(kind))
        self._channels.put_payload(topic, encode(message), schema, self._time)

    def _put_model(self, topic: str, message: BaseModel) -> None:
        kind = type(message)
        data = strict_json(Payload(message.model_dump_json().encode(), "application/json"))
        self._channels.put_json(topic, data, viewer_schema(kind, kind.__name__), self._time)
