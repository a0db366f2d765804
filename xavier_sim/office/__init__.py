"""The people in the office, and the speech board and keyboard that they use."""

from xavier_sim.office._keyboard import Keyboard
from xavier_sim.office._people import Habits
from xavier_sim.office._speech_module import SimulatedPeople, SpeechModule, Typist
from xavier_sim.office._spoken_record import RecordFile
from xavier_sim.office._things import NotMovedError

__all__ = [
    "Habits",
    "Keyboard",
    "NotMovedError",
    "RecordFile",
    "SimulatedPeople",
    "SpeechModule",
    "Typist",
]
