# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The faults, by name."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import NavSatFix

from hijack_detect.detectors.verdict import State
from hijack_detect.nodes import COMPOSED, MONITOR
from hijack_detect.nodes.qos import INTERNAL
from hijack_detect.simulation.plan import Place
from stress.faults.attackers import (
    AHEAD_NS,
    FIX,
    IMU,
    MakeAttacker,
    false_reset,
    flood,
    forged_bool,
    forged_verdict,
    second_receiver,
)
from stress.faults.flight import (
    Fault,
    as_it_is,
    clock,
    from_zero,
    gone,
    late,
    lossy,
    reordered,
    twice,
)

VELOCITY = "/gps/vel"


@dataclass(frozen=True)
class Case:
    """One fault.

    Attributes:
        words: What is broken, for the table.
        fault: What becomes of the messages.
        lasting: Whether it lasts to the end of the flight.
        composed: Whether the monitor is one process.
        signals: What the process `victim` gets at the begin of the fault.
        victim: Its node.
        arguments: Further ROS arguments of the monitor.
        attacker: Second publisher beside the flight.
        spoofed_s: When the flight is carried off; None if it is not.
        reliable: Whether the inputs are published reliable; else best effort.
        place: Where the flight is.
    """

    words: str
    fault: Fault = as_it_is
    lasting: bool = False
    composed: bool = True
    signals: signal.Signals | None = None
    victim: str = COMPOSED
    arguments: tuple[str, ...] = ()
    attacker: MakeAttacker | None = None
    spoofed_s: float | None = None
    reliable: bool = True
    place: Place | None = None


def _signals(node: str, composed: bool) -> dict[str, Case]:
    where = {"composed": composed, "victim": node}
    return {
        f"kill_{node}": Case(
            f"`{node}`: SIGKILL, started again after 10 s", signals=signal.SIGKILL, **where
        ),
        f"stop_{node}": Case(
            f"`{node}`: SIGSTOP, SIGCONT after 10 s", signals=signal.SIGSTOP, **where
        ),
    }


PLACES = {
    "antimeridian": ("across the antimeridian", (-17.0, -179.999, 50.0)),
    "greenwich": ("across the equator and Greenwich", (0.0003, -0.0003, 20.0)),
    "north_pole": ("1.1 km from the North Pole", (89.99, 10.0, 0.0)),
    "south_pole": ("11 km from the South Pole, 2,835 m", (-89.9, -120.0, 2835.0)),
    "south_west": ("33° South, 70° West, 400 m below the ellipsoid", (-33.0, -70.0, -400.0)),
    "high": ("28° North, 87° East, 9,000 m", (28.0, 86.9, 9000.0)),
}

SEPARATE = {"composed": False}
ADVERSARIES: Mapping[str, Case] = {
    "forged_bool": Case(
        "forged true on `coast/hijacked`", attacker=forged_bool("coast/hijacked", value=True)
    ),
    "forged_alert": Case(
        "forged true on `hijack_alert`", attacker=forged_bool("hijack_alert", value=True)
    ),
    "forged_calm": Case(
        "forged false on `hijack_alert`, carried off at 46 s",
        attacker=forged_bool("hijack_alert", value=False),
        spoofed_s=46.0,
    ),
    "forged_alarm": Case(
        "forged alarm on `coast/verdict`, processes",
        attacker=forged_verdict("coast", State.ALARM),
        **SEPARATE,
    ),
    "forged_alarm_composed": Case(
        "forged alarm on `coast/verdict`, one process",
        attacker=forged_verdict("coast", State.ALARM),
    ),
    "forged_normal": Case(
        "forged calm on `coast/verdict`, 1 h ahead, carried off at 46 s, processes",
        attacker=forged_verdict("coast", State.NORMAL, ahead_ns=AHEAD_NS),
        spoofed_s=46.0,
        **SEPARATE,
    ),
    "false_reset": Case(
        "`fusion/reset` at 53 s, carried off at 46 s", attacker=false_reset, spoofed_s=46.0
    ),
    "flood_fix": Case("10,000 empty fixes a second", attacker=flood(FIX, NavSatFix)),
    "flood_verdict": Case(
        "10,000 empty verdicts a second on `coast/verdict`, processes",
        attacker=flood("coast/verdict", DiagnosticArray, INTERNAL),
        **SEPARATE,
    ),
}
CASES: Mapping[str, Case] = {
    "none": Case("nothing, for comparison"),
    **_signals(COMPOSED, True),
    **{name: case for node in MONITOR for name, case in _signals(node, False).items()},
    "imu_gone": Case("no IMU for 10 s", gone(IMU)),
    "gps_gone": Case("no GPS for 10 s", gone(FIX, VELOCITY)),
    "all_gone": Case("neither for 10 s", gone(FIX, VELOCITY, IMU)),
    "loss_10": Case("10 % of all messages lost", lossy(0.1), lasting=True),
    "loss_50": Case("50 % of all messages lost", lossy(0.5), lasting=True),
    "jitter": Case("up to 0.5 s of jitter, in order", late(0.5), lasting=True),
    "delay_fix": Case("fixes 1 s later than all else", late(1.0, 1.0, FIX), lasting=True),
    "reordered": Case("a tenth comes after the next one", reordered(0.1), lasting=True),
    "twice": Case("every message twice", twice, lasting=True),
    "clock_forward": Case("the clock jumps 1 h forward", clock(3600.0), lasting=True),
    "clock_back": Case("the clock jumps 1 h back", clock(-3600.0), lasting=True),
    "leap_second": Case("a leap second: the clock is set back 1 s", clock(-1.0), lasting=True),
    "second_forward": Case("the clock is set forward 1 s", clock(1.0), lasting=True),
    "from_zero": Case("stamps from 0", from_zero),
    "paused": Case(
        "`use_sim_time`, and ROS time stands still", arguments=("-p", "use_sim_time:=true")
    ),
    "two_receivers": Case("a second publisher on `gps/fix`, 200 m away", attacker=second_receiver),
    "incompatible": Case(
        "inputs best effort, the monitor asks for reliable (`config/replay.yaml`)",
        arguments=("--params-file", "config/replay.yaml"),
        reliable=False,
    ),
    **ADVERSARIES,
    **{name: Case(f"none, {words}", place=Place.at(*at)) for name, (words, at) in PLACES.items()},
}
