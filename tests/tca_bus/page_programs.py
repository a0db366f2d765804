"""The programs that a page of the documents shows, and how they are run."""

from __future__ import annotations

import asyncio
import re
import sys
from dataclasses import dataclass
from pathlib import Path

DOCUMENTS = Path(__file__).parents[2] / "docs"

PROGRAM = re.compile(r"```python\n(?P<source>.*?)```(?:\n+```text\n(?P<output>.*?)```)?", re.DOTALL)

SETTINGS = "[pytest]\nasyncio_mode = auto\nasyncio_default_fixture_loop_scope = function\n"

STRICT = (sys.executable, "-W", "error")
PYTEST = ("-m", "pytest", "-q", "-p", "no:xdist", "-W", "error")


@dataclass(frozen=True)
class Program:
    """A program of a page; ``output`` is what the page says that it prints."""

    page: str
    number: int
    source: str
    output: str | None

    @property
    def is_test_file(self) -> bool:
        return "def test_" in self.source

    async def run(self, folder: Path) -> tuple[int, str, str]:
        """Run it as a reader would; gives the exit code, the output and the complaints."""
        path = folder / ("test_shown.py" if self.is_test_file else "shown.py")
        path.write_text(self.source, encoding="utf-8")
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
    """The programs of a page, each with the block of output that follows it."""
    text = (DOCUMENTS / page).read_text(encoding="utf-8")
    found = PROGRAM.finditer(text)
    return [
        Program(page, number, match["source"], match["output"])
        for number, match in enumerate(found)
    ]
