"""Asks for what is to be drawn, and draws it into files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from navigate.messages import Outlook, ShowMap, ShowOutlook
from navigate.view import draw_svg
from tca_bus import ConfigError, HandlerFailedError, Module, NoHandlerError
from tca_bus.cli import note
from xavier_sim.messages import FloorPlan, ShowWorld, WorldView


@dataclass(frozen=True, slots=True)
class Scene:
    """All that a drawing shows; ``world`` is None for a robot that is no simulator's."""

    outlook: Outlook
    plan: FloorPlan
    world: WorldView | None


async def look(module: Module, plan: FloorPlan | None = None) -> Scene:
    """Ask navigator and simulator how things stand; the map only when it is not known yet."""
    known = plan if plan is not None else await module.query(ShowMap())
    return Scene(await module.query(ShowOutlook()), known, await _world(module))


async def draw_once(module: Module, path: Path) -> None:
    """Draw how things stand into a file, and say so.

    Raises:
        ConfigError: the file cannot be written.
    """
    scene = await look(module)
    write(scene, path)
    who = "simulator and navigator are" if scene.world else "the navigator is"
    note(f"{who} drawn in {path}")


def write(scene: Scene, path: Path) -> None:
    """Draw into a file; whoever reads it sees the old drawing or the new one.

    Raises:
        ConfigError: the file cannot be written.
    """
    drawing = draw_svg(scene.outlook, scene.plan, scene.world)
    try:
        new = path.with_name(f"{path.name}.new")
        new.write_text(drawing, encoding="utf-8")
        new.replace(path)
    except (OSError, ValueError) as error:
        raise ConfigError("--svg", str(path), f"a file that can be written ({error})") from error


async def _world(module: Module) -> WorldView | None:
    try:
        return await module.query(ShowWorld())
    except (NoHandlerError, HandlerFailedError):
        return None
