"""Logs of processes go to standard error, for people or as JSON lines."""

from __future__ import annotations

import json
import logging
import subprocess
import sys

import pytest
import structlog

from tca_bus import ConfigError, configure_logging


@pytest.fixture(autouse=True)
def restored():
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    yield
    root.handlers[:] = handlers
    root.setLevel(level)
    structlog.reset_defaults()


def test_a_json_line_names_process_level_logger_and_time(capsys):
    configure_logging("rogue", json=True)
    logging.getLogger("tca_bus.router").warning("lost %d", 3)
    line = json.loads(capsys.readouterr().err)
    assert line["event"] == "lost 3"
    assert line["process"] == "rogue"
    assert line["level"] == "warning"
    assert line["logger"] == "tca_bus.router"
    assert line["timestamp"].endswith("Z")


def test_structlog_and_stdlib_go_the_same_way(capsys):
    configure_logging("rogue", json=True)
    structlog.get_logger("agent").info("planned", steps=4)
    line = json.loads(capsys.readouterr().err)
    assert (line["event"], line["steps"]) == ("planned", 4)


def test_late_logs_look_the_same_and_load_structlog_with_the_first_line():
    code = (
        "import sys, logging; from tca_bus import configure_logging;"
        "configure_logging('tca', json=True, late=True); print('structlog' in sys.modules);"
        "logging.getLogger('x').warning('lost %d', 3); print('structlog' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "True"]
    line = json.loads(run.stderr)
    assert (line["event"], line["process"], line["level"]) == ("lost 3", "tca", "warning")


def test_for_people_it_is_a_line_with_the_trace_of_an_error(capsys):
    configure_logging("rogue")
    logging.getLogger("x").error("failed", exc_info=ValueError("odd"))
    text = capsys.readouterr().err
    assert "failed" in text
    assert "ValueError: odd" in text


def test_what_is_below_the_level_is_left_out(capsys):
    configure_logging("rogue", level="warning")
    logging.getLogger("x").info("quiet")
    assert capsys.readouterr().err == ""


def test_an_unknown_level_is_told_with_near_names():
    with pytest.raises(ConfigError, match="Did you mean 'warning'"):
        configure_logging("rogue", level="warnin")
