# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Python, what is installed beside this package, and its own shared files."""

from __future__ import annotations

import importlib.metadata
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from hijack_detect import __version__
from hijack_detect.cli.doctor.finding import Finding, Level

NAME = "hijack_detect"
FOLDERS = ("config", "launch", "bags")
WHEELS, TEST = "wheels", "test"


def python() -> Iterator[Finding]:
    """Check that the package supports this Python."""
    version = ".".join(map(str, sys.version_info[:3]))
    wanted = _metadata()["Requires-Python"] or ""
    if SpecifierSet(wanted).contains(version):
        yield Finding("Python", Level.OK, f"{version} in {sys.prefix}")
    else:
        mend = f"install a Python {wanted} and the package in it"
        yield Finding("Python", Level.FAIL, f"{version}, needed is {wanted}", mend)


def dependencies() -> Iterator[Finding]:
    """Each requirement of the installed package, and each extra as a whole."""
    needed, extras = requirements()
    wrong = [text for one in needed if (text := _problem(one))]
    for text in wrong:
        yield Finding("dependency", Level.FAIL, text, f"pip install '{text.split(':')[0]}'")
    if not wrong:
        yield Finding("dependencies", Level.OK, f"all {len(needed)} are installed")
    for extra, of in extras.items():
        if extra == TEST:
            continue
        missing = [text for one in of if (text := _problem(one))]
        if not missing:
            yield Finding(f"extra {extra}", Level.INFO, "installed")
        else:
            listed = ", ".join(text.split(":")[0] for text in missing)
            mend = f"pip install '.[{extra}]' in the folder of the package"
            yield Finding(f"extra {extra}", Level.INFO, f"not installed: {listed}", mend)


def requirements() -> tuple[list[Requirement], dict[str, list[Requirement]]]:
    """Requirements of this installation: always, and for each extra."""
    metadata = _metadata()
    lines = [Requirement(line) for line in metadata.get_all("Requires-Dist") or ()]
    always = [one for one in lines if _applies(one, "")]
    extras = {
        extra: [one for one in lines if not _applies(one, "") and _applies(one, extra)]
        for extra in metadata.get_all("Provides-Extra") or ()
    }
    return always, extras


def share(folder: Path, prefixes: str) -> Iterator[Finding]:
    """The package's shared files, and whether the ament index knows it.

    Args:
        folder: Where the shared files are looked for.
        prefixes: Value of AMENT_PREFIX_PATH, with the own prefix.
    """
    mend = (
        "install the package again: `make setup`, or `colcon build` and source install/setup.bash"
    )
    known = [Path(one) for one in prefixes.split(":") if one]
    marker = f"share/ament_index/resource_index/packages/{NAME}"
    if not any((one / marker).is_file() for one in known):
        text = f"AMENT_PREFIX_PATH has no {NAME} ({prefixes or 'empty'}): ros2 run does not find it"
        yield Finding("ament index", Level.WARN, text, f"export AMENT_PREFIX_PATH={sys.prefix}")
    else:
        yield Finding("ament index", Level.OK, f"knows {NAME}")
    missing = [name for name in FOLDERS if not any((folder / name).glob("*"))]
    if missing or not (folder / "package.xml").is_file():
        text = f"{folder}: has no {', '.join(missing) or 'package.xml'}"
        yield Finding("shared files", Level.FAIL, text, mend)
        return
    version = ElementTree.parse(folder / "package.xml").findtext("version")
    if version != __version__:
        text = f"{folder}: is of version {version}, the code of {__version__}"
        yield Finding("shared files", Level.FAIL, text, mend)
    else:
        yield Finding("shared files", Level.OK, f"{folder}, version {version}")


def installation(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Check that ROS comes from wheels or from a sourced installation, and not from both."""
    wheels = from_wheels()
    distro = environment.get("ROS_DISTRO", "")
    here = Path(sysconfig.get_path("purelib"))
    paths = [Path(one) for one in environment.get("PYTHONPATH", "").split(":") if one]
    foreign = [one for one in paths if (one / "rclpy").is_dir() and one != here]
    others = [
        one
        for one in environment.get("AMENT_PREFIX_PATH", "").split(":")
        if one.startswith("/opt/ros/") and one.rstrip("/") != "/opt/ros/jazzy"
    ]
    if distro and distro != "jazzy":
        mend = "open a new shell, and source /opt/ros/jazzy/setup.bash or nothing"
        yield Finding("ROS", Level.FAIL, f"ROS_DISTRO is {distro}, needed is jazzy", mend)
    elif others:
        text = f"AMENT_PREFIX_PATH has another distribution: {', '.join(others)}"
        yield Finding("ROS", Level.FAIL, text, "open a new shell, and source only jazzy")
    elif wheels and foreign:
        text = f"two: the wheels of {here}, and {', '.join(map(str, foreign))} in PYTHONPATH"
        yield Finding("ROS", Level.FAIL, text, "unset PYTHONPATH, or use a shell without ROS")
    elif wheels:
        yield Finding("ROS", Level.OK, "jazzy, from wheels")
    elif distro:
        yield Finding("ROS", Level.OK, "jazzy, from a sourced installation")
    else:
        mend = "source /opt/ros/jazzy/setup.bash, or pip install '.[wheels]'"
        yield Finding("ROS", Level.FAIL, "there is none in this shell", mend)


def from_wheels() -> bool:
    """Whether rclpy comes from a wheel of PyPI."""
    return _has_distribution("ros-jazzy-rclpy")


def _metadata() -> importlib.metadata.PackageMetadata:
    return importlib.metadata.distribution(NAME).metadata


def _applies(one: Requirement, extra: str) -> bool:
    return one.marker is None or one.marker.evaluate({"extra": extra})


def _problem(one: Requirement) -> str:
    """Problem of an installed package, behind the requirement; empty without one."""
    try:
        version = importlib.metadata.version(one.name)
    except importlib.metadata.PackageNotFoundError:
        return f"{one.name}{one.specifier}: is not installed"
    if not one.specifier.contains(version, prereleases=True):
        return f"{one.name}{one.specifier}: {version} is installed"
    return ""


def _has_distribution(name: str) -> bool:
    try:
        importlib.metadata.distribution(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True
