# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The direction of imports: a part of the package imports only what lies below it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from ros import ROOT

PACKAGE = ROOT / "hijack_detect"

STANDS_ON: Mapping[str, tuple[str, ...]] = {
    "contract": (),
    "parameters": (),
    "yaml_text": (),
    "streams": ("contract", "parameters", "yaml_text"),
    "estimation": ("streams",),
    "detectors": ("estimation",),
    "spoofing": ("estimation",),
    "simulation": ("estimation",),
    "bags": ("streams",),
    "logs": ("bags", "estimation"),
    "recording": ("bags", "monitor"),
    "live": ("monitor",),
    "mavlink": ("logs", "monitor"),
    "px4": ("logs",),
    "monitor": ("detectors",),
    "replay": ("monitor", "spoofing", "simulation", "bags"),
    "analysis": ("replay", "logs"),
    "evaluation": ("analysis",),
    "nodes": ("replay", "recording", "live", "mavlink", "px4"),
    "cli": ("nodes", "evaluation"),
}
"""Each folder and each file at the top of the package, and what lies directly below it."""

MODULES = sorted(PACKAGE.rglob("*.py"))
LONGEST = 500

WITH_ROS = {"nodes", "cli"}
ROS = {"launch", "launch_ros", "rosidl_runtime_py"}


def below(room: str) -> set[str]:
    """Everything that a room may import of the package, at any depth."""
    found = set(STANDS_ON[room])
    return found.union(*(below(one) for one in found))


def imports(path: Path) -> Iterator[tuple[int, str]]:
    """Line and full name of whatever a module imports, inside functions and for types too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.module and not node.level, f"{path}:{node.lineno}: a relative import"
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


def imported(room: str) -> Iterator[tuple[str, str]]:
    """Place and name of what the modules of a room import."""
    folder = PACKAGE / room
    for path in sorted(folder.rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]:
        for line, name in imports(path):
            yield f"{path.relative_to(ROOT)}:{line}", name


def needs_ros(name: str) -> bool:
    """Whether a module comes with a ROS installation only: rclpy, launch, and the messages."""
    top, *rest = name.split(".")
    messages = len(rest) > 0 and rest[0] in {"msg", "srv", "action"}
    return top.startswith("rclpy") or top in ROS or messages


def test_every_room_has_its_floor() -> None:
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    files = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}
    assert rooms | files == set(STANDS_ON)


@pytest.mark.parametrize("room", STANDS_ON)
def test_a_room_imports_only_what_lies_below_it(room: str) -> None:
    allowed = {room, "__version__", *below(room)}
    ours = [(place, name.split(".")) for place, name in imported(room)]
    upward = [
        f"{place}: {'.'.join(name)}"
        for place, name in ours
        if name[0] == PACKAGE.name and name[1] not in allowed
    ]
    assert upward == []


@pytest.mark.parametrize("room", [one for one in STANDS_ON if one not in WITH_ROS])
def test_only_nodes_and_commands_need_ros(room: str) -> None:
    assert [f"{place}: {name}" for place, name in imported(room) if needs_ros(name)] == []


def test_the_nodes_need_ros_so_that_the_test_above_can_fail() -> None:
    assert any(needs_ros(name) for _, name in imported("nodes"))


def test_a_file_is_one_thing_of_at_most_500_lines() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in MODULES}
    assert {path.name: lines for path, lines in lengths.items() if lines > LONGEST} == {}
