# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters declared once: a frozen dataclass holds default, unit, bounds and meaning.

The same declaration is what a node turns into ROS parameters, what an offline run reads from
YAML, and what the configuration files are checked against.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, TypeVar, cast

Value = float | int | bool | str
P = TypeVar("P", bound="Parameters")


class ParameterError(ValueError):
    """A parameter has an unknown name, a wrong type, or a value outside its bounds."""


def param(
    default: Value,
    doc: str,
    *,
    source: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    fixed: bool = False,
    basic: bool = False,
) -> Any:
    """Declare one parameter as a dataclass field.

    Args:
        default: Value used when nothing else is given; its type is the parameter's type.
        doc: What it means, and when to change it.
        source: Where the default comes from: paper and section; the physics, with its derivation;
            what was measured, with the place of the table; or "chosen", with what was tried.
        unit: Unit of the value, empty for none.
        low: Smallest allowed number.
        high: Largest allowed number.
        choices: The allowed strings.
        fixed: Whether it cannot change while a node runs, where others can.
        basic: Whether it is one of the few that an integrator sets for a vehicle.
    """
    return dataclasses.field(
        default=default,
        metadata={
            "doc": doc,
            "source": source,
            "unit": unit,
            "low": low,
            "high": high,
            "choices": choices,
            "fixed": fixed,
            "basic": basic,
        },
    )


@dataclasses.dataclass(frozen=True)
class Parameters:
    """Base of every parameter set; checks all values when it is made."""

    def __post_init__(self) -> None:
        """Check every value against its declaration.

        Raises:
            ParameterError: Names the parameter, the value and what is allowed.
        """
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, _checked(field, getattr(self, field.name)))

    @classmethod
    def from_mapping(cls: type[P], values: Mapping[str, Any]) -> P:
        """Make a parameter set from a mapping, defaults for what is missing.

        Raises:
            ParameterError: A name is unknown or a value is refused.
        """
        known = [field.name for field in dataclasses.fields(cls)]
        unknown = sorted(set(values) - set(known))
        if unknown:
            raise ParameterError(
                f"unknown parameter '{unknown[0]}' (known: {', '.join(sorted(known))})"
            )
        return cls(**values)


def basic_first(kind: type[Parameters]) -> list[dataclasses.Field[Any]]:
    """The parameters of a set, those first that an integrator sets for a vehicle."""
    return sorted(dataclasses.fields(kind), key=lambda field: not field.metadata["basic"])


def _checked(field: dataclasses.Field[Any], value: Any) -> Value:
    """Return the value in its declared type, or raise ParameterError."""
    meta = field.metadata
    kind: type = type(field.default)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not kind:
        raise ParameterError(f"parameter '{field.name}' must be {kind.__name__}, got {value!r}")
    if meta["choices"] and value not in meta["choices"]:
        raise ParameterError(
            f"parameter '{field.name}' must be one of {', '.join(meta['choices'])}, got {value!r}"
        )
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        low = -math.inf if meta["low"] is None else meta["low"]
        high = math.inf if meta["high"] is None else meta["high"]
        if not low <= value <= high:
            raise ParameterError(
                f"parameter '{field.name}' must be within [{low}, {high}] {meta['unit']}".rstrip()
                + f", got {value!r}"
            )
    return cast(Value, value)
