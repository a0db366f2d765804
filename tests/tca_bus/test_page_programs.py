"""The programs of the documents do what their pages say."""

from __future__ import annotations

import pytest
from page_programs import programs

SCRIPTS = programs("guide.md")
PLANS = programs("planner.md")
TEST_FILES = programs("testing.md")
ALL = [*SCRIPTS, *PLANS, *TEST_FILES]

pytestmark = [pytest.mark.bus, pytest.mark.process]


@pytest.mark.parametrize("program", ALL, ids=lambda one: f"{one.page}-{one.number}")
async def test_a_program_does_what_its_page_says(program, tmp_path):
    code, output, complaints = await program.run(tmp_path)
    assert code == 0, output + complaints
    if program.output is not None:
        assert output == program.output, complaints


def test_every_page_has_its_programs():
    assert len(SCRIPTS) >= 11
    assert len(PLANS) >= 11
    assert len(TEST_FILES) >= 3
    assert not any(one.is_test_file or not one.output for one in [*SCRIPTS, *PLANS])
    assert all(program.is_test_file for program in TEST_FILES)
