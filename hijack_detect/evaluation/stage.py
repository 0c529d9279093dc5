"""A stage: one estimator or detector behind a merge of its inputs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from hijack_detect.streams.merge import StreamMerge


class Component(Protocol):
    """An estimator, detector or fusion: takes samples in order of stamp."""

    @property
    def inputs(self) -> Sequence[str]:
        """Names of its inputs; samples with equal stamps come in this order."""

    def update(self, name: str, sample: Any) -> Any:
        """Take the next sample; return an output, or None."""


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
        self.component = self._make()

    def push(self, name: str, sample: Any) -> list[Any]:
        """Take one sample of an input; return the outputs that became certain, in order."""
        ready = self._merge.push(name, sample)
        if self._merge.restarted:
            self.component = self._make()
            self.restarts += 1
        outputs = (self.component.update(source, one) for source, one in ready)
        return [output for output in outputs if output is not None]
