"""The monitor as one object: the same stages that the nodes run, wired as their topics are."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from hijack_detect.detectors.correlation import CorrelationDetector
from hijack_detect.detectors.correlation_parameters import CorrelationParameters
from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.detectors.fusion import Fusion, FusionParameters
from hijack_detect.detectors.kld import KldDetector
from hijack_detect.detectors.kld_parameters import KldParameters
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.course import CourseEstimator, CourseParameters
from hijack_detect.evaluation.monitor.stage import Component, Stage

DETECTORS = ("correlation", "date", "kld")


@dataclass(frozen=True)
class MonitorParameters:
    """Parameters of every part."""

    attitude: AttitudeParameters = field(default_factory=AttitudeParameters)
    course: CourseParameters = field(default_factory=CourseParameters)
    correlation: CorrelationParameters = field(default_factory=CorrelationParameters)
    date: DateParameters = field(default_factory=DateParameters)
    kld: KldParameters = field(default_factory=KldParameters)
    fusion: FusionParameters = field(default_factory=FusionParameters)


Baselines: TypeAlias = Mapping[str, Callable[[], Component]]
"""Makers of further detectors by name."""


class Monitor:
    """Feeds samples through attitude, course, detectors and fusion.

    Inputs are `imu`, `fix`, `velocity`, `satellites` and `mag`; what each part puts out goes to
    the parts that have an input of that name. Everything that was put out by one `push` is
    returned.

    Attributes:
        detectors: Names of the parts that give verdicts.
    """

    def __init__(self, parameters: MonitorParameters, baselines: Baselines | None = None) -> None:
        """Make all stages.

        Args:
            parameters: Parameters of every part.
            baselines: Detectors to compare with, which fusion does not hear.
        """
        p = parameters
        self.detectors = (*DETECTORS, *(baselines or {}))
        self.stages: Mapping[str, Stage] = {
            "attitude": Stage(lambda: AttitudeEstimator(p.attitude)),
            "course": Stage(lambda: CourseEstimator(p.course)),
            "correlation": Stage(lambda: CorrelationDetector(p.correlation)),
            "date": Stage(lambda: DateDetector(p.date)),
            "kld": Stage(lambda: KldDetector(p.kld)),
            "fusion": Stage(lambda: Fusion(p.fusion, DETECTORS)),
            **{name: Stage(make) for name, make in (baselines or {}).items()},
        }

    def push(self, name: str, sample: Any) -> list[tuple[str, Any]]:
        """Take one input sample; return (part, output) of everything that followed from it."""
        outputs: list[tuple[str, Any]] = []
        waiting = deque([(name, sample)])
        while waiting:
            source, one = waiting.popleft()
            for part, stage in self.stages.items():
                if source in stage.component.inputs:
                    for output in stage.push(source, one):
                        outputs.append((part, output))
                        waiting.append((part, output))
        return outputs
