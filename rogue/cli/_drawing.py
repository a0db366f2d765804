"""Drawings of goal trees in files."""

from __future__ import annotations

from pathlib import Path

from rogue.explain import draw_svg
from rogue.prodigy import GoalTree
from tca_bus import ConfigError


def write_drawing(path: Path, tree: GoalTree, *, title: str) -> None:
    """Draw a tree into a file; whoever reads the file sees the old drawing or the new one.

    Raises:
        ConfigError: The file cannot be written.
    """
    drawing, new = draw_svg(tree, title=title), path.with_name(f"{path.name}.new")
    try:
        new.write_text(drawing, encoding="utf-8")
        new.replace(path)
    except OSError as error:
        raise ConfigError("--svg", str(path), f"a file that can be written ({error})") from error
