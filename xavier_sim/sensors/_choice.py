"""Which ray caster a world uses."""

from __future__ import annotations

from typing import Literal

from tca_bus import ConfigError
from xavier_sim.sensors._caster import Caster, Floats
from xavier_sim.sensors._compiling import can_compile
from xavier_sim.sensors._rays import RayCaster

Rays = Literal["auto", "numba", "numpy"]
"""What casts the rays: ``auto`` is numba where it is installed. The distances are the same."""


def make_caster(rays: Rays, segments: Floats, reach: float) -> Caster:
    """A caster for segments of shape (n, 4), metres, and rays of ``reach`` metres at most.

    The compiled one takes seconds to make where it was never made before.

    Raises:
        ConfigError: numba is asked for and not installed.
    """
    if rays == "numpy" or (rays == "auto" and not can_compile()):
        return RayCaster(segments, reach)
    if not can_compile():
        raise ConfigError("rays", rays, "numpy or auto, as numba (the extra 'fast') is missing")
    # Numba takes a second to import: only those who use it wait for that.
    from xavier_sim.sensors._grid import GridCaster  # noqa: PLC0415

    return GridCaster(segments, reach)
