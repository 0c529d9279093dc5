# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags that are elsewhere: in an archive, behind a URL, or nowhere."""

from __future__ import annotations

import zipfile
from contextlib import suppress
from pathlib import Path

import pytest
from ros import ROOT

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, place
from hijack_detect.evaluation.scores.evaluate import run_case
from hijack_detect.evaluation.trials.corpus import corpus_cases
from hijack_detect.monitor.policies import MonitorParameters

pytest.importorskip("upath", reason="the extra corpora is not installed")

BAG = ROOT / "bags/curved_8"


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    """Two flights in a zip file."""
    path = tmp_path / "flights.zip"
    with zipfile.ZipFile(path, "w") as made:
        for name in ("one", "two"):
            for file in sorted(BAG.iterdir()):
                made.write(file, f"{name}/{file.name}")
    return path


def test_a_path_is_a_path() -> None:
    assert place("some/where") == Path("some/where")
    assert place("odd:name::x") == Path("odd:name::x")


def test_a_bag_in_an_archive_is_read_where_it_is(archive: Path) -> None:
    url = f"zip://one::file://{archive}"
    with BagReader(url) as there, BagReader(BAG) as here:
        assert str(there.path) == url
        assert there.message_counts == here.message_counts
        assert list(there.messages({"/gps/fix"})) == list(here.messages({"/gps/fix"}))


def test_the_flights_of_an_archive_are_a_corpus(archive: Path) -> None:
    cases = corpus_cases(place(f"zip://::file://{archive}"))
    (local,) = corpus_cases(BAG)
    assert [(case.name, case.kind) for case in cases] == [("one", local.kind), ("two", local.kind)]
    assert str(archive) in repr(cases[0])
    outcome = run_case(MonitorParameters(), cases[0])
    assert outcome.methods == run_case(MonitorParameters(), local).methods


@pytest.mark.parametrize("name", ["../escaped/bag", "/escaped/bag", "one/../../escaped/bag"])
def test_nothing_of_an_archive_is_written_anywhere(tmp_path: Path, name: str) -> None:
    inner = tmp_path / "a/b"
    inner.mkdir(parents=True)
    path = inner / "flights.zip"
    with zipfile.ZipFile(path, "w") as made:
        for file in sorted(BAG.iterdir()):
            made.write(file, f"{name}/{file.name}")
    before = sorted(tmp_path.rglob("*"))
    with suppress(BagError):
        corpus_cases(place(f"zip://::file://{path}"))
    with suppress(BagError), BagReader(f"zip://{name}::file://{path}") as reader:
        list(reader.messages({"/gps/fix"}))
    assert sorted(tmp_path.rglob("*")) == before
    assert not Path("/escaped").exists()


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("nosuch://there/bag", "cannot be used: Unsupported filesystem: 'nosuch'"),
        ("s3://there/bag", "needs more to be installed, see the extra 'corpora': Install s3fs"),
        ("zip://bag::file:///nowhere.zip", "cannot be used"),
    ],
)
def test_a_url_that_cannot_be_used_is_named(url: str, why: str) -> None:
    with pytest.raises(BagError) as caught:
        place(url)
    assert str(caught.value).startswith(f"{url}: {why}")
