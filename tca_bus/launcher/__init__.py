"""What stands behind ``rogue up``: processes started in order, kept running, ended cleanly."""

from tca_bus.launcher._errors import (
    GaveUpError,
    LauncherError,
    NoPortError,
    PortInUseError,
    StartFailedError,
    WrongUseError,
)
from tca_bus.launcher._keys import provide_keys
from tca_bus.launcher._office import Launcher
from tca_bus.launcher._ports import free_port
from tca_bus.launcher._ready import ModulePresent, Ready, RouterListening
from tca_bus.launcher._restart import RestartPolicy
from tca_bus.launcher._spec import ProcessSpec

__all__ = [
    "GaveUpError",
    "Launcher",
    "LauncherError",
    "ModulePresent",
    "NoPortError",
    "PortInUseError",
    "ProcessSpec",
    "Ready",
    "RestartPolicy",
    "RouterListening",
    "StartFailedError",
    "WrongUseError",
    "free_port",
    "provide_keys",
]
