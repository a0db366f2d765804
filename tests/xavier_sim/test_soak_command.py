"""``xavier soak``: figures, progress, and checkpoints from which it goes on."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from cyclopts import CycloptsError

from tca_bus import ConfigError, TcaError
from xavier_sim.cli import app
from xavier_sim.cli._soak_crew import Task, run_crew
from xavier_sim.cli._soak_flags import ErrandFlags, parse_seeds
from xavier_sim.snapshots import SnapshotError
from xavier_sim.soak import NavigatorError, SoakOptions, SoakRun, Summary, Totals

FLOOR = str(Path(__file__).parent / "soak_floor.yaml")
CONTRACT = [
    *("hours", "km", "jobs", "completed", "failed", "reasons", "false_arrivals", "bumps"),
    *("recoveries_per_km", "real_time_factor"),
]
STANDING = "soak_sleeper:Sleeper"
IDLE = {"floor": FLOOR, "seed": 1, "navigator": STANDING, "rays": "numpy"}


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
    assert " completed, 0 rightly given up, 0 wrong; " in err
    Summary.model_validate(document)


def test_the_table_names_reasons(capsys):
    command("--hours", "0.0005", "--map", FLOOR, "--navigator", IDLE["navigator"])
    out, _ = capsys.readouterr()
    assert "asleep" in out
    assert "recoveries per km" in out


def test_failures_are_explained_on_the_terminal_the_first_ten_of_them(capsys):
    command("--hours", "0.02", "--map", FLOOR, "--navigator", STANDING, "--shut", "0")
    out, _ = capsys.readouterr()
    told = [line for line in out.splitlines() if line.startswith("job ")]
    assert len(told) == 10
    assert re.match(r"job 0 at 0\.00 h, hall to r-\d: gave r-\d up as asleep: stood", told[0])
    jobs = int(re.search(r"^jobs +(\d+)", out, re.MULTILINE)[1])
    assert out.splitlines()[-1] == f"... and {jobs - 10} more"


@pytest.mark.process
@pytest.mark.timeout(120)
def test_seeds_are_soaked_side_by_side_and_added_up(capsys, tmp_path):
    page, kept = tmp_path / "soak.html", tmp_path / "soak.json"
    files = ("--report", str(page), "--checkpoint", str(kept), "--json", "--jobs", "2")
    what = ("--hours", "0.001", "--map", FLOOR, "--navigator", STANDING)
    command("--seeds", "4,2", *what, *files)
    out, err = capsys.readouterr()
    totals = Totals.model_validate_json(out)
    assert [one.options.seed for one in totals.seeds] == [4, 2]
    assert totals.total.jobs == sum(one.jobs for one in totals.seeds) >= 2
    assert "seed 4: " in err
    assert "seed 2: " in err
    assert "seeds 4, 2" in page.read_text()
    alone = SoakRun(SoakOptions(**{**IDLE, "seed": 2}), tmp_path / "soak-2.json")
    assert alone.resumed
    assert alone.outcome().summary().jobs == totals.seeds[1].jobs


@pytest.mark.parametrize("text", ["", "1,,2", "1,1", "-1", "1;2", "1.5", "\u00b2"])
def test_seeds_that_are_none_are_explained(text):
    with pytest.raises(ConfigError, match=r"--seeds.*each once, as in 1,2,3"):
        parse_seeds(text)


@pytest.mark.parametrize("file", [".", "nowhere/soak.html"])
@pytest.mark.parametrize("flag", ["--report", "--checkpoint"])
def test_what_cannot_be_written_is_told_before_the_soak(tmp_path, flag, file):
    with pytest.raises(ConfigError, match=rf"{flag} is .* expected a file in a folder"):
        command("--hours", "1", flag, str(tmp_path / file))


@pytest.mark.parametrize("fault", ["sonar-dead", "sonar-stuck"])
def test_a_fault_of_a_sensor_that_the_robot_has_not_is_told_before_the_soak(fault):
    with pytest.raises(ConfigError, match=rf"'{fault}', expected .* modern can have: camera, .*la"):
        command("--hours", "1", "--profile", "modern", "--fault", fault)


@pytest.mark.parametrize("hours", ["nan", "inf", "0", "-1"])
def test_hours_are_some_and_not_endless(hours):
    with pytest.raises(CycloptsError, match="--hours"):
        command("--hours", hours)


def test_one_seed_and_several_are_not_both_given():
    with pytest.raises(ConfigError, match="none beside --seeds"):
        command("--hours", "1", "--seed", "1", "--seeds", "1,2")


@pytest.mark.process
@pytest.mark.timeout(120)
def test_a_soak_that_fails_in_its_own_process_says_why(tmp_path):
    file = tmp_path / "soak.json"
    file.write_text("[]")
    with pytest.raises(SnapshotError, match="is no checkpoint of format") as caught:
        run_crew([Task(SoakOptions(**IDLE), 1.0, file)], jobs=1, tell=lambda _: None)
    assert caught.value.file == file


@pytest.mark.process
@pytest.mark.timeout(120)
def test_soaks_that_are_interrupted_end_after_their_job_and_are_kept(tmp_path):
    def interrupt(_standing):
        raise KeyboardInterrupt

    file, options = tmp_path / "soak.json", SoakOptions(**IDLE)
    with pytest.raises(KeyboardInterrupt):
        run_crew([Task(options, 100_000.0, file)], jobs=1, tell=interrupt)
    assert SoakRun(options, file).resumed


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
        ("[1]", "is no checkpoint of format 3"),
        ('{"format": 3}', "names no options of a soak"),
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


def test_what_casts_the_rays_makes_no_other_soak(tmp_path):
    file = tmp_path / "soak.json"
    list(SoakRun(SoakOptions(**IDLE), file).jobs(0.0005))
    document = json.loads(file.read_text())
    document["options"]["rays"] = "numba"
    file.write_text(json.dumps(document))
    assert SoakRun(SoakOptions(**IDLE), file).resumed


@pytest.mark.parametrize("part", [{}, {"world": None}, {"world": []}])
def test_a_checkpoint_cut_short_is_explained(tmp_path, part):
    file = tmp_path / "soak.json"
    list(SoakRun(SoakOptions(**IDLE), file).jobs(0.0005))
    document = json.loads(file.read_text())
    del document["soak"]["world"]
    document["soak"] |= part
    file.write_text(json.dumps(document))
    with pytest.raises(SnapshotError, match="is damaged"):
        SoakRun(SoakOptions(**IDLE), file)


def test_options_that_a_navigator_does_not_take_are_named():
    options = SoakOptions(**{**IDLE, "navigator_options": {"localizer": "particles"}})
    with pytest.raises(NavigatorError, match=r"takes no such options: .*localizer"):
        SoakRun(options)


@pytest.mark.parametrize("flag", ["--localizer", "--policy"])
def test_a_navigator_that_has_no_such_choice_is_named(flag):
    with pytest.raises(NavigatorError, match=rf"Sleeper' takes no such options: .*{flag[2:]}"):
        command("--hours", "1", "--map", FLOOR, "--navigator", STANDING, flag, "qmdp")


def test_how_a_lost_robot_picks_its_way_is_handed_on_where_it_is_given(capsys):
    assert ErrandFlags().options(0).navigator_options == {}
    command("--hours", "0.0005", "--map", FLOOR, "--policy", "qmdp", "--json")
    summary = Summary.model_validate_json(capsys.readouterr().out)
    assert summary.options.navigator_options == {"policy": "qmdp"}
    assert summary.navigator_settings == {"localizer": "pomdp", "policy": "qmdp"}
    with pytest.raises(TcaError, match="policy 'vote' is none of mls, qmdp, voting"):
        command("--hours", "1", "--map", FLOOR, "--policy", "vote")


def test_an_unknown_localizer_is_explained():
    options = SoakOptions(floor=FLOOR, navigator_options={"localizer": "particle"}, rays="numpy")
    with pytest.raises(TcaError, match=r"'particle' is none of .*particles"):
        SoakRun(options)


def test_what_came_of_doors_is_on_the_terminal_and_in_the_document(capsys):
    what = ("--map", FLOOR, "--navigator", STANDING, "--doors", "1", "--shut", "0")
    command("--hours", "0.0005", *what)
    out, _ = capsys.readouterr()
    assert re.search(r"^of all: given up +(\d+) of \1 \(100\.00 %\)", out, re.MULTILINE)
    command("--hours", "0.0005", *what, "--json")
    doors = json.loads(capsys.readouterr().out)["doors"]
    assert doors["drives"] == doors["stuck"] == doors["given_up"] >= 1
    assert (doors["stuck_share"], doors["recovered_share"], doors["given_up_share"]) == (1, 0, 1)


def test_doors_can_be_tried_in_turn():
    run = SoakRun(SoakOptions(**{**IDLE, "doors_in_and_out": 2}))
    goals = [job.goal for job in run.jobs(1.0)]
    rooms = ("r-1", "r-2", "r-3")
    assert goals == [goal for room in rooms for goal in [room, f"before {room}"] * 2]
