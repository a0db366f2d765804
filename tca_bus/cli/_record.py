"""``tca record`` and ``tca replay``: what passes on the bus, in a file, and back."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags

Keys = Annotated[tuple[str, ...], Parameter(negative="")]


async def record(
    file: Path,
    /,
    *key: str,
    duration: Annotated[float | None, Parameter(validator=Number(gt=0))] = None,
    force: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Record what passes on the realm into an MCAP file, until Ctrl-C.

    Informs, broadcasts (sensors among them), task states and the comings and goings of modules;
    not queries, which go to one module each. Foxglove opens the file; 'tca replay' replays it.

    Parameters
    ----------
    file
        Where to; it must not be there yet.
    key
        Record only these: names of messages, the words inform, broadcast, task and presence, or
        key expressions without the realm, such as 'broadcast/**'.
    duration
        End by itself after so many wall seconds.
    force
        Write over a file that is there.
    """
    from tca_bus.cli import _recordings  # noqa: PLC0415 - other commands do not pay for MCAP

    await _recordings.write_recording(file, key, duration=duration, force=force, flags=flags)


async def replay(
    file: Path,
    /,
    *,
    speed: str = "1",
    only: Keys = (),
    remap: Keys = (),
    skip: Annotated[float, Parameter(validator=Number(gte=0))] = 0.0,
    presence: Annotated[bool, Parameter(negative="")] = False,
    info: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Replay a recording on the realm, whichever it was recorded on.

    Everything goes under the names of those who sent it, with the timing that it had.

    Parameters
    ----------
    file
        The recording.
    speed
        How many times as fast as it was; max is as fast as the bus takes it.
    only
        Replay only these; as for 'tca record', may be given more than once.
    remap
        OLD=NEW: what begins with the key OLD goes to NEW; may be given more than once.
    skip
        Leave out so many seconds of the beginning.
    presence
        Let the recorded modules appear on the bus too; others may call them, in vain.
    info
        Only say what is in the recording.
    """
    from tca_bus.cli import _recordings  # noqa: PLC0415 - other commands do not pay for MCAP

    if info:
        await asyncio.to_thread(_recordings.show_info, file, flags)
        return
    await _recordings.replay_recording(
        file, speed=speed, keys=only, remap=remap, skip=skip, presence=presence, flags=flags
    )
