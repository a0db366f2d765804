"""Rules of the house that neither ruff nor import-linter can see."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import tca_bus

ROOT = Path(__file__).parent.parent
PACKAGES = ("navigate", "rogue", "tca_bus", "xavier_sim")
FACADES = sorted(
    path
    for package in PACKAGES
    for path in (ROOT / package).rglob("__init__.py")
    if "__all__" in path.read_text(encoding="utf-8")
)


def imported_names(tree):
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module not in {"__future__", "typing"}:
            yield from (alias.asname or alias.name for alias in node.names)


def checked_imports(tree):
    """What a facade imports for type checkers alone, by the modules that it comes from."""
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    return {node.module: tuple(alias.name for alias in node.names) for node in block.body}


def exported_names(tree):
    for node in tree.body:
        if isinstance(node, ast.Assign) and [ast.unparse(one) for one in node.targets] == [
            "__all__"
        ]:
            return ast.literal_eval(node.value)
    raise AssertionError("__all__ is no plain assignment")


@pytest.mark.parametrize("path", FACADES, ids=lambda path: str(path.parent.relative_to(ROOT)))
def test_a_facade_exports_what_it_imports_in_order(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    exported = exported_names(tree)
    assert sorted(set(exported)) == sorted(exported), "a name is exported twice"
    if not any(isinstance(node, ast.FunctionDef) for node in tree.body):
        public = {name for name in imported_names(tree) if not name.startswith("_")}
        assert set(exported) >= public, f"not exported: {sorted(public - set(exported))}"
    shouting = [name for name in exported if name.isupper()]
    classes = [name for name in exported if name[0].isupper() and not name.isupper()]
    functions = [name for name in exported if name[0].islower() or name.startswith("_")]
    assert exported == sorted(shouting) + sorted(classes) + sorted(functions)


def test_the_lazy_facade_gives_what_type_checkers_see():
    tree = ast.parse((ROOT / "tca_bus/__init__.py").read_text(encoding="utf-8"))
    lazy = {f"tca_bus.{home}": names for home, names in tca_bus._HOMES.items()}
    assert lazy == checked_imports(tree)
    assert sorted(tca_bus.__all__) == sorted(name for names in lazy.values() for name in names)
    for home, names in lazy.items():
        for name in names:
            assert getattr(tca_bus, name) is getattr(importlib.import_module(home), name)
    with pytest.raises(AttributeError, match="module 'tca_bus' has no attribute 'Modul'"):
        tca_bus.Modul  # noqa: B018 - it is to raise


IMPORT_ALL = """
import importlib, pkgutil, sys, threading

def forbid(event, arguments):
    writes = event == "open" and isinstance(arguments[1], str) and set(arguments[1]) & set("wax+")
    if writes and not str(arguments[0]).endswith(".pyc") and "__pycache__" not in str(arguments[0]):
        raise RuntimeError(f"{arguments[0]} is opened for writing at import")
    if event in {"socket.connect", "socket.bind", "subprocess.Popen", "os.fork", "os.system"}:
        raise RuntimeError(f"{event} at import")

names = []
for package in sys.argv[1:]:
    names.append(package)
    path = importlib.import_module(package).__path__
    names += [module.name for module in pkgutil.walk_packages(path, package + ".")]
sys.addaudithook(forbid)
for name in names:
    importlib.import_module(name)
running = [thread.name for thread in threading.enumerate()]
assert running == ["MainThread"], running
print(len(names))
"""


def run_python(code, *arguments):
    done = subprocess.run(
        [sys.executable, "-Bc", code, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_does_no_work():
    assert int(run_python(IMPORT_ALL, *PACKAGES)) > 50


def test_prodigy_loads_without_bus_and_event_loop():
    loaded = run_python("import rogue.prodigy, sys; print(*sys.modules)").split()
    assert not {"asyncio", "zenoh", "tca_bus", "navigate", "xavier_sim"} & set(loaded)


@pytest.mark.parametrize("package", PACKAGES)
def test_types_are_published(package):
    assert (ROOT / package / "py.typed").exists()
