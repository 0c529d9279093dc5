# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One recorded flight, opened for as many runs of the monitor as wanted."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

from hijack_detect.analysis.analyse import analyse
from hijack_detect.analysis.analysis import Analysis
from hijack_detect.logs.formats import opened
from hijack_detect.logs.logged import Notes, Selection
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import FlightNotes, OfflineRun, run_offline, spoofed_samples
from hijack_detect.replay.truth import truth_track
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, Sample


class FlightLog:
    """A recorded flight: an mcap bag, or a log of any format of `hijack-detect analyze`.

    A log is converted once, into a bag in a temporary folder that `close` removes: use it in a
    `with` statement. Each of its runs begins with a new monitor.

    Attributes:
        path: The bag or log.
        notes: What the conversion noted, empty for a bag.
        start_ns: Log time of the first message, nanoseconds.
        duration_s: From the first to the last message, s.
    """

    def __init__(self, path: str | Path, *, imu: int = 0, gps: int = 0) -> None:
        """Open a flight.

        Args:
            path: The bag or log.
            imu: Which IMU of a log with several, from 0.
            gps: Which receiver, likewise.

        Raises:
            BagError: The file is of no known format, cannot be read, or has no IMU or GPS.
            ModuleNotFoundError: What reads the format is not installed (the extra `logs`).
        """
        self.path = Path(path)
        self._stack = contextlib.ExitStack()
        self._reader, converted = self._stack.enter_context(opened(self.path, Selection(imu, gps)))
        self.notes = Notes() if converted is None else converted.notes
        self.start_ns = self._reader.start_ns
        self.duration_s = self._reader.duration_s

    def close(self) -> None:
        """Close the bag, and remove it if it was made of a log."""
        self._stack.close()

    def __enter__(self) -> FlightLog:
        """Return the flight."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the flight."""
        self.close()

    def seconds(self, stamp_ns: int) -> float:
        """Seconds from the first message to a stamp."""
        return (stamp_ns - self.start_ns) / NANOSECONDS

    def samples(self, attack: Scenario | None = None) -> Iterator[tuple[str, Sample]]:
        """Yield input name and sample of everything that the monitor takes, as `Monitor.push`.

        SI units, FLU for the vehicle and ENU for the world, stamps in nanoseconds.

        Args:
            attack: What the GPS is changed by, None for the flight as it is.

        Raises:
            BagError: The bag is damaged.
            ScenarioError: A segment of the attack lies outside the flight.
        """
        yield from spoofed_samples(self._reader, attack, FlightNotes(self.start_ns))

    def run(
        self, parameters: MonitorParameters | None = None, attack: Scenario | None = None
    ) -> OfflineRun:
        """Run the flight through a monitor and return every verdict.

        Args:
            parameters: See `policy_parameters`; those of policy `default` if None.
            attack: See `samples`.

        Returns:
            `verdicts` by name of the detector, `results` of the fusion, and `separations` between
            true and reported position.

        Raises:
            BagError: See `samples`.
            ScenarioError: See `samples`.
        """
        truth = truth_track(self._reader) if attack is None else None
        return run_offline(self._reader, parameters or MonitorParameters(), attack, truth=truth)

    def analyse(
        self, parameters: MonitorParameters | None = None, attack: Scenario | None = None
    ) -> Analysis:
        """Judge whether the GPS was spoofed, when, and on what evidence: what `analyze` shows.

        Args:
            parameters: See `run`.
            attack: See `samples`.

        Raises:
            BagError: See `samples`.
            ScenarioError: See `samples`.
        """
        parameters = parameters or MonitorParameters()
        return analyse(self._reader, parameters, attack, imported=self.notes).analysis
