"""The programs that a page of the documents shows, and how they are run."""

from __future__ import annotations

import asyncio
import contextlib
import io
import re
import runpy
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

DOCUMENTS = Path(__file__).parents[2] / "docs"

FILE = re.compile(r"```\w+ (?P<name>\S+)\n(?P<text>.*?)```", re.DOTALL)
PROGRAM = re.compile(r"```python\n(?P<source>.*?)```(?:\n+```text\n(?P<output>.*?)```)?", re.DOTALL)

SETTINGS = "[pytest]\nasyncio_mode = auto\nasyncio_default_fixture_loop_scope = function\n"

PYTEST = ("-m", "pytest", "-q", "-p", "no:xdist", "-W", "error")


@dataclass(frozen=True)
class Program:
    """A program of a page.

    ``output`` is what the page says that it prints, ``files`` what the page says to save before,
    by name.
    """

    page: str
    number: int
    source: str
    output: str | None
    files: tuple[tuple[str, str], ...] = ()

    @property
    def is_test_file(self) -> bool:
        return "def test_" in self.source

    def save(self, folder: Path) -> Path:
        """Write it, and the files that belong to it, into a folder."""
        name = f"test_shown_{self.number}.py" if self.is_test_file else "shown.py"
        (folder / name).write_text(self.source, encoding="utf-8")
        for name_of_file, text in self.files:
            (folder / name_of_file).write_text(text, encoding="utf-8")
        return folder / name

    async def run(self, folder: Path) -> tuple[int, str, str]:
        """Run it as a reader would; gives the exit code, the output and the complaints."""
        return await _python(str(self.save(folder)), folder=folder)

    def run_here(self, folder: Path) -> str:
        """Run one that needs no event loop in this process, which is quicker; gives its output."""
        output, path = io.StringIO(), self.save(folder)
        with (
            contextlib.chdir(folder),
            contextlib.redirect_stdout(output),
            mock.patch.object(sys, "path", [str(folder), *sys.path]),
        ):
            try:
                runpy.run_path(str(path), run_name="__main__")
            finally:
                for name, _ in self.files:
                    sys.modules.pop(Path(name).stem, None)
        return output.getvalue()


async def run_tests(programs: Sequence[Program], folder: Path) -> tuple[int, str, str]:
    """Run all that are test files, as a reader would who saved them in one folder."""
    for program in programs:
        program.save(folder)
    (folder / "pytest.ini").write_text(SETTINGS, encoding="utf-8")
    return await _python(*PYTEST, str(folder), folder=folder)


async def _python(*arguments: str, folder: Path) -> tuple[int, str, str]:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-W", "error", *arguments),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        cwd=folder,
    )
    output, complaints = await process.communicate()
    return process.returncode or 0, output.decode(), complaints.decode()


def programs(page: str) -> list[Program]:
    """The programs of a page, each with the block of output that follows it.

    A block with a name behind its language is a file that is there for all programs.
    """
    text = (DOCUMENTS / page).read_text(encoding="utf-8")
    files = tuple((match["name"], match["text"]) for match in FILE.finditer(text))
    found = PROGRAM.finditer(text)
    return [
        Program(page, number, match["source"], match["output"], files)
        for number, match in enumerate(found)
    ]
