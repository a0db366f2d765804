"""Rules of the house that neither ruff nor import-linter can see."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import tca_bus
import tca_bus.cli

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


@pytest.mark.parametrize("facade", [tca_bus, tca_bus.cli], ids=lambda facade: facade.__name__)
def test_a_lazy_facade_gives_what_type_checkers_see(facade):
    tree = ast.parse(Path(facade.__file__).read_text(encoding="utf-8"))
    lazy = {f"{facade.__name__}.{home}": names for home, names in facade._HOMES.items()}
    assert lazy == checked_imports(tree)
    assert sorted(facade.__all__) == sorted(name for names in lazy.values() for name in names)
    for home, names in lazy.items():
        for name in names:
            assert getattr(facade, name) is getattr(importlib.import_module(home), name)
    with pytest.raises(AttributeError, match=f"'{facade.__name__}' has no attribute 'Modul'"):
        facade.Modul  # noqa: B018 - it is to raise


COMMAND_LINES = ["tca_bus.cli.tca", "rogue.cli", "xavier_sim.cli", "navigate.cli"]


@pytest.mark.parametrize("module", COMMAND_LINES)
def test_help_loads_neither_bus_nor_models(module):
    code = f"""
        import sys
        from {module} import app
        app(["--help"])
        print(*sys.modules)
    """
    loaded = run_python(textwrap.dedent(code)).splitlines()[-1].split()
    assert not {"asyncio", "zenoh", "pydantic", "numpy"} & set(loaded)


@pytest.mark.parametrize("module", COMMAND_LINES)
def test_the_summary_of_a_command_is_how_its_docstring_begins(module):
    app = importlib.import_module(module).app
    told = {name: app._commands[name].help for name in app if not name.startswith("-")}
    for name, summary in told.items():
        command = app[name]
        if command.default_command is None:
            continue  # one with commands of its own has no docstring
        command.help = None
        assert command.help.split("\n\n")[0].split() == summary.split()


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


WAITS_ON_PURPOSE = {
    "tests/chaos/chaos_crew.py": "work takes its time, and who does it is killed meanwhile",
    "tests/chaos/chaos_run.py": "a kill comes at any moment",
    "tests/links/test_links.py": "a link is cut for ten seconds",
    "tests/scenarios/test_scenario_repeatable.py": "a day is the same on a slow machine",
    "tests/xavier_sim/test_xavier_bus.py": "a drive is the same with a slow driver",
}


def waits_for_a_time(node):
    if not isinstance(node, ast.Call):
        return False
    name, seconds = ast.unparse(node.func), [ast.unparse(one) for one in node.args]
    return name in {"asyncio.sleep", "time.sleep"} and seconds != ["0"]


def test_no_test_waits_for_a_time_but_where_slowness_is_its_subject():
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    waiting = {
        str(path.relative_to(ROOT))
        for path, text in texts.items()
        if ".sleep(" in text and any(map(waits_for_a_time, ast.walk(ast.parse(text))))
    }
    assert waiting == WAITS_ON_PURPOSE.keys()
