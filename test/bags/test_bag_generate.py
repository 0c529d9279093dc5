"""The bags of the project are made by the commands in their README."""

from pathlib import Path

import pytest

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.generate import make_bag
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.topics import PRESETS, detect

ROOT = Path(__file__).parents[2]


BAGS = {
    "curved_8": ("curved", 8, ()),
    "straight_3": ("straight", 3, ()),
    "curved_no_velocity_5": ("curved", 5, ("velocity", "mag")),
}


def messages(path: Path) -> list[RawMessage]:
    with BagReader(path) as bag:
        return list(bag.messages())


@pytest.mark.parametrize("name", BAGS)
def test_the_command_makes_the_bag(name: str, tmp_path: Path) -> None:
    """Message for message: the file's bytes also depend on the versions of rosbags and zstd."""
    route, seed, without = BAGS[name]
    make_bag(tmp_path / name, route, seed, 110.0, without=without)
    committed = ROOT / "bags" / name
    assert messages(tmp_path / name) == messages(committed)
    assert sum(file.stat().st_size for file in committed.iterdir()) < 3_000_000


@pytest.mark.parametrize("name", BAGS)
def test_the_readme_has_the_command(name: str) -> None:
    route, seed, without = BAGS[name]
    command = f"hijack-detect generate bags/{name} --route {route} --seed {seed}"
    command += "".join(f" --without {item}" for item in without)
    assert command in (ROOT / "bags" / "README.md").read_text().splitlines()


def test_same_bytes_twice(tmp_path: Path) -> None:
    for parent in ("a", "b"):
        make_bag(tmp_path / parent / "bag", "curved", 4, 60.0)
    for file in ("bag.mcap", "metadata.yaml"):
        first, second = (tmp_path / parent / "bag" / file for parent in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_topics() -> None:
    with BagReader(ROOT / "bags" / "curved_8") as bag:
        assert detect(bag.topics) == PRESETS["default"]
        assert set(bag.topics) == {
            *dict(PRESETS["default"].items()).values(),
            "/truth/fix",
            "/truth/attitude",
        }
    with BagReader(ROOT / "bags" / "curved_no_velocity_5") as bag:
        found = detect(bag.topics)
        assert found.velocity is None
        assert found.mag is None
        assert found.pressure == "/pressure"


@pytest.mark.parametrize(
    ("route", "seed", "duration", "without", "reason"),
    [
        ("round", 1, 110.0, (), "route is 'round'"),
        ("curved", -1, 110.0, (), "seed is -1"),
        ("curved", 1, 5.0, (), "duration is 5.0"),
        ("curved", 1, float("nan"), (), "duration is nan"),
        ("curved", 1, 110.0, ("imu",), "cannot leave out 'imu'"),
    ],
)
def test_what_cannot_be_made(
    tmp_path: Path, route: str, seed: int, duration: float, without: tuple[str, ...], reason: str
) -> None:
    with pytest.raises(BagError, match=reason):
        make_bag(tmp_path / "bag", route, seed, duration, without=without)
    assert not (tmp_path / "bag").exists()
