"""The programs of the documents do what their pages say."""

from __future__ import annotations

import pytest
from page_programs import programs, run_tests

SCRIPTS = programs("guide.md")
PLANS = programs("planner.md")
TEST_FILES = programs("testing.md")

pytestmark = [pytest.mark.bus, pytest.mark.process]


def named(program):
    return f"{program.page}-{program.number}"


@pytest.mark.parametrize("program", SCRIPTS, ids=named)
async def test_a_script_does_what_its_page_says(program, tmp_path):
    code, output, complaints = await program.run(tmp_path)
    assert code == 0, output + complaints
    if program.output is not None:
        assert output == program.output, complaints


@pytest.mark.parametrize("program", PLANS, ids=named)
def test_a_planning_program_prints_what_its_page_says(program, tmp_path):
    assert program.run_here(tmp_path) == program.output


async def test_the_test_files_of_a_page_pass(tmp_path):
    code, output, complaints = await run_tests(TEST_FILES, tmp_path)
    assert code == 0, output + complaints


def test_every_page_has_its_programs():
    assert len(SCRIPTS) >= 11
    assert len(PLANS) >= 11
    assert len(TEST_FILES) >= 3
    assert not any(one.is_test_file or not one.output for one in [*SCRIPTS, *PLANS])
    assert all(program.is_test_file for program in TEST_FILES)
