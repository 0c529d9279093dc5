# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `sweep`, as it is typed."""

from __future__ import annotations

from pathlib import Path

import pytest
from command import hijack_detect

from hijack_detect.replay.simulated_bag import make_bag
from hijack_detect.simulation.plan import FlightPlan


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("corpus")
    make_bag(folder / "flight", FlightPlan("curved", duration_s=60.0), 4)
    return folder


def test_it_writes_a_table_and_a_picture(corpus: Path, tmp_path: Path) -> None:
    (corpus / "broken.mcap").write_bytes(b"no bag")
    done = hijack_detect("sweep", "mu", corpus, "-o", tmp_path / "new", "--jobs", "1")
    assert done.returncode == 0, done.stderr
    assert "broken.mcap" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    lines = (tmp_path / "new/mu.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("mu_deg,method,class,correct,flights")
    assert lines[-1].startswith("100,correlation,non-hijacked,1,1")
    assert (tmp_path / "new/mu.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("mu", "nowhere"), "nowhere"),
        (("mu", "nowhere", "--protocol", "feng2018"), "either a folder"),
        (("mu", "nowhere", "--scale", "2"), "either a folder"),
        (("attack", "nowhere"), "makes its own flights"),
        (("everything",), "everything"),
        (("mu", "-o", "/dev/null/folder"), "/dev/null/folder: cannot be made"),
    ],
)
def test_what_it_refuses(arguments: tuple[str, ...], said: str, tmp_path: Path) -> None:
    out = () if "-o" in arguments else ("-o", tmp_path)
    done = hijack_detect("sweep", *arguments, *out)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_flights_that_all_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "broken.mcap").write_bytes(b"no bag")
    done = hijack_detect("sweep", "mu", tmp_path, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert "broken.mcap" in done.stderr
