"""What the documents tell people to type is what the commands take."""

from __future__ import annotations

import importlib
import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
APPS = {
    "navigate": "navigate.cli",
    "rogue": "rogue.cli",
    "tca": "tca_bus.cli.tca",
    "xavier": "xavier_sim.cli",
}
COMMAND = re.compile(r"(?:^|uv run |run --rm cli )((?:rogue|tca|navigate|xavier) [^#&|]+)")


def commands(path):
    text = path.read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
    spans = re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text)
    for line in [*blocks.splitlines(), *spans]:
        found = COMMAND.search(line)
        if found and re.match(r"\w+ [a-z]", found[1]):
            yield found[1].strip()


ALL = sorted({command for path in DOCUMENTS for command in commands(path)})


def test_the_documents_show_commands():
    assert any(command.startswith("rogue request") for command in ALL)


@pytest.mark.parametrize("command", ALL)
def test_a_shown_command_is_understood(command):
    tool, *tokens = shlex.split(command)
    app = importlib.import_module(APPS[tool]).app
    app.parse_args(tokens, exit_on_error=False, print_error=False)
    names, _, _ = app.parse_commands(tokens)
    assert names


def test_shown_scripts_exist():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    scripts = re.findall(r"`(?:bash|uv run python) (\S+)`", text)
    assert scripts
    assert not [script for script in scripts if not (ROOT / script).exists()]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", path.read_text(encoding="utf-8"))
    assert not [link for link in links if not (path.parent / link).exists()]
