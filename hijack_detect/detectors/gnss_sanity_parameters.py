# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the consistency checks of a receiver stream.

One set for all vehicles. "Clean" below is 8 recorded flights (quadrotors, and a fixed wing of up
to 32 m/s) and 20 of a simulated autopilot; each limit leaves a factor of 1.5 to their largest.
"""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.patience import sensor_patience


@dataclass(frozen=True)
class GnssSanityParameters(Parameters):
    """Limits of each check."""

    jump_suspicious_m: float = param(
        3.0,
        "A horizontal step that differs by more from the reported motion is SUSPICIOUS (over 1 s: "
        "4/3 of it). Clean: 1.1 in one step, 2.6 over 1 s. Raise for a receiver that jumps by "
        "itself.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    jump_alarm_m: float = param(
        15.0,
        "Such a step is an ALARM at once. Reflections move receivers by a few metres, a step of "
        "15 m under a good view of the sky is several times what they claim; smaller ones are an "
        "ALARM when there are three within 5 s, or when they last (jump_lasting_m). Lower it where "
        "an alarm costs little.",
        unit="m",
        low=0.5,
        high=10_000.0,
    )
    jump_lasting_m: float = param(
        5.0,
        "With reported velocities, such a step within 1 s is an ALARM if it is not taken back: "
        "1.4 times as large after 1 s, else after 6 s. Up to twice this on a receiver that claims "
        "or has shown worse. Clean: 2.4; two antennas 4 m apart that are switched leave 1.25. "
        "Raise it where buildings reflect.",
        unit="m",
        low=0.5,
        high=10_000.0,
    )
    vertical_suspicious_m: float = param(
        6.0,
        "As jump_suspicious_m, for height. Clean: 1.7 in one step, 3.0 over 1 s.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    vertical_alarm_m: float = param(
        25.0, "As jump_alarm_m, for height.", unit="m", low=0.5, high=10_000.0
    )
    manoeuvre_m_s2: float = param(
        15.0,
        "Acceleration the vehicle may have between two samples. It allows a step a·dt²/4 with "
        "velocities, a·dt² from fixes alone: little at 5 Hz, kilometres after 20 s.",
        unit="m/s²",
        low=0.1,
        high=500.0,
    )
    accuracy_gain: float = param(
        3.0,
        "A step within this many times the claimed standard deviation is not SUSPICIOUS.",
        low=0.0,
        high=20.0,
    )
    accuracy_cap_m: float = param(
        2.0,
        "A claimed accuracy beyond this does not count: what claims it may be the attacker.",
        unit="m",
        low=0.0,
        high=100.0,
    )
    mismatch_base_m: float = param(
        5.0,
        "Horizontal change of position against integrated velocity over T seconds may differ by "
        "base + rate·T + fraction·path on a poor receiver. Clean quadrotors: 3.3 in 2 s, 5.6 in "
        "10 s, 7.8 in 20 s.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    mismatch_rate_m_s: float = param(0.45, "See mismatch_base_m.", unit="m/s", low=0.0, high=100.0)
    mismatch_path_fraction: float = param(
        0.03,
        "See mismatch_base_m: errors of fast vehicles grow with the way. Clean fixed wing: 19 m in "
        "600 m.",
        low=0.0,
        high=1.0,
    )
    mismatch_vertical_base_m: float = param(
        5.5,
        "As mismatch_base_m, for height. Clean quadrotors: 4 m in 2 s, 10 m in 10 s, 16 m in 20 s.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    mismatch_vertical_rate_m_s: float = param(
        1.1, "As mismatch_rate_m_s, for height.", unit="m/s", low=0.0, high=100.0
    )
    mismatch_persist_s: float = param(
        1.0, "So long it must last to be an ALARM.", unit="s", low=0.0, high=60.0
    )
    mismatch_floor: float = param(
        0.25,
        "A receiver whose own past is good has these limits times a part, down to this one. "
        "1 switches learning off.",
        low=0.05,
        high=1.0,
    )
    mismatch_gain: float = param(
        2.5,
        "The part is this times the largest level of the receiver's past flight. Raise it if "
        "velocity_mismatch alarms on clean flights.",
        low=1.0,
        high=100.0,
    )
    freeze_s: float = param(
        1.2,
        "A position that repeats for so long while the vehicle moves is an ALARM. Clean: 0.2. "
        "Raise for a receiver slower than 1 Hz whose fixes are repeated by its driver.",
        unit="s",
        low=0.1,
        high=60.0,
    )
    max_speed_m_s: float = param(
        48.0,
        "A speed in three dimensions that the vehicle cannot fly: ALARM, SUSPICIOUS from 80 %. "
        "Clean: 32. Set it to 1.5 times the vehicle's own largest.",
        unit="m/s",
        low=1.0,
        high=1000.0,
    )
    max_acceleration_m_s2: float = param(
        55.0,
        "A change of velocity over 1 s that it cannot fly: ALARM, SUSPICIOUS from 80 %. Clean: "
        "36 (launch of a fixed wing), 11 on quadrotors. Set it to 1.5 times the vehicle's own.",
        unit="m/s²",
        low=1.0,
        high=1000.0,
    )
    satellites_at_once: float = param(
        8.0,
        "One change of the number of satellites that is SUSPICIOUS. Clean: 5.",
        low=1.0,
        high=200.0,
    )
    satellites_in_5_s: float = param(
        20.0,
        "Sum of its changes over 5 s that is SUSPICIOUS. Clean: 12, in banked turns.",
        low=1.0,
        high=1000.0,
    )
    covariance_in_5_s: float = param(
        3.0,
        "Sum of the changes of ln(claimed accuracy) over 5 s, each at most 1, that is SUSPICIOUS.",
        low=0.1,
        high=100.0,
    )
    stamps_alarm: int = param(
        5,
        "So many stamps of fixes and velocities that repeat, run back or jump within stamps_in_s "
        "are an ALARM, unless they are copies of the sample before (SUSPICIOUS).",
        low=2,
        high=60,
    )
    stamps_in_s: float = param(3.0, "See stamps_alarm.", unit="s", low=0.1, high=60.0)
    receiver_no_fix_s: float = param(
        3.0,
        "The receiver is poor by its own word if it has no fix, or sends nothing, for so long of "
        "the last minute. That changes no state: it is named in the reason and on /diagnostics. "
        "Receivers under an open sky lose none (measured); one loss takes them 5 s.",
        unit="s",
        low=0.1,
        high=60.0,
    )
    receiver_accuracy_m: float = param(
        5.0,
        "It is poor if it claims a horizontal standard deviation above this in most fixes of 10 s "
        "(ArduPilot aligns no EKF above, nor with an HDOP above 2.5, which is the same).",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    receiver_vertical_accuracy_m: float = param(
        7.5,
        "The same for its height (ArduPilot's limit).",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    receiver_satellites: int = param(
        6,
        "It is poor with fewer satellites in most fixes of 10 s (the limit of ArduPilot and of "
        "PX4, EKF2_REQ_NSATS).",
        low=0,
        high=200,
    )
    hold_s: float = param(
        2.0,
        "SUSPICIOUS and ALARM are kept for so long after their last evidence, for the fusion.",
        unit="s",
        low=0.0,
        high=600.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
