# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor as one object: the same stages that the nodes run, wired as their topics are."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from hijack_detect.detectors.altitude import AltitudeDetector
from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.coast import CoastDetector
from hijack_detect.detectors.coast_parameters import CoastParameters
from hijack_detect.detectors.correlation import CorrelationDetector
from hijack_detect.detectors.correlation_parameters import CorrelationParameters
from hijack_detect.detectors.date import DateDetector
from hijack_detect.detectors.date_parameters import DateParameters
from hijack_detect.detectors.drag import DragDetector
from hijack_detect.detectors.drag_parameters import DragParameters
from hijack_detect.detectors.fusion import Fusion
from hijack_detect.detectors.fusion_parameters import FusionParameters
from hijack_detect.detectors.gnss_sanity import GnssSanityDetector
from hijack_detect.detectors.gnss_sanity_parameters import GnssSanityParameters
from hijack_detect.detectors.heading import HeadingDetector
from hijack_detect.detectors.heading_parameters import HeadingParameters
from hijack_detect.detectors.kld import KldDetector
from hijack_detect.detectors.kld_parameters import KldParameters
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.course import CourseEstimator, CourseParameters
from hijack_detect.estimation.flight_phase import FlightPhaseEstimator, FlightPhaseParameters
from hijack_detect.monitor.stage import Component, Stage
from hijack_detect.parameters import ParameterError
from hijack_detect.streams.receiver_clock import ReceiverClock

DETECTORS = ("correlation", "date", "kld", "coast", "gnss", "altitude", "heading", "drag")


@dataclass(frozen=True)
class MonitorParameters:
    """Parameters of every part."""

    attitude: AttitudeParameters = field(default_factory=AttitudeParameters)
    course: CourseParameters = field(default_factory=CourseParameters)
    phase: FlightPhaseParameters = field(default_factory=FlightPhaseParameters)
    correlation: CorrelationParameters = field(default_factory=CorrelationParameters)
    date: DateParameters = field(default_factory=DateParameters)
    kld: KldParameters = field(default_factory=KldParameters)
    coast: CoastParameters = field(default_factory=CoastParameters)
    gnss: GnssSanityParameters = field(default_factory=GnssSanityParameters)
    altitude: AltitudeParameters = field(default_factory=AltitudeParameters)
    heading: HeadingParameters = field(default_factory=HeadingParameters)
    drag: DragParameters = field(default_factory=DragParameters)
    fusion: FusionParameters = field(default_factory=FusionParameters)


Baselines: TypeAlias = Mapping[str, Callable[[], Component]]
"""Makers of further detectors by name."""


def heard(parameters: FusionParameters) -> tuple[str, ...]:
    """The detectors that the fusion hears: ours, and the further ones of its parameters.

    Raises:
        ParameterError: A further one has the name of one of ours.
    """
    taken = {*DETECTORS, Fusion.NAME} & {*parameters.further}
    if taken:
        raise ParameterError(
            f"parameter 'further_detectors' has '{min(taken)}', which is a name of our own"
        )
    return (*DETECTORS, *parameters.further)


class Monitor:
    """Feeds samples through attitude, course, detectors and fusion.

    Inputs are `imu`, `fix`, `velocity`, `satellites`, `mag` and `pressure`; what each part puts
    out goes to the parts that have an input of that name. Everything that was put out by one
    `push` is returned.

    Attributes:
        detectors: Names of the parts that give verdicts.
        clock: Puts the receiver's stamps on the clock of the IMU before any part has them.
    """

    def __init__(self, parameters: MonitorParameters, baselines: Baselines | None = None) -> None:
        """Make all stages.

        Args:
            parameters: Parameters of every part.
            baselines: Further detectors. Fusion hears those that its parameters name.

        Raises:
            ParameterError: See `heard`.
        """
        p = parameters
        self.detectors = (*DETECTORS, *(baselines or {}))
        self.clock = ReceiverClock()
        self.stages: Mapping[str, Stage] = {
            "attitude": Stage(lambda: AttitudeEstimator(p.attitude)),
            "course": Stage(lambda: CourseEstimator(p.course)),
            "phase": Stage(lambda: FlightPhaseEstimator(p.phase)),
            "correlation": Stage(lambda: CorrelationDetector(p.correlation)),
            "date": Stage(lambda: DateDetector(p.date)),
            "kld": Stage(lambda: KldDetector(p.kld)),
            "coast": Stage(lambda: CoastDetector(p.coast)),
            "gnss": Stage(lambda: GnssSanityDetector(p.gnss)),
            "altitude": Stage(lambda: AltitudeDetector(p.altitude)),
            "heading": Stage(lambda: HeadingDetector(p.heading)),
            "drag": Stage(lambda: DragDetector(p.drag)),
            "fusion": Stage(lambda: Fusion(p.fusion, heard(p.fusion))),
            **{name: Stage(make) for name, make in (baselines or {}).items()},
        }
        self._hearers: dict[str, list[tuple[str, Stage]]] = defaultdict(list)
        for part, stage in self.stages.items():
            for source in stage.component.inputs:
                self._hearers[source].append((part, stage))

    def push(self, name: str, samples: Sequence[Any]) -> list[tuple[str, Any]]:
        """Take successive samples of one input; return (part, output) of all that followed.

        What a part puts out is in order. Many samples at a time cost less than one by one, and
        lead to the same outputs.
        """
        outputs: list[tuple[str, Any]] = []
        waiting: deque[tuple[str, Sequence[Any]]] = deque(self.clock.push_run(name, samples))
        while waiting:
            source, some = waiting.popleft()
            for part, stage in self._hearers[source]:
                if found := stage.push_all(source, some):
                    outputs += [(part, output) for output in found]
                    waiting.append((part, found))
        return outputs
