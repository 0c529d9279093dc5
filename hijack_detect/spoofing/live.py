# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A spoofer on a live stream: attacks can be set and changed while it runs."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from hijack_detect.parameters import ParameterError, Parameters, param
from hijack_detect.spoofing.scenario import (
    Scenario,
    ScenarioError,
    load_scenario,
    parse_scenario,
)
from hijack_detect.spoofing.schema import MAX_ACCURACY_M, MIN_ACCURACY_M
from hijack_detect.spoofing.spoofer import RECENT, Spoofer
from hijack_detect.streams.messages import MAX_SATELLITES, MAX_SPEED
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample, VelocitySample
from hijack_detect.streams.silence import RESTART_S
from hijack_detect.yaml_text import YamlTextError, plain_data

SOFT = frozenset(
    (
        "seed",
        "altitude_sigma_m",
        "satellites_low",
        "satellites_high",
        "accuracy_low_m",
        "accuracy_high_m",
        "correlation_s",
    )
)
HARD = SOFT | {
    "horizontal_sigma_m",
    "velocity_sigma_m_s",
    "drift_speed_m_s",
    "bearing_deg",
    "relative",
    "onset_acceleration_m_s2",
}
USED: Mapping[str, Collection[str]] = {
    "none": (),
    "soft": SOFT,
    "hard": HARD,
    "model": ("model",),
    "scenario": ("scenario",),
}
"""The parameters of each mode."""


@dataclass(frozen=True)
class SpooferParameters(Parameters):
    """Parameters of the live spoofer; all but `keep` can change while it runs."""

    mode: str = param(
        "none",
        "none: everything passes unchanged. soft: altitude, number of satellites and claimed "
        "accuracy are forged. hard: position and velocity too. model: the attack in 'model' "
        "starts with the next fix. scenario: the file in 'scenario', whose times count from the "
        "next fix. Setting the mode again restarts its attack.",
        source=("Basan 2022, section 3.1: no attack, light and intense; ours: model and scenario"),
        choices=tuple(USED),
    )
    model: str = param(
        "",
        "Mode model: one attack as the 'model' of a scenario file, such as {type: freeze}.",
        source="chosen: empty, the attack has to be given",
    )
    scenario: str = param(
        "",
        "Mode scenario: path of a scenario file.",
        source="chosen: empty, the file has to be given",
    )
    seed: int = param(
        1,
        "Seed of all draws.",
        source="chosen: any number; one that is fixed makes a test repeatable",
        low=0,
        high=2**63 - 1,
    )
    altitude_sigma_m: float = param(
        4.2,
        "Standard deviation added to the altitude.",
        source="Basan 2022, Table 4: 4.214 in soft mode of the simulation",
        unit="m",
        low=0.0,
        high=10_000.0,
    )
    satellites_low: int = param(
        6,
        "Smallest number of satellites.",
        source="chosen: wider than the 9 to 19 of Basan 2022, Table 1",
        low=0,
        high=MAX_SATELLITES,
    )
    satellites_high: int = param(
        20,
        "Largest number of satellites.",
        source="chosen: wider than the 9 to 19 of Basan 2022, Table 1",
        low=0,
        high=MAX_SATELLITES,
    )
    accuracy_low_m: float = param(
        0.5,
        "Smallest claimed standard deviation.",
        source=("chosen, not swept; the paper gives none, docs/reproduction.md uses 1 to 5 m"),
        unit="m",
        low=MIN_ACCURACY_M,
        high=MAX_ACCURACY_M,
    )
    accuracy_high_m: float = param(
        8.0,
        "Largest claimed standard deviation.",
        source=("chosen, not swept; the paper gives none, docs/reproduction.md uses 1 to 5 m"),
        unit="m",
        low=MIN_ACCURACY_M,
        high=MAX_ACCURACY_M,
    )
    horizontal_sigma_m: float = param(
        3.0,
        "Mode hard: standard deviation added to East and North each.",
        source="chosen, not swept; the paper gives none, docs/reproduction.md uses 2 m",
        unit="m",
        low=0.0,
        high=100_000.0,
    )
    velocity_sigma_m_s: float = param(
        0.5,
        "Mode hard: standard deviation added to East and North velocity each.",
        source="chosen, as in docs/reproduction.md; the paper gives none",
        unit="m/s",
        low=0.0,
        high=100.0,
    )
    drift_speed_m_s: float = param(
        2.0,
        "Mode hard: final speed of the displacement.",
        source=(
            "chosen: that of the first hard mode in docs/reproduction.md; the paper gives none"
        ),
        unit="m/s",
        low=0.0,
        high=MAX_SPEED,
    )
    bearing_deg: float = param(
        0.0,
        "Mode hard: direction of the displacement, clockwise from North.",
        source="chosen: North; the paper gives none",
        unit="deg",
        low=-360.0,
        high=360.0,
    )
    relative: bool = param(
        False,
        "Mode hard: count the bearing from the course at onset instead of from North.",
        source="chosen: absolute, so that it needs no course at onset",
    )
    onset_acceleration_m_s2: float = param(
        1.0,
        "Mode hard: acceleration of the displacement until it has its final speed.",
        source="chosen: 2 m/s after 2 s, not swept",
        unit="m/s²",
        low=0.001,
        high=1000.0,
    )
    correlation_s: float = param(
        0.0,
        "Time between independent draws, with straight lines in between; 0 draws for each fix.",
        source="Basan 2022, section 3.1: data are generated with each update",
        unit="s",
        low=0.0,
        high=1000.0,
    )
    keep: int = param(
        20_000,
        "Messages of each output that are kept for a subscriber which comes late or comes back "
        "and requests them.",
        source="physics: 20000 messages are 67 min at 5 Hz, longer than a battery lasts",
        low=1,
        high=1_000_000,
        fixed=True,
    )

    def __post_init__(self) -> None:
        """See Parameters; also checks that ranges are in order."""
        super().__post_init__()
        for low, high in (
            ("satellites_low", "satellites_high"),
            ("accuracy_low_m", "accuracy_high_m"),
        ):
            if getattr(self, low) > getattr(self, high):
                raise ParameterError(
                    f"parameter '{low}' is {getattr(self, low)!r}, above '{high}' "
                    f"({getattr(self, high)!r}); set both at once"
                )


def chosen_attack(parameters: SpooferParameters, changed: Collection[str] = ()) -> Scenario:
    """The attack that the parameters ask for.

    Args:
        parameters: The parameters.
        changed: Names of those that were given just now. A model or a file among them is checked
            even if the mode does not use it.

    Raises:
        ParameterError: The mode needs a parameter that is empty, or the model cannot be used.
        ScenarioError: The file cannot be used; every problem found is in the message.
    """
    if "model" in changed and parameters.model:
        _model(parameters.model)
    if "scenario" in changed and parameters.scenario:
        load_scenario(parameters.scenario)
    if parameters.mode in ("soft", "hard"):
        return _forged(parameters)
    if parameters.mode == "model":
        return _model(parameters.model)
    if parameters.mode == "scenario":
        if not parameters.scenario:
            raise ParameterError("mode scenario needs a file in the parameter 'scenario'")
        return load_scenario(parameters.scenario)
    return NOTHING


def _forged(parameters: SpooferParameters) -> Scenario:
    """Soft or hard mode as a scenario of one segment that starts at once."""
    values = {name: getattr(parameters, name) for name in USED[parameters.mode]}
    for key, low, high in (
        ("satellites", "satellites_low", "satellites_high"),
        ("accuracy_m", "accuracy_low_m", "accuracy_high_m"),
    ):
        values[key] = [values.pop(low), values.pop(high)]
    return _at_once({"type": "forge", **values}, f"mode {parameters.mode}", parameters.mode)


def _model(text: str) -> Scenario:
    """One model, given as YAML, as a scenario of one segment that starts at once."""
    where = "parameter 'model'"
    if not text:
        raise ParameterError(f"mode model needs an attack in the {where}, such as {{type: freeze}}")
    try:
        data = plain_data(text)
    except YamlTextError as error:
        raise ParameterError(f"{where}: {error}") from error
    if isinstance(data, Mapping) and data.get("type") == "replay":
        raise ParameterError(
            f"{where}: a replay needs a recording of what went before; write it into a scenario "
            "file and use mode scenario"
        )
    try:
        return _at_once(data, where, "")
    except ScenarioError as error:
        problems = [problem.replace("segment 1: ", "", 1) for problem in error.problems]
        raise ParameterError("\n".join(problems)) from error


def _at_once(model: object, source: str, name: str) -> Scenario:
    segment = {"start": 0.0, "name": name, "model": model}
    return parse_scenario({"segments": [segment]}, source)


NOTHING = Scenario("none", ())
"""The scenario without an attack."""
NEW_FLIGHT_S = 3600.0
"""A stamp later than the last one by more than this belongs to another flight. Chosen: longer than
any outage of a receiver in flight."""


class LiveSpoofer:
    """Turns true samples into reported ones, under attacks that are set while it runs.

    An attack takes effect at the next fix, and its times count from the stamp of that fix, so a
    scenario that is set before the first fix counts from the first fix. It starts from the true
    samples before that, not from the reported ones; setting it again restarts it.
    Velocities and numbers of satellites that arrive later than that fix and have an older stamp
    are still under the attack before.

    When the stamps run far backwards, or ahead by an hour (a looped bag, a clock that was set),
    the attack restarts without history.

    Attributes:
        start_ns: Stamp of the fix from which the times of the scenario count, None before it.
        offset_m: Separation of the last true and the last reported fix, metres in three
            dimensions; 0 after a fix that was passed on as it is.
        restarts: How often the stamps have jumped to another flight.
    """

    def __init__(self, scenario: Scenario = NOTHING) -> None:
        """Begin with an attack."""
        self.start_ns: int | None = None
        self.offset_m = 0.0
        self.restarts = 0
        self._scenario = scenario
        self._pending = True
        self._before = self._spoofer = Spoofer(NOTHING, 0)
        self._last_ns: int | None = None
        self._fixes: deque[FixSample] = deque(maxlen=RECENT)
        self._velocities: deque[VelocitySample] = deque(maxlen=RECENT)

    def set(self, scenario: Scenario) -> None:
        """Replace the attack from the next fix on, or restart the same one."""
        self._scenario = scenario
        self._pending = True

    def fix(self, sample: FixSample) -> FixSample:
        """Return the reported fix in place of a true one."""
        self._follow(sample.stamp_ns)
        if self._pending:
            self._begin(sample.stamp_ns)
        spoofer = self._at(sample.stamp_ns)
        reported = spoofer.fix(sample)
        self.offset_m = 0.0 if reported is sample else spoofer.offset_m
        if sample.has_fix:
            self._fixes.append(sample)
        return reported

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """Return the reported velocity in place of a true one."""
        self._velocities.append(sample)
        return self._at(sample.stamp_ns).velocity(sample)

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """Return the reported number of satellites in place of a true one."""
        return self._at(sample.stamp_ns).satellites(sample)

    def active(self, stamp_ns: int) -> bool:
        """Ground truth: whether an attack covers the stamp of a sample that was given."""
        return self._at(stamp_ns).active(stamp_ns)

    @property
    def onset_ns(self) -> int | None:
        """Stamp at which the attack on the last fix began, None if it was not attacked."""
        return None if self._last_ns is None else self._spoofer.onset_ns(self._last_ns)

    def _at(self, stamp_ns: int) -> Spoofer:
        """The spoofer in force at a stamp."""
        if self.start_ns is None or stamp_ns < self.start_ns:
            return self._before
        return self._spoofer

    def _follow(self, stamp_ns: int) -> None:
        """Notice the stamps of another flight."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is None:
            return
        ahead_s = (stamp_ns - last_ns) / NANOSECONDS
        if -RESTART_S <= ahead_s <= NEW_FLIGHT_S:
            return
        self.restarts += 1
        self._fixes.clear()
        self._velocities.clear()
        self._spoofer = Spoofer(NOTHING, 0)
        self._pending = True

    def _begin(self, stamp_ns: int) -> None:
        """Put the attack into force, with the last true samples known to it."""
        self._pending = False
        self._before, self._spoofer = self._spoofer, Spoofer(self._scenario, stamp_ns)
        self.start_ns = stamp_ns
        recent: list[FixSample | VelocitySample] = [*self._fixes, *self._velocities]
        for sample in sorted(recent, key=lambda one: one.stamp_ns):
            self._spoofer.report(sample)
