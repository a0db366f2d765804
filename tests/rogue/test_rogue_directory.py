from __future__ import annotations

import signal
from pathlib import Path

import pytest

from rogue.errors import DirectoryError, UnknownNameError
from rogue.messages import Refusal
from rogue.requests import Directory, Person, load_directory, read_entries, reread_on_hangup
from tca_bus.testing import eventually


@pytest.fixture(scope="module")
def directory() -> Directory:
    return load_directory()


def test_rank_is_that_of_figure_6(directory):
    assert directory.rank("mitchell", "delivermail") == 5
    assert directory.rank("jhm", "deliverfax") > 5


def test_phrase_is_that_of_figure_6(directory):
    assert directory.phrase("mitchell", "delivermail") == "Tom Mitchell's mail delivery"


def test_every_item_of_the_papers_is_carried(directory):
    assert set(directory.items) == {
        "delivermail",
        "pickupmail",
        "deliverfax",
        "pickupfax",
        "pickupprintout",
        "pickupcoffee",
        "returnbook",
        "pickupbook",
        "recyclecan",
    }


def test_mail_comes_from_the_mail_room_and_goes_to_the_user(directory):
    ends = [directory.usual(end, "mitchell", "delivermail") for end in ("pickup", "deliver")]
    assert [end.value for end in ends] == ["r-5303", "r-5313"]
    assert directory.usual("pickup", "mitchell", "pickupmail").value == "r-5313"


def test_who_was_met_is_known_by_the_source_that_named_them(directory):
    own = Directory(read_entries())
    own.meet("tom", Person(name="Tom", room="r-5307", rank=0))
    usual = own.usual("deliver", "tom", "delivermail")
    assert (usual.value, usual.source) == ("r-5307", "finger")
    assert own.phrase("tom", "delivermail") == "Tom's mail delivery"


def test_whom_a_new_file_leaves_out_keeps_a_name_but_is_not_accepted(tmp_path):
    own, file = Directory(read_entries()), tmp_path / "people.yaml"
    file.write_text("services: {}\npeople: {}\nitems: {}")
    own.replace(read_entries(file))
    assert own.phrase("mitchell", "delivermail") == "mitchell's delivermail"
    with pytest.raises(UnknownNameError):
        own.person("mitchell")


async def test_the_file_is_read_again_on_hangup_and_a_bad_one_changes_nothing(tmp_path, caplog):
    own, file = Directory(read_entries()), tmp_path / "people.yaml"
    with reread_on_hangup(own, file):
        file.write_text("services: [")
        signal.raise_signal(signal.SIGHUP)
        await eventually(lambda: "the one read before counts" in caplog.text)
        assert own.listed("mitchell")
        file.write_text("services: {}\npeople: {tom: {name: Tom, rank: 0}}\nitems: {}")
        signal.raise_signal(signal.SIGHUP)
        await eventually(lambda: own.listed("tom"))
    assert not own.listed("mitchell")


def test_a_person_without_a_room_and_an_item_without_a_place_are_missing(tmp_path):
    file = tmp_path / "people.yaml"
    file.write_text(
        "services: {}\npeople: {tom: {name: Tom, rank: 0}}\n"
        "items: {parcel: {phrase: parcel, rank: 1, to: user}}"
    )
    own = load_directory(file)
    assert own.usual("pickup", "tom", "parcel") is None
    assert own.usual("deliver", "tom", "parcel") is None


def test_unknown_user_names_near_ones(directory):
    with pytest.raises(UnknownNameError, match="Did you mean 'mitchell'") as caught:
        directory.person("mitchel")
    assert caught.value.refusal is Refusal.UNKNOWN_USER
    assert caught.value.near[0] == "mitchell"


def test_unknown_item_with_nothing_near_lists_all(directory):
    with pytest.raises(UnknownNameError, match="There are: deliverfax, delivermail"):
        directory.item("xyzzy")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("people: [", "people directory"),
        ("services: {}\npeople: {}\nitems: {a: {phrase: b, rank: 1, from: x, to: user}}", "'x' is"),
        ("services: {}\npeople: {tom: {name: Tom}}\nitems: {}", "people.tom.rank"),
        ("services: {}\npeople: {a: {name: A, rank: 0, finger: b}}\nitems: {}", "login@HOST"),
        ("services: {}\npeople: {}\nitems: {}\ndefaults: {deadline: noon}", "30m or 1h30m"),
        ("just words", "the document: .*, got 'just words'"),
    ],
)
def test_a_directory_with_an_error_says_where(tmp_path: Path, text: str, problem: str):
    file = tmp_path / "people.yaml"
    file.write_text(text)
    with pytest.raises(DirectoryError, match=problem):
        load_directory(file)


def test_the_directory_in_the_documents_is_one(tmp_path: Path):
    text = (Path(__file__).parents[2] / "docs" / "requests.md").read_text(encoding="utf-8")
    file = tmp_path / "people.yaml"
    file.write_text(text.split("```yaml\n")[1].split("```")[0])
    entries = read_entries(file)
    assert entries.people["jones"].finger == "aj@cs.example.org"
    assert entries.items["parcel"].start is None
