"""Recordings of what the robot senses and does: written, shown, and played again."""

from xavier_sim.recording._format import Beginning, Entry, RecordingFileError
from xavier_sim.recording._heard import Belief, Progress
from xavier_sim.recording._listening import listening
from xavier_sim.recording._reader import RecordingReader
from xavier_sim.recording._recorded_robot import RecordedRobot
from xavier_sim.recording._recorder import Recorder
from xavier_sim.recording._retrace import RetraceError, retrace
from xavier_sim.recording._tape import Tape
from xavier_sim.recording._ticks import Tick, ticks_of
from xavier_sim.recording._wire_names import decode

__all__ = [
    "Beginning",
    "Belief",
    "Entry",
    "Progress",
    "RecordedRobot",
    "Recorder",
    "RecordingFileError",
    "RecordingReader",
    "RetraceError",
    "Tape",
    "Tick",
    "decode",
    "listening",
    "retrace",
    "ticks_of",
]
