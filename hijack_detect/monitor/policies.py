# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of a whole monitor, and the sets of them that have a name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from hijack_detect.detectors.fusion import Fusion
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.monitor.parts import PARTS, Part, added, own_part, weights
from hijack_detect.parameters import ParameterError, Parameters

P = TypeVar("P", bound=Parameters)


@dataclass(frozen=True)
class MonitorParameters:
    """Which parts a monitor has, and the parameters of each.

    Attributes:
        values: Parameters by name of the part. What is not given has its defaults.
        parts: The rows of the parts, those of the registry first.
    """

    values: Mapping[str, Parameters] = field(default_factory=dict)
    parts: tuple[Part, ...] = PARTS

    def __post_init__(self) -> None:
        """Fill in the defaults."""
        full = {
            part.name: self.values[part.name] if part.name in self.values else part.parameters()
            for part in self.parts
        }
        object.__setattr__(self, "values", full)

    def __getitem__(self, name: str) -> Parameters:
        """The parameters of a part, by its name."""
        return self.values[name]

    def of(self, kind: type[P]) -> P:
        """The parameters of one kind, of the first part that has such."""
        return next(one for one in self.values.values() if isinstance(one, kind))

    @property
    def fusion(self) -> FusionParameters:
        """The parameters of the fusion."""
        return self.of(FusionParameters)

    @property
    def detectors(self) -> tuple[str, ...]:
        """Names of the parts that give verdicts."""
        return tuple(part.name for part in self.parts if part.weight is not None)

    def having(self, name: str, **changes: Any) -> MonitorParameters:
        """These parameters with others of one part."""
        changed = dataclasses.replace(self.values[name], **changes)
        return dataclasses.replace(self, values={**self.values, name: changed})

    def adding(
        self, parts: Sequence[Part], values: Mapping[str, Parameters] | None = None
    ) -> MonitorParameters:
        """These with other detectors, to which the fusion does not subscribe."""
        return MonitorParameters({**self.values, **(values or {})}, (*self.parts, *parts))


POLICIES: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "default": {},
    "paper": {part.node: part.paper for part in PARTS if part.paper},
}
"""What each policy sets differently from the defaults, by node."""


def policy_parameters(
    name: str = "default", own: Sequence[Part | type[Any]] = ()
) -> MonitorParameters:
    """Parameters of a policy, and of the user's own detectors; see `from_nodes`.

    Args:
        name: The policy.
        own: Rows of the user's own detectors, or their classes; see `own_part`.

    Raises:
        ParameterError: There is no such policy, or the name of a detector cannot be used.
        AttributeError: See `own_part`.
        TypeError: See `own_part`.
    """
    if name not in POLICIES:
        raise ParameterError(f"no policy '{name}' (there are: {', '.join(POLICIES)})")
    parts = [one if isinstance(one, Part) else own_part(one) for one in own]
    return from_nodes(POLICIES[name], own=parts)


def from_nodes(
    values: Mapping[str, Mapping[str, Any]],
    beside: Mapping[str, type[Parameters]] | None = None,
    own: Sequence[Part] = (),
) -> MonitorParameters:
    """Parameters from values by node name, defaults for the rest.

    Args:
        values: Values by parameter name, by node name.
        beside: Parameter sets of the nodes beside the monitor; what is given for those is only
            checked.
        own: Rows of the user's own detectors. The fusion subscribes to them, with the weights that
            its own values give them, else with those of the rows.

    Raises:
        ParameterError: A node or parameter is unknown, or a value is refused.
    """
    parts = (*PARTS, *own)
    names = {part.node: part.name for part in parts}
    kinds = {**{part.node: part.parameters for part in parts}, **(beside or {})}
    made: dict[str, Parameters] = {}
    for node, given in values.items():
        if node not in kinds:
            raise ParameterError(f"no node '{node}' (there are: {', '.join(kinds)})")
        try:
            checked = kinds[node].from_mapping(given)
        except ParameterError as error:
            raise ParameterError(f"{node}: {error}") from error
        if node in names:
            made[names[node]] = checked
    parameters = MonitorParameters(made, parts)
    fusion = parameters.fusion
    for part in own:
        fusion = added(fusion, part)
    weights(fusion)
    return MonitorParameters({**parameters.values, Fusion.NAME: fusion}, parts)
