# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""PX4's times become stamps: UTC stays, boot time is moved by one offset, a reboot is told."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.px4.clock import ALIGN_US, UTC_FROM_US, Kind, Px4Clock

NOW_NS = 1_795_000_000_000_000_000
BOOT_NS = NOW_NS - 60_000_000_000
"""When PX4 started, by the system clock."""


class Told:
    """A clock, and what it said."""

    def __init__(self) -> None:
        self.said: list[str] = []
        self.warned: list[str] = []
        self.clock = Px4Clock(self.said.append, self.warned.append)

    def stamps(
        self, times_us: list[int], delays_us: list[int], boot_ns: int = BOOT_NS
    ) -> list[int | None]:
        """Stamps of messages that take their time to arrive."""
        pairs = zip(times_us, delays_us, strict=True)
        return [
            self.clock.stamp_ns("imu", us, boot_ns + (us + delay) * 1000) for us, delay in pairs
        ]


@given(
    steps_us=st.lists(st.integers(1, 300_000), min_size=8, max_size=40),
    delays_us=st.lists(st.integers(0, 80_000), min_size=40, max_size=40),
    start_us=st.integers(1, 10**12),
)
def test_boot_time_keeps_its_spacing_and_loses_the_smallest_delay(
    steps_us: list[int], delays_us: list[int], start_us: int
) -> None:
    times = [start_us, *itertools.accumulate(steps_us, initial=start_us)]
    delays = delays_us[: len(times)]
    times, told = times[: len(delays)], Told()
    stamps = told.stamps(times, delays)
    heard = [one for one in range(len(times)) if times[one] - start_us < ALIGN_US]
    assert stamps[: len(heard)] == [None] * len(heard)
    used = times[len(heard) :]
    if not used:
        assert told.clock.offset_ns is None
        return
    least_us = min(delays[: len(heard) + 1])
    assert stamps[len(heard) :] == [BOOT_NS + (us + least_us) * 1000 for us in used]
    assert told.clock.kind is Kind.BOOT and told.clock.restarts == 0
    assert len(told.said) == 2 and "count from its start" in told.said[0]
    assert told.warned == []


@given(us=st.integers(UTC_FROM_US, 4 * 10**15))
def test_utc_stays_as_it_is(us: int) -> None:
    told = Told()
    assert told.clock.stamp_ns("imu", us, us * 1000 + 5) == us * 1000
    assert told.clock.late_ns == 5
    assert told.said == [
        "PX4's timestamps are UTC, synchronised by the agent: they stay as they are"
    ]
    assert told.warned == []


def test_utc_of_another_clock_is_warned_of() -> None:
    told = Told()
    us = NOW_NS // 1000
    assert told.clock.stamp_ns("imu", us, NOW_NS + 90 * 10**9) == NOW_NS
    assert "90.0 s behind this system clock" in told.warned[0]
    well, text, values = told.clock.report()
    assert not well and "stamps are 90.0 s behind this clock" in text
    assert values["behind the system clock s"] == "90.000"


def test_a_reboot_begins_afresh_and_little_steps_back_do_not() -> None:
    told = Told()
    seconds = [50_000_000 + step for step in (0, 500_000, 1_000_000, 1_500_000)]
    assert told.stamps(seconds, [0] * 4)[-1] == BOOT_NS + seconds[-1] * 1000
    late_us = seconds[-1] - 400_000
    assert told.clock.stamp_ns("mag", late_us, NOW_NS) == BOOT_NS + late_us * 1000
    assert told.clock.stamp_ns("imu", late_us, NOW_NS) == BOOT_NS + late_us * 1000
    assert told.clock.restarts == 0

    again_ns = BOOT_NS + 100 * 10**9
    after = [3_000_000, 3_500_000, 4_000_000, 4_100_000]
    assert told.stamps(after, [0] * 4, again_ns) == [
        None, None, again_ns + 4_000_000_000, again_ns + 4_100_000_000,
    ]  # fmt: skip
    assert told.clock.stamp_ns("mag", 4_050_000, NOW_NS) == again_ns + 4_050_000_000
    assert told.clock.restarts == 1
    assert told.warned == [
        "PX4's clock goes back by 48.5 s: it was restarted; everything begins afresh"
    ]


def test_an_agent_that_synchronises_later_is_followed() -> None:
    told = Told()
    told.stamps([20_000_000, 21_000_000], [0, 0])
    assert told.clock.stamp_ns("imu", NOW_NS // 1000, NOW_NS) == NOW_NS
    assert told.clock.kind is Kind.UTC
    assert told.clock.report() == (
        True,
        "PX4's timestamps count from: UTC of the agent",
        {
            "timestamps count from": "UTC of the agent",
            "offset s": "",
            "behind the system clock s": "0.000",
            "restarts": "1",
        },
    )
    assert "changes from start of PX4 to UTC of the agent" in told.warned[0]
