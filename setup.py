# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Installs the same lib/hijack_detect and share/hijack_detect with colcon, pip and a wheel."""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path

from setuptools import Distribution, find_packages, setup

sys.path.insert(0, str(Path(__file__).parent))
from hijack_detect.nodes import NODES, entry_point

NAME = "hijack_detect"
VERSION = runpy.run_path(f"{NAME}/__init__.py")["__version__"]
PROGRAMS = {
    "hijack-detect": f"{NAME}.cli.main:main",
    **{node: entry_point(node) for node in NODES},
}

# pip puts console scripts into bin/, and `ros2 run` looks in lib/<package>/.
LAUNCHER = """#!/bin/sh
exec "$(dirname "$0")/../../bin/$(basename "$0")" "$@"
"""


class InstallData(Distribution().get_command_class("install_data")):  # type: ignore[misc]
    """Copies the data files, and adds the launchers where console scripts go to bin/."""

    def run(self) -> None:
        """Install. colcon runs `install`, and setup.cfg puts its console scripts into lib/."""
        super().run()
        if "install" in self.distribution.commands:
            return
        folder = Path(self.install_dir, "lib", NAME)
        folder.mkdir(parents=True, exist_ok=True)
        for program in PROGRAMS:
            launcher = folder / program
            launcher.write_text(LAUNCHER)
            launcher.chmod(0o755)
            self.outfiles.append(str(launcher))


def shared(top: str) -> list[tuple[str, list[str]]]:
    """Return the data_files of a folder and of all folders below it."""
    return [
        (f"share/{NAME}/{folder}", [f"{folder}/{name}" for name in sorted(names)])
        for folder, _, names in sorted(os.walk(top))
        if names and not folder.endswith("__pycache__")
    ]


setup(
    name=NAME,
    version=VERSION,
    description="Tells a drone's mission manager that its GPS is being spoofed.",
    license="Apache-2.0",
    license_files=["LICENSE"],
    author="hijack_detect maintainers",
    author_email="maintainers@example.org",
    maintainer="hijack_detect maintainers",
    maintainer_email="maintainers@example.org",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "live/page/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *shared("launch"),
        *shared("config"),
        *shared("bags"),
    ],
    entry_points={"console_scripts": [f"{name} = {main}" for name, main in PROGRAMS.items()]},
    cmdclass={"install_data": InstallData},
    zip_safe=False,
    python_requires=">=3.10",
    install_requires=[
        "backports.zstd>=1 ; python_version < '3.14'",
        "click>=8.1",
        "lz4>=4",
        "numpy>=1.26",
        "packaging>=23",
        "pydantic>=2",
        "pygeomag>=1",
        "pymap3d>=3",
        "pyyaml>=6",
        "rich>=13",
        "rosbags>=0.10",
    ],
    extras_require={
        # A ROS installation brings its own rclpy and messages; these are for machines without one.
        "wheels": [
            "ros-jazzy-rclpy==7.1.6",
            "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
            "ros-jazzy-common-interfaces==5.3.6",
        ],
        # Reports, statistics and figures of recorded flights, on all cores; no node needs them.
        "analysis": [
            "dask>=2024.5",
            "distributed>=2024.5",
            "matplotlib>=3.8",
            "plotly>=5.20",
            "scipy>=1.11",
        ],
        # Beyond that: results kept as Parquet, and bags at URLs.
        "corpora": ["pyarrow>=15", "universal_pathlib>=0.2.3"],
        # The web page of a running monitor.
        "live": ["tornado>=6.4"],
        # Logs of PX4 and ArduPilot.
        "logs": ["pymavlink>=2.4.40", "pyulog>=1.0"],
        # The node mavlink_bridge.
        "mavlink": ["pymavlink>=2.4.40", "pyserial>=3.5"],
        # colcon test looks for this name.
        "test": [
            "hypothesis",
            "jsonschema",
            "playwright",
            "psutil",
            "pyarrow",
            "pytest",
            "pytest-xdist",
            "universal_pathlib",
        ],
    },
)
