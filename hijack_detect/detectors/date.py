# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS acceleration against the accelerometer: the DATE'17 method of Feng et al. 2018, §3.4."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.attitude_window import AttitudeMeans
from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.input_watch import InputWatch, patience
from hijack_detect.detectors.persistence import Excursion, Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.detectors.window import FULL, WindowSums
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.growing_lag import GrowingLag
from hijack_detect.estimation.lag_ekf import LATE, late, late_words
from hijack_detect.estimation.learning import NoiseScale
from hijack_detect.estimation.motion import GpsMotion, Motion
from hijack_detect.estimation.rotation import Array, up_component
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
class DateParameters(Parameters):
    """Defaults are the hardened variant; the faithful values of Feng 2018 are in each text."""

    window_s: float = param(
        2.0,
        "Differences of acceleration are averaged over this time. Faithful: 2.0, as for the "
        "correlation; the paper gives none.",
        source="chosen: as Algorithm 2; Feng 2018, §3.4, gives none",
        unit="s",
        low=0.2,
        high=60.0,
    )
    threshold: float = param(
        1.5,
        "Largest horizontal difference of acceleration that is normal, with `noise_gain` 0. The "
        "paper gives none: take it from clean flights of the vehicle.",
        source="measured: set on the flights of docs/flights.md",
        unit="m/s²",
        low=0.05,
        high=50.0,
    )
    noise_gain: float = param(
        6.2,
        "The limit is this times the RMS difference of this flight so far: 5.4 times is the most "
        "on clean flights of a receiver that loses its fix, 4.0 on others. Faithful: 0, the limit "
        "is `threshold`.",
        source="measured: 5.4 on clean recorded flights, with 15 % (docs/detection-limits.md)",
        low=0.0,
        high=100.0,
    )
    least_limit: float = param(
        0.4,
        "Smallest limit that `noise_gain` gives.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.05,
        high=50.0,
    )
    settle_s: float = param(
        20.0,
        "NOT_READY until that RMS is learnt from this much flight.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=600.0,
    )
    max_force: float = param(
        25.0,
        "NOT_OBSERVABLE for `recover_s` after a specific force above this: aerobatics or a crash. "
        "Faithful: 1000 (off).",
        source="as max_force of coast",
        unit="m/s²",
        low=11.0,
        high=1000.0,
    )
    recover_s: float = param(
        30.0, "See `max_force`.", source="as recover_s of coast", unit="s", low=1.0, high=600.0
    )
    gps_lag_s: float = param(
        0.15,
        "Time from when a GPS velocity was true to its header stamp. Faithful: 0 (ignored).",
        source="measured: recorded receivers 0.02 to 0.28 s (docs/detectors.md)",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    max_lag_s: float = param(
        1.55,
        "A lag that grows in flight is followed up to this. Faithful: 0 (the lag is constant, and "
        "every interval counts the same, however long).",
        source="measured: latencies that grow by 1.2 s (docs/detectors.md)",
        unit="s",
        low=0.0,
        high=3.0,
    )
    persist_s: float = param(
        0.4,
        "The difference must last this long to be an ALARM; SUSPICIOUS before. Faithful: 0.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    max_tilt_deg: float = param(
        75.0,
        "NOT_OBSERVABLE for one window after the body was tilted by more than this: a vehicle "
        "that tumbles or has crashed. Faithful: 180 (off).",
        source="chosen, not swept",
        unit="deg",
        low=10.0,
        high=180.0,
    )
    in_flight: bool = param(
        True,
        "Judge and learn only while the vehicle is in the air with a usable IMU. Faithful: false.",
        source="chosen, not swept",
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
    max_gap_s: float = param(
        2.0,
        "GPS velocities further apart than this are not compared.",
        source="the time after which StreamMerge counts an outage (SILENCE_S)",
        unit="s",
        low=0.1,
        high=60.0,
    )


USUAL_NOISE = 0.35
"""m/s²: RMS difference of acceleration before anything is learnt. Chosen, not swept."""

LEAST_NOISE = 0.1
"""m/s²: RMS difference below which none is taken for an argument against a lag.
Chosen on the trials with latency of docs/detectors.md."""

EXPLAINED = 0.7
"""A lag explains a difference beyond the limit if it leaves no more than this part of the limit:
what it leaves counts as that over this part. With 1, an attack in motion is missed where another
lag leaves a little less by chance: a quarter fewer velocities that freeze at zero are found."""

NOISE_MEMORY_S = 60.0
"""The usual difference is learnt from about this time. Chosen, not swept."""
NOISE_DELAY_S = 8.0
"""Only differences this old are learnt there. Chosen, not swept."""

RECENT_S = 10.0
"""The difference is learnt from about this time, too: a receiver that gets worse does so within
seconds (on a recorded flight from 0.4 to 1.4 m/s² within 4 s, 20 s before it failed)."""

NOISE_BOUNDS = (0.01, 10.0)
"""m/s²: bounds of what is learnt. Chosen, not swept; below 0.06 `least_limit` holds anyway."""
NOISE_PRIOR_S = 10.0
"""USUAL_NOISE weighs as much as this time of differences. Chosen, not swept."""
NOISE_CLIP = 3.5
"""A difference counts as this many times the usual one at most. Chosen, not swept."""


class DateDetector:
    """Mean of `Rᵀ(a_gps − g)` less specific force, horizontally: a motion that only the GPS has.

    An accelerometer measures specific force, so gravity is taken off the GPS acceleration
    before it is turned into the body frame. The acceleration comes from successive GPS
    velocities, or from fixes alone where there is no recent GPS velocity. Each
    interval between two GPS samples gives one difference; Δa is their mean over the window.

    A latency may grow in flight. So the same is done at every lag that may be the right one
    (`GrowingLag`), and it is an alarm if the difference is beyond the limit at the lag in use, and
    no other lag explains it. An acceleration that only the GPS has is the same at every lag.
    """

    NAME = "date"
    PARAMETERS = DateParameters

    def __init__(self, parameters: DateParameters) -> None:
        """Start without history."""
        self._parameters = p = parameters
        self.inputs = {
            "phase": p.patience_s,
            "attitude": p.patience_s,
            "fix": p.sensor_patience_s,
            "velocity": p.sensor_patience_s,
        }
        self._lag_ns = round(p.gps_lag_s * NANOSECONDS)
        self._window_ns = round(p.window_s * NANOSECONDS)
        self._lag = GrowingLag(p.gps_lag_s, p.max_lag_s)
        self._back_ns = np.rint((self._lag.lags_s - p.gps_lag_s) * NANOSECONDS).astype(np.int64)
        self._window = WindowSums(self._window_ns, 3 * len(self._back_ns) + 1)
        self._interval_ns = 0
        """Time between the last two GPS velocities: what the newest difference covers."""
        self._persistence = Persistence(p.persist_s)
        self._gate = FlightGate()
        self._watch = InputWatch(("attitude", "GPS velocity"))
        self._attitudes = AttitudeMeans(2 * p.max_gap_s + max(p.gps_lag_s, p.max_lag_s))
        self._gps = GpsMotion(p.max_gap_s)
        self._motion: Motion | None = None
        self._lowest_up = math.cos(math.radians(p.max_tilt_deg))
        self._tumbling = Excursion(p.window_s, p.window_s)
        self._violent = Excursion(p.recover_s, p.recover_s)
        self._noises = tuple(
            NoiseScale(
                *NOISE_BOUNDS,
                delay_s=delay_s,
                memory_s=memory_s,
                prior_s=NOISE_PRIOR_S,
                clip=NOISE_CLIP,
                prior=USUAL_NOISE,
            )
            for delay_s, memory_s in (
                (NOISE_DELAY_S, NOISE_MEMORY_S),
                (2.0 * p.window_s, RECENT_S),
            )
        )
        self._followed_ns: int | None = None
        self._judged_s = 0.0
        """Time whose differences have been seen."""

    def update(
        self, name: str, sample: AttitudeSample | FixSample | VelocitySample | PhaseSample
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every GPS velocity gives a verdict."""
        if isinstance(sample, PhaseSample):
            if self._parameters.in_flight:
                self._gate.update(sample)
            return None
        if isinstance(sample, AttitudeSample):
            self._watch.see("attitude", sample.stamp_ns)
            self._attitudes.add(sample)
            q, stamp = sample.orientation, sample.stamp_ns
            force = math.hypot(*sample.specific_force)
            self._violent.see(stamp, force > self._parameters.max_force)
            self._tumbling.see(stamp, q is not None and up_component(q) < self._lowest_up)
            return self._verdict(sample.stamp_ns) if self._watch.due(sample.stamp_ns) else None
        if isinstance(sample, VelocitySample):
            return self._evaluate(self._gps.velocity(sample))
        motion = self._gps.fix(sample)
        return None if self._gps.measured(sample.stamp_ns) else self._evaluate(motion)

    def _evaluate(self, motion: Motion | None) -> Verdict | None:
        previous, self._motion = self._motion, motion
        if previous is not None and motion is not None and previous.from_fixes != motion.from_fixes:
            # A window of both kinds would hold the noise of fixes to the limit of velocities.
            self._window.clear()
        if motion is None or (previous is not None and previous.stamp_ns == motion.stamp_ns):
            return None
        self._watch.see("GPS velocity", motion.stamp_ns)
        difference = None if previous is None else self._difference(previous, motion)
        if previous is None or difference is None:
            self._window.clear()
        else:
            self._interval_ns = motion.stamp_ns - previous.stamp_ns
            # Weighed by time, stamps that jump where a lag falls cancel out.
            weight = self._interval_ns / self._window_ns if self._lag.grows else 1.0
            self._window.add(motion.stamp_ns, [*(weight * difference).ravel().tolist(), weight])
        return self._verdict(motion.stamp_ns)

    def _difference(self, before: Motion, after: Motion) -> Array | None:
        """Rᵀ(a_gps − g) − f over one interval, FLU, at each lag, shape (n, 3).

        None where it is unknown at the usual lag; that one stands in for lags without attitudes.
        """
        if before.from_fixes is not after.from_fixes:
            return None
        dt = (after.middle_ns - before.middle_ns) / NANOSECONDS
        if not 0.0 < dt <= self._parameters.max_gap_s:
            return None
        rotation, force, known = self._attitudes.over(
            before.middle_ns - self._lag_ns, after.middle_ns - self._lag_ns, self._back_ns
        )
        usual = self._lag.usual
        if not known[usual]:
            return None
        acceleration = np.tile((after.velocity - before.velocity) / dt, (len(force), 1))
        if math.isnan(acceleration[0, 2]):  # not measured: only the horizontal part is compared
            acceleration[:, 2] = (rotation @ force[:, :, None])[:, 2, 0] - GRAVITY
        acceleration = acceleration + np.array([0.0, 0.0, GRAVITY])
        felt = (rotation.transpose(0, 2, 1) @ acceleration[:, :, None])[:, :, 0]
        difference: Array = felt - force
        difference[~known] = difference[usual]
        return difference

    @property
    def _covered_ns(self) -> int:
        """Time that the differences in the window cover."""
        return self._window.span_ns + self._interval_ns

    @property
    def _limit(self) -> float:
        """Largest normal difference, m/s²."""
        p = self._parameters
        if p.noise_gain == 0.0:
            return p.threshold
        return max(p.least_limit, p.noise_gain * max(one.value for one in self._noises))

    def _unable(self, stamp_ns: int) -> tuple[State, str] | None:
        """State and reason if the GPS cannot be judged."""
        p = self._parameters
        if not len(self._window) or self._covered_ns < FULL * self._window_ns:
            return State.NOT_READY, f"less than {p.window_s:g} s of attitude and GPS velocity"
        if self._tumbling.lasts(stamp_ns):
            reason = f"tilted by more than {p.max_tilt_deg:g}°: tumbling or crashed"
            return State.NOT_OBSERVABLE, reason
        if self._violent.lasts(stamp_ns):
            reason = f"specific force above {p.max_force:g} m/s² less than {p.recover_s:g} s ago"
            return State.NOT_OBSERVABLE, reason
        return self._gate.blocked(stamp_ns)

    def _verdict(self, stamp_ns: int) -> Verdict:
        limit = self._limit
        unable = self._watch.lost(stamp_ns) or self._unable(stamp_ns)
        if unable is not None:
            self._persistence.reset()
            return Verdict(self.NAME, stamp_ns, unable[0], 0.0, limit, unable[1])
        deltas = self._deltas()
        scores = np.hypot(deltas[:, 0], deltas[:, 1])
        self._follow(stamp_ns, scores)
        held, at = self._lag.held, int(np.argmin(np.where(self._lag.judged, scores, np.inf)))
        score = float(min(scores[held], scores[at] / EXPLAINED))
        ax, ay, az = deltas[at if score < scores[held] and score <= limit else held].tolist()
        values = {"delta_ax": ax, "delta_ay": ay, "delta_az": az, **late(self._lag.least_s)}
        if self._learning(stamp_ns, float(scores[held]), score > limit):
            self._persistence.reset()
            reason = "the usual difference of this vehicle is learnt"
            return Verdict(self.NAME, stamp_ns, State.NOT_READY, 0.0, limit, reason, values)
        state = self._persistence.state(stamp_ns, score > limit)
        size = math.hypot(ax, ay)
        reason = f"GPS and accelerometer differ by Δa {size:.2f} m/s² (limit {limit:.3g})"
        if state is not State.NORMAL:
            reason = (
                f"The GPS accelerates by {size:.2f} m/s² that the accelerometer does not feel, "
                f"over {self._parameters.window_s:g} s (limit {limit:.3g})"
            )
        if words := late_words(values):
            reason += f"; {LATE}: {words}"
        return Verdict(self.NAME, stamp_ns, state, score, limit, reason, values)

    def _deltas(self) -> Array:
        """Mean difference over the window at each lag, FLU, m/s², shape (n, 3)."""
        *sums, weight = self._window.means()
        deltas: Array = np.array(sums).reshape(-1, 3) / weight
        return deltas

    def _follow(self, stamp_ns: int, scores: Array) -> None:
        """Take the size of the differences at each lag as arguments against the lags."""
        since, self._followed_ns = self._followed_ns, stamp_ns
        if since is None or not self._lag.grows:
            return
        noise = max(LEAST_NOISE, self._noises[0].value)
        part = min(1.0, self._interval_ns / self._window_ns)
        self._lag.update((stamp_ns - since) / NANOSECONDS, part * np.square(scores / noise))

    def _learning(self, stamp_ns: int, usual: float, beyond: bool) -> bool:
        """Account a difference for the noise; whether too little of it is known."""
        p = self._parameters
        if p.noise_gain == 0.0:
            return False
        settling = self._judged_s < p.settle_s
        if settling:
            self._judged_s += self._interval_ns / NANOSECONDS
        for noise in self._noises:
            if beyond and not settling:
                noise.hold()
            else:
                noise.add(stamp_ns, usual**2)
        return settling
