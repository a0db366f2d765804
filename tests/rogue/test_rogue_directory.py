from __future__ import annotations

from pathlib import Path

import pytest

from rogue.errors import DirectoryError, UnknownNameError
from rogue.messages import Refusal
from rogue.requests import Directory, load_directory


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
    assert directory.ends("mitchell", "delivermail") == ("r-5303", "r-5313")
    assert directory.ends("mitchell", "pickupmail") == ("r-5313", "r-5303")


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
        ("services: {}\npeople: {tom: {name: Tom}}\nitems: {}", "people.tom.room"),
        ("just words", "the document: .*, got 'just words'"),
    ],
)
def test_a_directory_with_an_error_says_where(tmp_path: Path, text: str, problem: str):
    file = tmp_path / "people.yaml"
    file.write_text(text)
    with pytest.raises(DirectoryError, match=problem):
        load_directory(file)
