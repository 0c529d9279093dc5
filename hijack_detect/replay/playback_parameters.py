# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the replay of a bag."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.bags.topics import PRESETS
from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class ReplayParameters(Parameters):
    """What is replayed, how fast, and with which attack."""

    bag: str = param("", "Bag to replay: a rosbag2 directory or an mcap file. Required.")
    scenario: str = param(
        "", "Scenario file of attacks to inject; their times count from the bag's first message."
    )
    preset: str = param(
        "auto",
        "Names of the inputs in the bag; `auto` finds them. They are published as imu/data_raw, "
        "gps/fix, gps/vel, mag, pressure and gps/satellites.",
        choices=("auto", *PRESETS),
    )
    rate: float = param(
        1.0,
        "Bag seconds for each second of wall time; can be changed while playing.",
        low=0.001,
        high=1000.0,
    )
    start_s: float = param(
        0.0, "Where to begin, counted from the bag's first message.", unit="s", low=0.0
    )
    duration_s: float = param(
        0.0, "How much of the bag to replay; 0 is to its end.", unit="s", low=0.0
    )
    loop: bool = param(
        False, "Begin again at the end; stamps then run backwards, or on if restamp."
    )
    restamp: bool = param(
        False,
        "Move header stamps (and /clock) so that the first one is now. Their spacing is kept, so "
        "that at another rate than 1 they run ahead of the wall clock, or behind it.",
    )
    clock_hz: float = param(
        100.0,
        "Publish /clock this often in bag time, for nodes with use_sim_time; 0 is never. It is "
        "up to one period ahead of the messages, never behind.",
        unit="Hz",
        low=0.0,
        high=1000.0,
    )
    start_paused: bool = param(False, "Wait for the service ~/resume or ~/step before playing.")
    settle_s: float = param(
        3.5,
        "Begin when no subscription of a replayed topic has come or gone for this long, so that "
        "running nodes hear the first message: DDS can take 3 s to find them. Can be shorter "
        "with wait_for.",
        unit="s of wall time",
        low=0.0,
        high=3600.0,
    )
    wait_for: str = param(
        "", "Names of nodes, separated by spaces, that must be in the graph before it begins."
    )
    progress: bool = param(True, "Draw a progress bar, if stderr is a terminal.")
    exit_at_end: bool = param(
        True, "End the process at the end of the bag; false keeps the node, with ~/finished true."
    )

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            ValueError: There is no bag, or a value is refused.
        """
        super().__post_init__()
        if not self.bag:
            raise ValueError(
                "parameter 'bag' is empty; name a rosbag2 directory or an mcap file: "
                "--ros-args -p bag:=PATH"
            )
