"""A stage: one estimator or detector behind a merge of its inputs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
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
        outputs = (self.component.update(source, one) for source, one in ready)
        return [output for output in outputs if output is not None]
