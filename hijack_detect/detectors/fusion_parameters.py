# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the fusion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.likelihood import UNCALIBRATED, Weight
from hijack_detect.parameters import ParameterError, Parameters, param


@dataclass(frozen=True)
class FusionParameters(Parameters):
    """Parameters of the fusion."""

    policy: str = param(
        "default",
        "`paper`: alert when correlation and DATE have both claimed a hijack (§5: 'when the "
        "results of all the methods are hijacked'); claims are kept for the flight. Use it with "
        "the faithful detectors. `any`: alert when any detector alarms. `default`: alert when the "
        "likelihood ratios of all detectors together make an attack probable enough.",
        choices=("paper", "any", "default"),
    )
    further_detectors: str = param(
        "",
        "Detectors of your own that are heard too: names with spaces between them, each of which "
        "publishes NAME/verdict. One that is missing makes the monitor degraded. With policy "
        "`default` they support an alert and never give one, unless `further_weights` says more; "
        "with `any` their alarm is an alert; `paper` does not ask them.",
    )
    further_weights: str = param(
        "",
        "Policy `default`: what detectors of your own count for, NAME=SLOPE,NEUTRAL,LOW,HIGH with "
        "spaces between them: the likelihood ratio SLOPE · ln(margin / NEUTRAL), from LOW to HIGH "
        "nats, and their alarm makes an alert. Words can follow, with commas: `supports`, the "
        "alarm alone makes none; `carry_off`, it could see a carry-off; `keeps_alarm`, until it is "
        "reset itself; `velocity` or `height` of the receiver, a source of error of others too, of "
        "which only one counts. `advisory` instead of numbers: it is only shown.",
    )
    prior: float = param(
        0.1,
        "Policy `default`: probability of an attack before anything is heard. Only the ratio of "
        "this to `alarm_probability` decides.",
        low=1e-6,
        high=0.5,
    )
    alarm_probability: float = param(
        0.65,
        "Policy `default`: ALARM from this probability on, if a detector alarms. Lower it where a "
        "missed attack costs more than a false alarm.",
        low=0.5,
        high=0.9999,
    )
    warn_probability: float = param(
        0.9,
        "Policy `default`: SUSPICIOUS from this probability on, whatever single detectors say, "
        "until it is below half of it.",
        low=0.01,
        high=0.9999,
    )
    together_s: float = param(
        5.0,
        "Policy `default`: margins this close together count as one event; a margin speaks for "
        "this long.",
        unit="s",
        low=0.0,
        high=600.0,
    )
    debounce_s: float = param(
        0.2,
        "Policy `default`: the probability must be high for this long.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    patience_s: float = param(
        5.0,
        "How long to wait for a detector that has gone silent, on the stamps of the others: an "
        "alert comes this much later when a detector has just died. For replays faster than real "
        "time far larger.",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    stale_s: float = param(
        3.0,
        "A detector whose newest verdict is this much older than the newest of all is STALE.",
        unit="s",
        low=0.1,
        high=600.0,
    )
    overdue_s: float = param(
        120.0,
        "A detector that has been NOT_READY for this long is overdue, and the monitor degraded. On "
        "the ground, where no heading can be known, that is true as well.",
        unit="s",
        low=1.0,
        high=36000.0,
    )
    survive_s: float = param(
        20.0,
        "An alert outlives the node when it is started again within this time, as launch does "
        "after a crash; not when the node was asked to end. 0 lets none survive.",
        unit="s",
        low=0.0,
        high=3600.0,
    )

    def __post_init__(self) -> None:
        """See Parameters; names of detectors must be part of a topic's name."""
        super().__post_init__()
        names = self.further_detectors.split()
        for name in names:
            if not name.isidentifier() or names.count(name) > 1:
                raise ParameterError(
                    "parameter 'further_detectors' must be different names of letters, digits and "
                    f"underscores with spaces between them, got '{name}'"
                )
        for one in self.further_weights.split():
            name, _, text = one.partition("=")
            try:
                Weight.from_text(text)
            except (TypeError, ValueError) as error:
                raise ParameterError(f"parameter 'further_weights', '{one}': {error}") from error
            if name not in names:
                raise ParameterError(
                    f"parameter 'further_weights' has '{name}', which 'further_detectors' has not"
                )

    @property
    def further(self) -> Mapping[str, Weight]:
        """The detectors in `further_detectors`, and what they count for."""
        given = dict(one.split("=", 1) for one in self.further_weights.split())
        return {
            name: Weight.from_text(given[name]) if name in given else UNCALIBRATED
            for name in self.further_detectors.split()
        }
