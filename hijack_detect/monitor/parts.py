# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The registry: a row for each estimator, each detector, and the fusion.

Everything that lists parts follows from these rows: the monitor's stages, parameter sections and
policies, the fusion's weights, executables and composition, completion, reports and tables. Classes
are named as text and imported where they are used, so this module costs nothing to import. A
detector of the user's own is a row too, made of its class by `own_part`.
"""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hijack_detect.detectors.likelihood import UNCALIBRATED, LikelihoodRatio, Weight
from hijack_detect.parameters import ParameterError, Parameters

if TYPE_CHECKING:
    from hijack_detect.detectors.likelihood import FusionParameters

GENERIC_NODE = "hijack_detect.nodes.detector_node:DetectorNode"


@dataclass(frozen=True)
class Part:
    """A row: what a part is called, what it is made of, and what its word is worth.

    Attributes:
        name: What its outputs are called as an input of other parts, and the first word of the
            topics of a detector.
        node: Its node, executable, and section of a parameter file.
        component: Its class, as `module:class` or itself. It is made from an object of its
            attribute PARAMETERS, a subclass of `Parameters`.
        asks: The question that a detector asks, in a line; empty for other parts.
        figures: Values of a detector's verdict, its `score` or its `threshold` that its node
            publishes as Float64 beside the margin, and their units.
        weight: What the fusion makes of a detector; None for other parts.
        face: Class of its node, as `module:class`, made from the row and a rate, see `PartNode`.
        paper: What policy `paper` sets differently from the defaults.
    """

    name: str
    node: str
    component: str | type[Any]
    asks: str = ""
    figures: Mapping[str, str] = field(default_factory=dict)
    weight: Weight | None = None
    face: str = GENERIC_NODE
    paper: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> type[Any]:
        """Its class."""
        return load(self.component) if isinstance(self.component, str) else self.component

    @property
    def question(self) -> str:
        """What it asks, as a sentence."""
        end = "" if self.asks.endswith("?") else "."
        return f"{self.asks[:1].upper()}{self.asks[1:]}{end}"

    @property
    def parameters(self) -> type[Parameters]:
        """Its parameter set."""
        kind: type[Parameters] = self.kind.PARAMETERS
        return kind


def load(path: str) -> type[Any]:
    """Import a class that is named as `module:class`."""
    module, _, name = path.partition(":")
    kind: type[Any] = getattr(importlib.import_module(module), name)
    return kind


PARTS = (
    Part(
        "attitude",
        "attitude_estimator",
        "hijack_detect.estimation.attitude:AttitudeEstimator",
        face="hijack_detect.nodes.attitude_estimator:AttitudeEstimatorNode",
        paper={"use_mag": False},
    ),
    Part(
        "course",
        "gps_angle",
        "hijack_detect.estimation.course:CourseEstimator",
        face="hijack_detect.nodes.gps_angle:GpsAngleNode",
    ),
    Part(
        "phase",
        "flight_phase",
        "hijack_detect.estimation.flight_phase:FlightPhaseEstimator",
        face="hijack_detect.nodes.flight_phase:FlightPhaseNode",
    ),
    Part(
        "correlation",
        "correlation_detector",
        "hijack_detect.detectors.correlation:CorrelationDetector",
        asks="gyroscope yaw against GPS course (Feng 2018, §4)",
        figures={"coefficient": "ρ", "mean_difference": "mean course minus mean yaw, rad"},
        # A vehicle that flies sideways alarms it: on clean recorded flights it reaches 2.9.
        weight=Weight(LikelihoodRatio(19.94, 0.9, -0.08, 2.1), may_alert=False, published=True),
        paper={
            "mu_deg": 10.0,
            "min_sigma_deg": 0.0,
            "persist_s": 0.0,
            "course_lag_s": 0.0,
            "follow_s": 0.0,
            "max_heading_sigma_deg": 180.0,
            "in_flight": False,
        },
    ),
    Part(
        "date",
        "date_detector",
        "hijack_detect.detectors.date:DateDetector",
        asks="acceleration from GPS against the accelerometer (DATE'17)",
        figures={"delta_ax": "body forward, m/s²", "delta_ay": "body left, m/s²"},
        weight=Weight(
            LikelihoodRatio(13.0, 0.69, -0.1, 4.88),
            shares="velocity",
            sees_carry_off=True,
            published=True,
        ),
        paper={
            "gps_lag_s": 0.0,
            "max_lag_s": 0.0,
            "persist_s": 0.0,
            "max_tilt_deg": 180.0,
            "noise_gain": 0.0,
            "max_force": 1000.0,
            "in_flight": False,
        },
    ),
    Part(
        "kld",
        "kld_detector",
        "hijack_detect.detectors.kld:KldDetector",
        asks="Kullback-Leibler statistics of the GPS (Basan 2022)",
        figures={"divergence": "of the parameter that decides, nats"},
        weight=Weight(LikelihoodRatio(6.64, 0.47, -0.1, 5.04), shares="height", keeps_alarm=True),
        face="hijack_detect.nodes.detector_node:KldDetectorNode",
        paper={
            "mode": "faithful",
            "quorum": 2,
            "together": 1,
            "altitude_threshold": 2.5e-4,
            "satellites_threshold": 0.03,
            "speed_threshold": 50.0,
            "track_threshold": 750.0,
            "latitude_threshold": 6e-12,
            "longitude_threshold": 3e-12,
        },
    ),
    Part(
        "coast",
        "coast_detector",
        "hijack_detect.detectors.coast:CoastDetector",
        asks="an acceleration of the GPS, since any onset, that the IMU did not feel",
        figures={
            "score": "standard deviations",
            "threshold": "standard deviations",
            "acceleration": "m/s²",
            "direction": "rad, counter-clockwise from East",
            "smallest_visible": "what it could see now, m/s²",
        },
        weight=Weight(
            LikelihoodRatio(8.66, 0.54, -0.1, 5.29), shares="velocity", sees_carry_off=True
        ),
        face="hijack_detect.nodes.detector_node:CoastDetectorNode",
    ),
    Part(
        "gnss",
        "gnss_sanity",
        "hijack_detect.detectors.gnss_sanity:GnssSanityDetector",
        asks="the GPS against itself: jumps, freezes, impossible motion, stamps",
        figures={
            "jump": "margin",
            "freeze": "margin",
            "velocity_mismatch": "margin",
            "velocity_mismatch_limit": "part of the full limits in force",
        },
        weight=Weight(LikelihoodRatio(11.17, 0.6, -0.1, 5.65)),
        face="hijack_detect.nodes.detector_node:GnssSanityNode",
    ),
    Part(
        "altitude",
        "altitude_detector",
        "hijack_detect.detectors.altitude:AltitudeDetector",
        asks="GPS height against the barometer and the vertical specific force",
        figures={"difference": "GPS height less barometer less reference, m"},
        weight=Weight(LikelihoodRatio(21.84, 0.79, -0.1, 5.11), shares="height"),
    ),
    Part(
        "heading",
        "heading_detector",
        "hijack_detect.detectors.heading:HeadingDetector",
        asks="headings of gyroscope, compass and GPS against each other",
        figures={"difference": "estimator minus compass, rad"},
        # No recorded flight with an attack and a compass moves it, so nobody could calibrate it.
        weight=Weight(None, may_alert=False),
    ),
    Part(
        "drag",
        "drag_detector",
        "hijack_detect.detectors.drag:DragDetector",
        asks="the wind that the GPS velocity needs, by the drag of the vehicle",
        figures={"wind_change": "m/s"},
        # A gust alarms it.
        weight=Weight(
            LikelihoodRatio(10.39, 0.77, -0.1, 2.7),
            shares="velocity",
            may_alert=False,
            sees_carry_off=True,
        ),
    ),
    Part(
        "fusion",
        "fusion",
        "hijack_detect.detectors.fusion:Fusion",
        face="hijack_detect.nodes.fusion:FusionNode",
        paper={"policy": "paper"},
    ),
)
"""In an order in which every part comes after those whose outputs it has as inputs.

The ratios were fitted on half of the recorded flights. Those fitted with each vehicle left out
(experiments/fusion_calibration.py) change no alert and have the same Brier score: these stay."""

WEIGHTS: Mapping[str, Weight] = {
    part.name: part.weight for part in PARTS if part.weight is not None
}
"""What the fusion makes of each of our detectors, by name."""
DETECTORS = tuple(WEIGHTS)
PUBLISHED = tuple(name for name, weight in WEIGHTS.items() if weight.published)
"""The detectors of Feng 2018, which policy `paper` asks."""


def row_of(node: str) -> Part:
    """The row of a node of the registry."""
    return next(part for part in PARTS if part.node == node)


def own_part(kind: type[Any]) -> Part:
    """The row of a detector of the user's own.

    Args:
        kind: Its class. It must have NAME and PARAMETERS; ASKS, FIGURES and WEIGHT are optional.

    Raises:
        AttributeError: It lacks one of them.
        TypeError: One is of another kind.
    """
    name, figures = kind.NAME, getattr(kind, "FIGURES", {})
    weight = getattr(kind, "WEIGHT", UNCALIBRATED)
    for what, given, wanted in (
        ("NAME is no text", name, str),
        ("FIGURES is no mapping of names to units", figures, Mapping),
        ("WEIGHT is no Weight", weight, Weight),
    ):
        if not isinstance(given, wanted):
            raise TypeError(what)
    if not (isinstance(kind.PARAMETERS, type) and issubclass(kind.PARAMETERS, Parameters)):
        raise TypeError("PARAMETERS is no subclass of Parameters")
    asks = getattr(kind, "ASKS", "a detector of your own")
    return Part(name, f"{name}_detector", kind, asks, figures, weight)


def weights(fusion: FusionParameters) -> Mapping[str, Weight]:
    """What the fusion makes of each detector: ours, and the further ones of its parameters.

    Raises:
        ParameterError: A further one has the name of one of our parts.
    """
    taken = {part.name for part in PARTS} & {*fusion.further}
    if taken:
        raise ParameterError(
            f"parameter 'further_detectors' has '{min(taken)}', which is a name of our own"
        )
    return {**WEIGHTS, **fusion.further}


def added(fusion: FusionParameters, part: Part) -> FusionParameters:
    """Parameters with which the fusion subscribes to a detector, with the weight of its row.

    One that they name already keeps the weight that they give it, as it has on the vehicle.

    Raises:
        ParameterError: Its name cannot be used.
    """
    if part.name in fusion.further or part.weight is None:
        return fusion
    given = [fusion.further_detectors, fusion.further_weights]
    given[0] += f" {part.name}"
    if part.weight != UNCALIBRATED:
        given[1] += f" {part.name}={part.weight.text}"
    names, words = map(str.strip, given)
    return dataclasses.replace(fusion, further_detectors=names, further_weights=words)
