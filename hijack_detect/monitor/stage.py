# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A stage: one estimator or detector behind a merge of its inputs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from hijack_detect.streams.merge import StreamMerge


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
    """A component that must not forget what it has claimed when it is made afresh."""

    def inherit(self, before: Any) -> None:
        """Take over what the component before had claimed."""


@runtime_checkable
class HearsRefused(Protocol):
    """A component that is told of samples refused because of their own input's stamps.

    Only for stamps that do not increase, or jump: that depends on the input alone, where every
    other reason depends on the order in which inputs arrive.
    """

    def refused(self, name: str, sample: Any, last: Any, before: Any) -> None:
        """Note a refused sample.

        It is told before any sample with a stamp above that of `last` is given, unless its input
        was silent for longer than its patience. What follows from it is a function of the stamps
        alone if it is said from the first sample above that stamp on.

        Args:
            name: The input.
            sample: The sample that is left out.
            last: The last sample of this input that was in order.
            before: The one before that, None if there is none.
        """


class Stage:
    """Runs a component on inputs that arrive in any order.

    A node holds one stage and feeds it messages; an offline run chains the same stages. When
    the clock of an input runs far backwards (a looped bag), the component is made afresh.
    """

    def __init__(self, make: Callable[[], Component]) -> None:
        """Make the stage's component by calling `make`."""
        self._make = make
        self.component = make()
        self._merge: StreamMerge[Any] = StreamMerge(self.component.inputs)
        self.restarts = 0
        """Times that the clock ran backwards and everything began afresh."""
        self._last: dict[str, tuple[Any, Any]] = {}
        """The last two samples of each input that were in order, the newest first."""

    @property
    def refused(self) -> Counter[str]:
        """Samples left out, by reason."""
        return self._merge.refused

    def restart(self) -> None:
        """Make the component afresh; the order of the inputs is kept."""
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
        elif isinstance(self.component, HearsRefused):
            self.component.refused(name, sample, *self._last[name])
        return self._outputs(ready)

    def push_all(self, name: str, samples: Sequence[Any]) -> list[Any]:
        """Take successive samples of an input; return the outputs that became certain, in order.

        It says what `push` says with one after the other, but for samples that come later than
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
