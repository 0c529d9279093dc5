# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor: all parts behind their stages, offline and in flight."""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol, TypeVar, runtime_checkable

from hijack_detect.detectors.fusion_decisions import FusionParameters
from hijack_detect.monitor.parts import PARTS, Part, weights
from hijack_detect.parameters import Parameters
from hijack_detect.streams.merge import StreamMerge
from hijack_detect.streams.receiver_clock import ReceiverClock


class Component(Protocol):
    """An estimator, detector or fusion: takes samples in order of stamp."""

    @property
    def inputs(self) -> Mapping[str, float]:
        """Its inputs, and how long each is waited for when it is silent, seconds.

        Samples with equal stamps come in this order.
        """

    def update(self, name: str, sample: Any) -> Any:
        """Take the next sample; return an output, or None."""


@runtime_checkable
class Latching(Protocol):
    """A component that must not forget what it has claimed when it is made again."""

    def inherit(self, before: Any) -> None:
        """Take over what the component before had claimed."""


@runtime_checkable
class NotesRefused(Protocol):
    """A component that takes note of samples refused because of their own input's stamps.

    Only for stamps that do not increase, or jump: that depends on the input alone, where every
    other reason depends on the order in which inputs arrive.
    """

    def refused(self, name: str, sample: Any, last: Any, before: Any) -> None:
        """Note a refused sample.

        It is called before any sample with a stamp above that of `last` is given, unless its input
        was silent for longer than its patience. What follows from it is a function of the stamps
        alone if it is published from the first sample above that stamp on.

        Args:
            name: The input.
            sample: The sample that is left out.
            last: The last sample of this input that was in order.
            before: The one before that, None if there is none.
        """


class Stage:
    """Runs a component on inputs that arrive in any order.

    A node holds one stage and feeds it messages; an offline run chains the same stages. When
    the clock of an input runs far backwards (a looped bag), the component is made again.
    """

    def __init__(self, make: Callable[[], Component]) -> None:
        """Make the stage's component by calling `make`."""
        self._make = make
        self.component = make()
        self._merge: StreamMerge[Any] = StreamMerge(self.component.inputs)
        self.restarts = 0
        """Times that the clock ran backwards and everything began again."""
        self._last: dict[str, tuple[Any, Any]] = {}
        """The last two samples of each input that were in order, the newest first."""

    @property
    def refused(self) -> Counter[str]:
        """Samples left out, by reason."""
        return self._merge.refused

    def restart(self) -> None:
        """Make the component again; the order of the inputs is kept."""
        self._renew()
        self._merge.set_patience(self.component.inputs)

    def _renew(self) -> None:
        before, self.component = self.component, self._make()
        if isinstance(self.component, Latching):
            self.component.inherit(before)

    def push(self, name: str, sample: Any) -> list[Any]:
        """Take one sample of an input; return the outputs that became certain, in order."""
        ready = self._merge.push(name, sample)
        if self._merge.restarted:
            self._renew()
            self.restarts += 1
            self._last.clear()
        if not self._merge.out_of_order:
            self._in_order(name, [sample])
        elif isinstance(self.component, NotesRefused):
            self.component.refused(name, sample, *self._last[name])
        return self._outputs(ready)

    def push_all(self, name: str, samples: Sequence[Any]) -> list[Any]:
        """Take successive samples of an input; return the outputs that became certain, in order.

        It gives what `push` gives with one after the other, but for samples that come later than
        their input is waited for.
        """
        outputs: list[Any] = []
        at = 0
        while at < len(samples):
            taken, ready = self._merge.push_run(name, samples[at:])
            if taken:
                self._in_order(name, samples[at : at + taken])
                at += taken
                outputs += self._outputs(ready)
            else:
                outputs += self.push(name, samples[at])
                at += 1
        return outputs

    def advance(self, name: str, stamp_ns: int) -> list[Any]:
        """Take it that an input brings nothing up to a stamp; see `StreamMerge.advance`."""
        return self._outputs(self._merge.advance(name, stamp_ns))

    @property
    def passed_ns(self) -> int:
        """No output will have a stamp up to this one: none is older than what it follows from."""
        return self._merge.certain_ns

    def _in_order(self, name: str, samples: Sequence[Any]) -> None:
        before = samples[-2] if len(samples) > 1 else self._last.get(name, (None,))[0]
        self._last[name] = (samples[-1], before)

    def _outputs(self, ready: list[tuple[str, Any]]) -> list[Any]:
        outputs = []
        for source, one in ready:
            output = self.component.update(source, one)
            if output is not None:
                outputs.append(output)
        return outputs


P = TypeVar("P", bound=Parameters)
OnError = Callable[[str, str, Sequence[Any], Exception], None]


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
    """Feeds samples through attitude, course, detectors and fusion, offline and in flight.

    Inputs are those that no part puts out: `imu`, `fix`, `velocity`, `satellites`, `mag` and
    `pressure` for the whole monitor, for a single part whatever it subscribes to. What a part puts
    out goes to the parts that have an input of its name, with the stamp up to which nothing more
    will come of it, so that none of them waits for what will not come.

    Attributes:
        detectors: Names of the parts that give verdicts.
        stages: The stages by name of the part.
        clock: Puts the receiver's stamps on the clock of the IMU before any part has them.
        on_error: Called with part, input, samples and exception when a part raises; the others
            go on. None lets the exception through.
    """

    def __init__(
        self, parameters: MonitorParameters, stages: Mapping[str, Stage] | None = None
    ) -> None:
        """Connect the stages of all parts.

        Args:
            parameters: Which parts there are, and their parameters.
            stages: The stages by name of the part, as nodes have them; None makes them.

        Raises:
            ParameterError: See `weights`.
        """
        self.detectors = parameters.detectors
        self.stages: Mapping[str, Stage] = stages or {
            part.name: Stage(partial(component_of, part, parameters[part.name]))
            for part in parameters.parts
        }
        self.clock = ReceiverClock()
        self.on_error: OnError | None = None
        self._subscribers: dict[str, list[str]] = defaultdict(list)
        self._passed_ns: Counter[str] = Counter()
        for name, stage in self.stages.items():
            for source in stage.component.inputs:
                self._subscribers[source].append(name)

    def push(self, name: str, samples: Sequence[Any]) -> list[tuple[str, Any]]:
        """Take successive samples of one input; return (part, output) of all that followed.

        What a part puts out is in order. Many samples at a time cost less than one by one, and
        lead to the same outputs.
        """
        return self._run(self.clock.push_run(name, samples))

    def note_time(self, stamp_ns: int) -> list[tuple[str, Any]]:
        """Take the stamp of an IMU sample that no part has as an input; return as `push`."""
        passed = self.clock.note_reference(stamp_ns)
        return self._run((name, [sample]) for name, sample, _ in passed)

    def _run(self, runs: Iterable[tuple[str, Sequence[Any]]]) -> list[tuple[str, Any]]:
        outputs: list[tuple[str, Any]] = []
        waiting: deque[tuple[str, Sequence[Any], int | None]] = deque(
            (name, samples, None) for name, samples in runs
        )
        while waiting:
            source, samples, passed_ns = waiting.popleft()
            for part in self._subscribers[source]:
                found = self._outputs(part, source, samples, passed_ns)
                outputs += [(part, output) for output in found]
                own_ns = self.stages[part].passed_ns
                if part in self._subscribers and (found or own_ns > self._passed_ns[part]):
                    self._passed_ns[part] = own_ns
                    waiting.append((part, found, own_ns))
        return outputs

    def _outputs(
        self, part: str, source: str, samples: Sequence[Any], passed_ns: int | None
    ) -> list[Any]:
        """What a part makes of samples of an input that brings nothing more up to a stamp."""
        stage, found = self.stages[part], []
        try:
            found += stage.push_all(source, samples)
            if passed_ns is not None:
                found += stage.advance(source, passed_ns)
        except Exception as error:
            if self.on_error is None:
                raise
            self.on_error(part, source, samples, error)
        return found


def component_of(part: Part, parameters: Parameters) -> Component:
    """Make the estimator, detector or fusion of a row.

    Raises:
        ParameterError: See `weights`.
    """
    weighed = (weights(parameters),) if isinstance(parameters, FusionParameters) else ()
    component: Component = part.kind(parameters, *weighed)
    return component


def input_names(part: Part) -> tuple[str, ...]:
    """Names of the inputs of a row's estimator, detector or fusion, with its default parameters."""
    return tuple(component_of(part, part.parameters()).inputs)
