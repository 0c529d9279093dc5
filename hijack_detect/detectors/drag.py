# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Drag as an airspeed sensor: does the GPS velocity need a wind that no atmosphere makes?"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from hijack_detect.detectors.drag_blocks import BlockBuilder, FlightBlock, FlightPhase
from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.input_watch import REPEAT_NS, InputWatch, patience
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.drag_filter import (
    DRAG,
    AirBlock,
    Checkpoint,
    DragFilter,
    DragNoise,
    WindChange,
    first_drag,
    first_drag_sigma,
    first_quadratic_sigma,
)
from hijack_detect.estimation.motion import GpsMotion, Motion, climb_between
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    FixSample,
    PhaseSample,
    VelocitySample,
)
from hijack_detect.streams.silence import sensor_patience


@dataclass(frozen=True)
class DragParameters(Parameters):
    """The detector answers slowly: `recent_s` sets the pace, `frozen_s` what it remembers."""

    gps_lag_s: float = param(
        0.2,
        "Time from when a GPS velocity was true to its header stamp. Wrong by 0.1 s costs little: "
        "drag is a matter of seconds.",
        source="measured: recorded receivers",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    block_s: float = param(
        0.4,
        "Force and velocity are averaged over this time, or the interval of slower receivers.",
        source="chosen: that of a prototype on recorded flights",
        unit="s",
        low=0.1,
        high=5.0,
    )
    recent_s: float = param(
        20.0,
        "The wind of this last time is compared with the wind before. Longer is surer and slower.",
        source="chosen: that of a prototype on recorded flights",
        unit="s",
        low=5.0,
        high=120.0,
    )
    frozen_s: float = param(
        40.0,
        "Age of the parameters that are compared with; a change that takes longer than this less "
        "half of recent_s is taken for weather. After take-off younger ones are used.",
        source="chosen: that of a prototype on recorded flights",
        unit="s",
        low=10.0,
        high=300.0,
    )
    ready_s: float = param(
        25.0,
        "Time in flight, after settle_s, before there is anything to compare; at least recent_s.",
        source="physics: recent_s, and what there is to compare it with",
        unit="s",
        low=5.0,
        high=300.0,
    )
    hold_s: float = param(
        120.0,
        "While the change is over its limit the parameters from before it are kept, at most until "
        "they are this old: then the new wind is believed, and an alarm ends.",
        source="chosen, not swept",
        unit="s",
        low=10.0,
        high=3600.0,
    )
    least_limit: float = param(
        3.7,
        "Change of wind that is normal in any weather. Take it from clean flights of the vehicle, "
        "windy ones among them. A gust front of this size looks like an attack.",
        source="measured on a prototype, recorded flights; margins in docs/detection-limits.md",
        basic=True,
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    limit_offset: float = param(
        1.0,
        "In strong wind limit_offset + limit_share * wind is normal, if it is more.",
        source="measured with least_limit",
        unit="m/s",
        low=0.0,
        high=50.0,
    )
    limit_share: float = param(
        0.55,
        "See limit_offset. 0 makes the limit the same in all winds.",
        source="measured with least_limit",
        low=0.0,
        high=5.0,
    )
    max_sigma: float = param(
        1.5,
        "NOT_OBSERVABLE where the change of wind is known less well than this (one standard "
        "deviation): a straight route at constant speed, where wind and accelerometer bias look "
        "the same.",
        source="chosen, not swept",
        unit="m/s",
        low=0.1,
        high=10.0,
    )
    prior_change: float = param(
        5.0,
        "A change of wind is expected to be about this large; what the flight does not show stays "
        "within it.",
        source="chosen, not swept",
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    persist_s: float = param(
        2.0,
        "The limit must be exceeded for this long to be an ALARM; SUSPICIOUS before.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    drag: float = first_drag()
    drag_sigma: float = first_drag_sigma()
    quadratic_sigma: float = first_quadratic_sigma(0.005)
    least_drag: float = param(
        0.1,
        "A vehicle with less drag than this is not seen by its drag: NOT_OBSERVABLE. A fixed wing "
        "ends here.",
        source="chosen, not swept",
        unit="1/s",
        low=0.0,
        high=2.0,
    )
    learnt_share: float = param(
        0.95,
        "Drag is learnt once its standard deviation is below this share of drag_sigma.",
        source="chosen, not swept",
        low=0.05,
        high=1.0,
    )
    max_residual: float = param(
        0.45,
        "NOT_OBSERVABLE where drag leaves more than this of the specific force unexplained (root "
        "mean square of blocks): a fixed wing, aerobatics, a loose sensor.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.05,
        high=10.0,
    )
    bias_sigma: float = param(
        0.2,
        "Standard deviation of the accelerometer's bias along body x and y, a tilted mounting "
        "included (1° is 0.17).",
        source="physics: 1.2° of tilted mounting",
        unit="m/s²",
        low=0.01,
        high=5.0,
    )
    gust_s: float = param(
        1.0,
        "How long gusts keep the force away from the model. Longer trusts the flight less.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=30.0,
    )
    wind_walk: float = param(
        0.15,
        "How fast the wind is expected to change: standard deviation after one second.",
        source="chosen, not swept: 1.2 m/s in a minute",
        unit="m/s",
        low=0.0,
        high=5.0,
    )
    max_heading_sigma_deg: float = param(
        20.0,
        "Blocks with a heading known less well are left out.",
        source="chosen, not swept",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    heading_gain: float = param(
        6.0,
        "A wrong heading turns the velocity into a wind: this times speed times standard deviation "
        "of the heading (rad), the largest of recent_s, and without what the limit holds already "
        "(0.35 m/s), adds to the limit as squares. A multirotor that braked from 6 m/s with a "
        "heading known to 10° needed 4.",
        source="measured: a multirotor that needed 4, with half as much again",
        low=0.0,
        high=20.0,
    )
    moving_speed: float = param(
        2.0,
        "A vehicle that is faster for 2 s, or climbs at half of this, is in the air.",
        source="as moving_speed of flight_phase",
        unit="m/s",
        low=0.2,
        high=50.0,
    )
    settle_s: float = param(
        5.0,
        "Nothing is learnt for this long after that: take-off.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    still_share: float = param(
        0.25,
        "The vehicle stands on the ground again when it does not move and the accelerometer "
        "shakes less than this share of what it did in the air. 0: never.",
        source="chosen, not swept",
        low=0.0,
        high=1.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
    max_gap_s: float = param(
        2.0,
        "GPS velocities further apart than this are not joined, and the wind is forgotten.",
        source="the time after which StreamMerge counts an outage (SILENCE_S)",
        unit="s",
        low=0.1,
        high=60.0,
    )

    @property
    def noise(self) -> DragNoise:
        """What the filter assumes."""
        return DragNoise(
            correlation_s=self.gust_s,
            drag=(self.drag, self.drag_sigma),
            quadratic_sigma=self.quadratic_sigma,
            bias=self.bias_sigma,
            wind_walk=self.wind_walk,
        )

    def limit(self, wind: float) -> float:
        """Largest change of wind that is normal at a speed of the wind, m/s."""
        return max(self.least_limit, self.limit_offset + self.limit_share * wind)


CHECKPOINT_NS = NANOSECONDS
"""The filter is copied this often. Chosen, not swept."""
KNOWN_TURN = 0.35
"""Speed times standard deviation of the heading, m/s, of the flights that the limit was set on: it
holds for an error of the velocity up to this."""
RELEASE = 0.8
"""Parameters that are kept are given up below this share of the limit. Chosen, not swept."""


class DragDetector:
    """Change of the wind that the GPS velocity needs, more than weather makes where it is spoofed.

    A filter learns wind, drag and accelerometer bias (`estimation.drag_filter`). When the reported
    velocity leaves the true one by a constant offset, the specific force stays that of the
    true motion, and the wind seems to change by the offset. Weather changes too, so the limit
    grows with the wind, and this is a slow and soft voter: it sees an offset of 4 m/s long after
    its onset, and neither a displacement nor anything vertical.

    While the change is over its limit, the parameters from before are kept, so that an attack does
    not become the new weather. There is a verdict for every block.
    """

    NAME = "drag"
    PARAMETERS = DragParameters

    def __init__(self, parameters: DragParameters) -> None:
        """Start without history."""
        self._parameters = p = parameters
        self.inputs = {
            "phase": p.patience_s,
            "attitude": p.patience_s,
            "fix": p.sensor_patience_s,
            "velocity": p.sensor_patience_s,
        }
        self._lag_ns = round(p.gps_lag_s * NANOSECONDS)
        self._gap_ns = round(p.max_gap_s * NANOSECONDS)
        self._blocks = BlockBuilder(p.block_s, p.max_gap_s, p.gps_lag_s)
        self._phase = FlightPhase(p.moving_speed, p.still_share)
        self._filter = DragFilter(p.noise)
        self._checkpoints: deque[Checkpoint] = deque()
        self._recent: deque[AirBlock] = deque()
        self._errors: deque[tuple[int, float]] = deque()
        """Stamps, and how far the velocity in the body's axes may be off for the heading, m/s."""
        self._kept: Checkpoint | None = None
        self._last_ns: int | None = None
        self._persistence = Persistence(p.persist_s)
        self._gate = FlightGate()
        self._watch = InputWatch(("attitude", "GPS velocity"))
        self._gps = GpsMotion(p.max_gap_s)
        self._climb = 0.0
        self._verdict_ns: int | None = None
        """Stamp of the last verdict."""

    def update(
        self, name: str, sample: AttitudeSample | FixSample | VelocitySample | PhaseSample
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every full block gives a verdict."""
        if isinstance(sample, PhaseSample):
            self._gate.update(sample)
            return None
        if isinstance(sample, AttitudeSample):
            self._watch.see("attitude", sample.stamp_ns)
            self._blocks.attitude(sample)
            due = self._watch.due(sample.stamp_ns)
            return self._cannot_tell(sample.stamp_ns) if due else None
        if isinstance(sample, VelocitySample):
            return self._moved(self._gps.velocity(sample))
        self._climb = climb_between(self._gps.last_fix, sample)
        motion = self._gps.fix(sample)
        if motion is None or self._gps.measured(sample.stamp_ns):
            return None
        return self._moved(motion)

    def _moved(self, motion: Motion) -> Verdict | None:
        """Take a velocity; a climb that was not measured is that of the fixes, or 0.

        It enters with the sine of the tilt only.
        """
        stamp_ns, velocity = motion.stamp_ns, motion.velocity
        if math.isnan(velocity[2]):
            velocity = np.array([*velocity[:2], 0.0 if motion.from_fixes else self._climb])
        self._watch.see("GPS velocity", stamp_ns)
        block = self._blocks.velocity(stamp_ns, motion.middle_ns - self._lag_ns, velocity)
        if block is not None:
            return self._evaluate(block)
        if self._last_ns is not None and stamp_ns - self._last_ns >= self._gap_ns:
            self._forget_wind()
            self._last_ns = stamp_ns
        last = self._verdict_ns
        if last is not None and stamp_ns - last < REPEAT_NS:
            return None
        return self._cannot_tell(stamp_ns)

    def _cannot_tell(self, stamp_ns: int) -> Verdict:
        """A verdict where there is no block."""
        state, reason = self._watch.lost(stamp_ns) or (
            State.NOT_OBSERVABLE,
            "the attitude is not known",
        )
        return self._no_score(stamp_ns, state, reason)

    def _no_score(self, stamp_ns: int, state: State, reason: str) -> Verdict:
        self._persistence.reset()
        self._verdict_ns = stamp_ns
        return Verdict(self.NAME, stamp_ns, state, 0.0, self._parameters.least_limit, reason)

    def _forget_wind(self) -> None:
        """Another flight begins, or a part of this one was missed."""
        self._checkpoints.clear()
        self._recent.clear()
        self._errors.clear()
        self._kept = None
        self._filter.forget_wind()

    def _evaluate(self, block: FlightBlock) -> Verdict:
        p, stamp = self._parameters, block.air.stamp_ns
        if self._last_ns is not None and stamp - self._last_ns > self._gap_ns:
            self._forget_wind()
        self._last_ns = self._verdict_ns = stamp
        if self._phase.update(block):
            self._forget_wind()
        blocked = self._gate.blocked(stamp)
        if blocked is not None:
            self._forget_wind()
            return self._no_score(stamp, *blocked)
        unusable = self._unusable(block)
        if unusable is not None:
            return self._no_score(stamp, State.NOT_OBSERVABLE, unusable)
        self._learn(block.air)
        self._errors.append((stamp, math.sqrt(block.heading_variance) * block.speed))
        while self._errors[0][0] < stamp - round(p.recent_s * NANOSECONDS):
            self._errors.popleft()
        reference = self._reference(stamp)
        if reference is None:
            reason = f"less than {p.ready_s:g} s of flight to compare with"
            return self._no_score(stamp, State.NOT_READY, reason)
        unlearnt = self._unlearnt(reference.filter)
        if unlearnt is not None:
            self._kept = None
            return self._no_score(stamp, State.NOT_OBSERVABLE, unlearnt)
        change = reference.filter.wind_change(self._recent, p.prior_change)
        return self._judge(stamp, reference, change)

    def _unusable(self, block: FlightBlock) -> str | None:
        """Why a block cannot be used for drag, if so."""
        p = self._parameters
        if self._phase.air_s == 0.0:
            return "on the ground, or not yet in motion"
        if self._phase.air_s < p.settle_s:
            return "taking off"
        sigma = math.degrees(math.sqrt(block.heading_variance))
        if sigma > p.max_heading_sigma_deg:
            return f"heading known to {min(sigma, 180.0):.0f}° only"
        if block.tumbles:
            return f"specific force of {block.load:.0f} m/s²: falling or tumbling"
        return None

    def _learn(self, block: AirBlock) -> None:
        p, stamp = self._parameters, block.stamp_ns
        self._filter.wait(block.seconds)
        self._filter.update(block)
        self._recent.append(block)
        while self._recent[0].stamp_ns < stamp - round(p.recent_s * NANOSECONDS):
            self._recent.popleft()
        checkpoints = self._checkpoints
        if not checkpoints or stamp - checkpoints[-1].stamp_ns >= CHECKPOINT_NS:
            checkpoints.append(Checkpoint(stamp, self._filter.copy()))
        oldest_ns = stamp - round(p.frozen_s * NANOSECONDS)
        while len(checkpoints) > 1 and checkpoints[1].stamp_ns <= oldest_ns:
            checkpoints.popleft()

    def _reference(self, stamp_ns: int) -> Checkpoint | None:
        """The parameters to compare with; None in the first time of a flight."""
        p, oldest = self._parameters, self._checkpoints[0]
        kept = self._kept
        if kept is not None and stamp_ns - kept.stamp_ns <= p.hold_s * NANOSECONDS:
            return kept
        self._kept = None
        ready_ns = round(max(p.ready_s, p.recent_s) * NANOSECONDS)
        return oldest if stamp_ns - oldest.stamp_ns >= ready_ns else None

    def _unlearnt(self, learnt: DragFilter) -> str | None:
        """Why the parameters are not those of a multirotor that was learnt, if so."""
        p, drag = self._parameters, float(learnt.state[DRAG])
        if learnt.residual > p.max_residual:
            return (
                "drag does not explain the specific force: "
                f"{learnt.residual:.2f} m/s² are left (limit {p.max_residual:g})"
            )
        if drag < p.least_drag:
            return f"drag of {drag:.2f} 1/s is too small to see the air by"
        if learnt.drag_sigma > p.learnt_share * p.drag_sigma:
            return f"drag is not learnt yet: {drag:.2f} ± {learnt.drag_sigma:.2f} 1/s"
        return None

    def _judge(self, stamp_ns: int, reference: Checkpoint, change: WindChange) -> Verdict:
        p, before = self._parameters, reference.filter
        turned = max(error for _, error in self._errors)
        grown = p.heading_gain * math.sqrt(max(0.0, turned**2 - KNOWN_TURN**2))
        limit = math.hypot(p.limit(before.wind_speed), grown)
        over = change.size > limit
        verdict = Verdict(
            self.NAME,
            stamp_ns,
            State.NORMAL,
            change.size,
            limit,
            f"The GPS velocity needs a wind change of {change.size:.1f} m/s in "
            f"{(stamp_ns - reference.stamp_ns) / NANOSECONDS:.0f} s (limit {limit:.1f})",
            {"wind_change": change.size, "sigma": change.sigma, **before.figures()},
        )
        if (change.sigma_along if over else change.sigma) > p.max_sigma:
            self._kept = None
            self._persistence.reset()
            reason = (
                f"wind and bias cannot be told apart on this route: the change of wind is known to "
                f"{change.sigma:.1f} m/s only (limit {p.max_sigma:g})"
            )
            return replace(verdict, state=State.NOT_OBSERVABLE, score=0.0, reason=reason)
        if over:
            self._kept = reference
        elif change.size < RELEASE * limit:
            self._kept = None
        return replace(verdict, state=self._persistence.state(stamp_ns, over))
