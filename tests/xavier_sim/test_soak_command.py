"""``xavier soak``: figures, progress, and checkpoints from which it goes on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tca_bus import TcaError
from xavier_sim.cli import app
from xavier_sim.snapshots import SnapshotError
from xavier_sim.soak import NavigatorError, SoakOptions, SoakRun, Summary

FLOOR = str(Path(__file__).parent / "soak_floor.yaml")
CONTRACT = [
    *("hours", "km", "jobs", "completed", "failed", "reasons", "false_arrivals", "bumps"),
    *("recoveries_per_km", "real_time_factor"),
]
IDLE = {"floor": FLOOR, "seed": 1, "navigator": "test_soak:Sleeper"}


def command(*tokens):
    app.parse_args(["soak", *tokens], exit_on_error=False, print_error=False)
    return app(["soak", *tokens], exit_on_error=False, result_action="return_value")


def test_the_document_has_the_figures_that_scripts_rely_on(capsys):
    command("--hours", "0.002", "--map", FLOOR, "--json")
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert list(document)[: len(CONTRACT)] == CONTRACT
    assert document["jobs"] == document["completed"] + document["failed"] >= 1
    assert document["hours"] >= 0.002
    assert "jobs completed" in err
    Summary.model_validate(document)


def test_the_table_names_reasons(capsys):
    command("--hours", "0.0005", "--map", FLOOR, "--navigator", IDLE["navigator"])
    out, _ = capsys.readouterr()
    assert "asleep" in out
    assert "recoveries per km" in out


def test_a_soak_goes_on_from_its_checkpoint(tmp_path):
    file = tmp_path / "soak.json"
    first = SoakRun(SoakOptions(**IDLE), file)
    done = len(list(first.jobs(0.002)))
    second = SoakRun(SoakOptions(**IDLE), file)
    assert second.resumed
    assert len(second.soak.course.tally.jobs) == done
    more = list(second.jobs(0.003))
    straight = SoakRun(SoakOptions(**IDLE))
    assert list(straight.jobs(0.003))[done:] == more
    assert straight.soak.snapshot() == second.soak.snapshot()
    assert second.cost.cpu > first.cost.cpu


def test_a_soak_that_is_left_keeps_what_was_done(tmp_path):
    file = tmp_path / "soak.json"
    for _ in SoakRun(SoakOptions(**IDLE), file).jobs(1.0):
        break
    assert len(SoakRun(SoakOptions(**IDLE), file).soak.course.tally.jobs) == 1


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "is no checkpoint of a soak"),
        ("[1]", "is no checkpoint of format 1"),
        ('{"format": 1}', "names no options of a soak"),
    ],
)
def test_a_file_that_is_no_checkpoint_is_explained(tmp_path, text, why):
    file = tmp_path / "soak.json"
    file.write_text(text)
    with pytest.raises(SnapshotError, match=why):
        SoakRun(SoakOptions(**IDLE), file)


def test_a_checkpoint_of_another_soak_is_refused(tmp_path):
    file = tmp_path / "soak.json"
    list(SoakRun(SoakOptions(**IDLE), file).jobs(0.0005))
    with pytest.raises(SnapshotError, match="is of a soak with seed 1, not 2"):
        SoakRun(SoakOptions(**{**IDLE, "seed": 2}), file)


def test_a_checkpoint_cut_short_is_explained(tmp_path):
    file = tmp_path / "soak.json"
    list(SoakRun(SoakOptions(**IDLE), file).jobs(0.0005))
    document = json.loads(file.read_text())
    del document["soak"]["world"]
    file.write_text(json.dumps(document))
    with pytest.raises(SnapshotError, match="is damaged"):
        SoakRun(SoakOptions(**IDLE), file)


def test_options_that_a_navigator_does_not_take_are_named():
    options = SoakOptions(**{**IDLE, "navigator_options": {"localizer": "particles"}})
    with pytest.raises(NavigatorError, match=r"takes no such options: .*localizer"):
        SoakRun(options)


def test_an_unknown_localizer_is_explained():
    options = SoakOptions(floor=FLOOR, navigator_options={"localizer": "particle"})
    with pytest.raises(TcaError, match=r"'particle' is none of .*particles"):
        SoakRun(options)


def test_doors_can_be_tried_in_turn():
    run = SoakRun(SoakOptions(**{**IDLE, "doors_in_and_out": 2}))
    goals = [job.goal for job in run.jobs(1.0)]
    rooms = ("r-1", "r-2", "r-3")
    assert goals == [goal for room in rooms for goal in [room, f"before {room}"] * 2]
