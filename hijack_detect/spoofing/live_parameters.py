# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which attack a live spoofer runs: the modes of Basan et al. 2022, a model, or a scenario."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from hijack_detect.parameters import ParameterError, Parameters, param
from hijack_detect.spoofing.forge_schema import MAX_ACCURACY_M, MIN_ACCURACY_M
from hijack_detect.spoofing.live import NOTHING
from hijack_detect.spoofing.scenario import (
    Scenario,
    ScenarioError,
    load_scenario,
    parse_scenario,
)
from hijack_detect.streams.messages import MAX_SATELLITES, MAX_SPEED
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
"""The parameters that say what the attack of each mode is."""


@dataclass(frozen=True)
class SpooferParameters(Parameters):
    """Parameters of the live spoofer; all but `keep` can change while it runs."""

    mode: str = param(
        "none",
        "none: everything passes as it is. soft: altitude, number of satellites and claimed "
        "accuracy are forged. hard: position and velocity too (Basan 2022, section 3.1). model: "
        "the attack in 'model' starts with the next fix. scenario: the file in 'scenario', whose "
        "times count from the next fix. Setting the mode again starts its attack anew.",
        choices=tuple(USED),
    )
    model: str = param(
        "", "Mode model: one attack as the 'model' of a scenario file, such as {type: freeze}."
    )
    scenario: str = param("", "Mode scenario: path of a scenario file.")
    seed: int = param(1, "Seed of all draws.", low=0, high=2**63 - 1)
    altitude_sigma_m: float = param(
        4.2,
        "Standard deviation added to the altitude; 4.2 is soft mode in Table 4 of Basan 2022.",
        unit="m",
        low=0.0,
        high=10_000.0,
    )
    satellites_low: int = param(6, "Smallest number of satellites.", low=0, high=MAX_SATELLITES)
    satellites_high: int = param(20, "Largest number of satellites.", low=0, high=MAX_SATELLITES)
    accuracy_low_m: float = param(
        0.5,
        "Smallest claimed standard deviation.",
        unit="m",
        low=MIN_ACCURACY_M,
        high=MAX_ACCURACY_M,
    )
    accuracy_high_m: float = param(
        8.0,
        "Largest claimed standard deviation.",
        unit="m",
        low=MIN_ACCURACY_M,
        high=MAX_ACCURACY_M,
    )
    horizontal_sigma_m: float = param(
        3.0,
        "Mode hard: standard deviation added to East and North each.",
        unit="m",
        low=0.0,
        high=100_000.0,
    )
    velocity_sigma_m_s: float = param(
        0.5,
        "Mode hard: standard deviation added to East and North velocity each.",
        unit="m/s",
        low=0.0,
        high=100.0,
    )
    drift_speed_m_s: float = param(
        2.0, "Mode hard: final speed of the displacement.", unit="m/s", low=0.0, high=MAX_SPEED
    )
    bearing_deg: float = param(
        0.0,
        "Mode hard: direction of the displacement, clockwise from North.",
        unit="deg",
        low=-360.0,
        high=360.0,
    )
    relative: bool = param(
        False, "Mode hard: count the bearing from the course at onset instead of from North."
    )
    onset_acceleration_m_s2: float = param(
        1.0,
        "Mode hard: how fast the displacement gathers speed.",
        unit="m/s²",
        low=0.001,
        high=1000.0,
    )
    correlation_s: float = param(
        0.0,
        "Time between independent draws, with straight lines in between; 0 draws anew for each "
        "fix, as the paper does.",
        unit="s",
        low=0.0,
        high=1000.0,
    )
    keep: int = param(
        20_000,
        "Messages of each output that are kept for a subscriber which comes late or comes back "
        "and asks for them; 20000 are more than an hour of 5 Hz.",
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
        said = [problem.replace("segment 1: ", "", 1) for problem in error.problems]
        raise ParameterError("\n".join(said)) from error


def _at_once(model: object, source: str, name: str) -> Scenario:
    segment = {"start": 0.0, "name": name, "model": model}
    return parse_scenario({"segments": [segment]}, source)
