"""The programs that a page of the documents shows, and how they are run."""

from __future__ import annotations

import asyncio
import re
import sys
from dataclasses import dataclass
from pathlib import Path

DOCUMENTS = Path(__file__).parents[2] / "docs"

FILE = re.compile(r"```\w+ (?P<name>\S+)\n(?P<text>.*?)```", re.DOTALL)
PROGRAM = re.compile(r"```python\n(?P<source>.*?)```(?:\n+```text\n(?P<output>.*?)```)?", re.DOTALL)

SETTINGS = "[pytest]\nasyncio_mode = auto\nasyncio_default_fixture_loop_scope = function\n"

STRICT = (sys.executable, "-W", "error")
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

    async def run(self, folder: Path) -> tuple[int, str, str]:
        """Run it as a reader would; gives the exit code, the output and the complaints."""
        path = folder / ("test_shown.py" if self.is_test_file else "shown.py")
        path.write_text(self.source, encoding="utf-8")
        for name, text in self.files:
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "pytest.ini").write_text(SETTINGS, encoding="utf-8")
        arguments = (*PYTEST, str(folder)) if self.is_test_file else (str(path),)
        process = await asyncio.create_subprocess_exec(
            *(*STRICT, *arguments),
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
