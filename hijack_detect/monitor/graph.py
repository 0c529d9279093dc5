# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor as one object: the same stages that the nodes run, wired as their topics are."""

from __future__ import annotations

import dataclasses
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

from hijack_detect.detectors.fusion_decisions import FusionParameters
from hijack_detect.monitor.parts import PARTS, Part, weights
from hijack_detect.monitor.stage import Component, Stage
from hijack_detect.parameters import Parameters
from hijack_detect.streams.receiver_clock import ReceiverClock

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


class Monitor:
    """Feeds samples through attitude, course, detectors and fusion.

    Inputs are `imu`, `fix`, `velocity`, `satellites`, `mag` and `pressure`; what each part puts
    out goes to the parts that have an input of that name. Everything that was put out by one
    `push` is returned.

    Attributes:
        detectors: Names of the parts that give verdicts.
        clock: Puts the receiver's stamps on the clock of the IMU before any part has them.
    """

    def __init__(self, parameters: MonitorParameters) -> None:
        """Make all stages.

        Raises:
            ParameterError: See `weights`.
        """
        self.detectors = parameters.detectors
        self.clock = ReceiverClock()
        self.stages: Mapping[str, Stage] = {
            part.name: Stage(partial(component_of, part, parameters[part.name]))
            for part in parameters.parts
        }
        self._hearers: dict[str, list[tuple[str, Stage]]] = defaultdict(list)
        for name, stage in self.stages.items():
            for source in stage.component.inputs:
                self._hearers[source].append((name, stage))

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


def component_of(part: Part, parameters: Parameters) -> Component:
    """Make the estimator, detector or fusion of a row.

    Raises:
        ParameterError: See `weights`.
    """
    heard = (weights(parameters),) if isinstance(parameters, FusionParameters) else ()
    component: Component = part.kind(parameters, *heard)
    return component


def input_names(part: Part) -> tuple[str, ...]:
    """Names of the inputs of a row's estimator, detector or fusion, with its default parameters."""
    return tuple(component_of(part, part.parameters()).inputs)
