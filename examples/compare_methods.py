# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Verdicts of each method before and after the GPS of a flight is pulled away. Needs no ROS.

python examples/compare_methods.py bags/curved_8
"""

import sys

from hijack_detect import FlightLog, State, parse_scenario, policy_parameters

ONSET_S = 60.0
MODEL = {"type": "drift", "speed_m_s": 4.0, "bearing_deg": 45.0, "onset_acceleration_m_s2": 1.0}
pull = parse_scenario({"segments": [{"name": "pull", "start": ONSET_S, "model": MODEL}]})

with FlightLog(sys.argv[1]) as flight:
    run = flight.run(policy_parameters("default"), pull)
    for name, verdicts in run.verdicts.items():
        before = [one for one in verdicts if flight.seconds(one.stamp_ns) < ONSET_S]
        largest = max((one.margin for one in before), default=0.0)
        alarm = next((one for one in verdicts if one.state is State.ALARM), None)
        found = "no alarm" if alarm is None else f"{flight.seconds(alarm.stamp_ns):.1f} s"
        print(f"{name:12} largest margin before {largest:.2f}, alarm: {found}")
    print(flight.analyse(attack=pull).verdict)
