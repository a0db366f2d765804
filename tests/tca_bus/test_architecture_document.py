"""The map of the bus in docs/architecture.md names every file, and none that is not there."""

from __future__ import annotations

import re
from configparser import ConfigParser
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[2]
BUS = ROOT / "tca_bus"


def named(pattern: str) -> set[str]:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = text.split("### Where what is")[1].split("\n## ")[0]
    rows = [line.split("|")[2] for line in section.splitlines() if line.startswith("| ")][1:]
    return {name for row in rows for name in re.findall(pattern, row)}


def modules() -> set[str]:
    found = {path.stem for path in BUS.glob("*.py")} - {"__init__"}
    return found | {path.parent.name for path in BUS.glob("*/__init__.py")}


def test_each_file_has_its_place():
    names = named(r"`([\w*/]+)`")
    assert sorted(m for m in modules() if not any(fnmatch(m, name) for name in names)) == []


def test_each_name_is_a_file():
    names = {name for name in named(r"`([\w*/]+)`") if "/" not in name}
    assert sorted(n for n in names if not any(fnmatch(m, n) for m in modules())) == []
    deep = {name for name in named(r"`([\w/]+)`") if "/" in name}
    assert sorted(name for name in deep if not (BUS / f"{name}.py").exists()) == []


def test_what_is_called_pure_is_held_to_it():
    rules = ConfigParser()
    rules.read(ROOT / ".importlinter", encoding="utf-8")
    held = rules["importlinter:contract:pure"]["source_modules"].split()
    pure = {f"tca_bus.{name.split('/')[0]}" for name in named(r"\*`([\w/]+)`\*")}
    in_map = {name for name in held if name.count(".") == 1}
    assert pure == in_map
