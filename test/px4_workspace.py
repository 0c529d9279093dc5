# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A real px4_msgs, generated and compiled as colcon would, of the messages that are needed.

It is built once with cmake from stress/px4_msgs/*.msg into build/px4_msgs-HASH of the checkout
(about ten seconds) and found there afterwards: the messages of the bridge, and of what rosidl
makes of them only what rclpy needs over Fast DDS.
"""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

import pytest
from ros import ROOT

MESSAGES = ROOT / "stress/px4_msgs"
PARTS = (
    "ament_cmake",
    "rosidl_cmake",
    "rosidl_generator_c",
    "rosidl_generator_cpp",
    "rosidl_typesupport_fastrtps_cpp",
    "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_c",
    "rosidl_generator_py",
)
MANIFEST = """<?xml version="1.0"?>
<package format="3">
  <name>px4_msgs</name><version>1.15.0</version><description>Of the tests.</description>
  <maintainer email="maintainers@example.org">hijack_detect</maintainer><license>BSD</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
OPTIONS = (
    "-DBUILD_TESTING=OFF",
    "-DCMAKE_BUILD_TYPE=None",
    "-DCMAKE_CXX_FLAGS=-O0",
    "-DCMAKE_INSTALL_RPATH=$ORIGIN;$ORIGIN/../../..",
)
LONGEST_S = 300.0


def workspace() -> dict[str, str]:
    """Make px4_msgs importable here; what a process needs in its environment to import it too.

    Skips the test where it cannot be built, and says why.
    """
    need = [name for name in ("cmake", "cc", "c++") if shutil.which(name) is None]
    if need:
        pytest.skip(f"px4_msgs cannot be built: no {', '.join(need)}")
    prefixes = os.environ["AMENT_PREFIX_PATH"].split(os.pathsep)
    for part in PARTS:
        if not any(Path(one, "share", part, "cmake").is_dir() for one in prefixes):
            pytest.skip(f"px4_msgs cannot be built: {part} is not installed")
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        pytest.skip("px4_msgs cannot be built: no headers of Python (python3-dev)")
    prefix = _built(prefixes)
    _import_from(prefix)
    return _environment(prefix)


def _built(prefixes: list[str]) -> Path:
    """The prefix in which px4_msgs is installed; builds it if there is none yet."""
    files = {"CMakeLists.txt": _cmake(), "package.xml": MANIFEST}
    files |= {f"msg/{one.name}": one.read_text() for one in sorted(MESSAGES.glob("*.msg"))}
    content = repr((files, OPTIONS, sys.version_info[:2], prefixes))
    key = hashlib.sha256(content.encode()).hexdigest()[:16]
    place = ROOT / f"build/px4_msgs-{key}"
    place.parent.mkdir(exist_ok=True)
    with place.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not place.is_dir():
            _build(files, prefixes, place)
    return place


def _build(files: Mapping[str, str], prefixes: list[str], place: Path) -> None:
    work = place.with_suffix(".work")
    shutil.rmtree(work, ignore_errors=True)
    (work / "source/msg").mkdir(parents=True)
    for name, text in files.items():
        (work / "source" / name).write_text(text)
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    given = {
        "CMAKE_PREFIX_PATH": ";".join(prefixes),
        "CMAKE_INSTALL_PREFIX": work / "installed",
        "Python3_EXECUTABLE": sys.executable,
    }
    settings = [f"-D{name}={value}" for name, value in given.items()]
    commands: list[list[str | Path]] = [
        ["cmake", "-S", work / "source", "-B", work / "build", *generator, *settings, *OPTIONS],
        ["cmake", "--build", work / "build", "--parallel", "--target", "install"],
    ]
    scripts = {"PATH": f"{sysconfig.get_path('scripts')}{os.pathsep}{os.environ['PATH']}"}
    for command in commands:
        done = subprocess.run(
            command,
            env={**os.environ, **scripts},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
        if done.returncode != 0:
            pytest.fail(f"px4_msgs could not be built:\n{done.stdout[-5000:]}")
    (work / "installed").rename(place)
    shutil.rmtree(work)


def _cmake() -> str:
    found = "\n".join(f"find_package({part} REQUIRED)" for part in PARTS)
    names = " ".join(f"msg/{one.name}" for one in sorted(MESSAGES.glob("*.msg")))
    return (
        "cmake_minimum_required(VERSION 3.16)\nproject(px4_msgs)\n"
        f"{found}\nrosidl_generate_interfaces(px4_msgs {names})\nament_package()\n"
    )


def _packages(prefix: Path) -> str:
    return str(next(prefix.glob("lib/python3*/site-packages")))


def _import_from(prefix: Path) -> None:
    """Add it to a Python that runs, whose loader looks into no further folders."""
    if _packages(prefix) not in sys.path:
        sys.path.append(_packages(prefix))
        for library in sorted(prefix.glob("lib/lib*.so")):
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)


def _environment(prefix: Path) -> dict[str, str]:
    return {
        "AMENT_PREFIX_PATH": f"{prefix}{os.pathsep}{os.environ['AMENT_PREFIX_PATH']}",
        "LD_LIBRARY_PATH": f"{prefix / 'lib'}{os.pathsep}{os.environ.get('LD_LIBRARY_PATH', '')}",
        "PYTHONPATH": f"{ROOT}{os.pathsep}{_packages(prefix)}",
    }
