# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor: inputs in order of stamp, the stage of each part, and all stages connected.

Topics arrive in any order relative to each other. A stage releases a sample once every input that
is alive has passed its stamp, so the released order, and with it every decision, depends on stamps
alone and not on when a message happened to arrive.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.monitor.parts import Part, weights
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.parameters import Parameters
from hijack_detect.streams.receiver_clock import ReceiverClock
from hijack_detect.streams.samples import NANOSECONDS
from hijack_detect.streams.silence import RESTART_S, SILENCE_S, SKEW_S

CLOCKS = ("imu", "attitude")
"""Inputs that show when the clock behind all stamps was set back: they have the stamps of the
IMU, which no attacker of the receiver can reach."""
SET_BACK_S = 0.1
"""The stamps of CLOCKS never run back so far for another reason. Chosen, not swept."""


class Stamped(Protocol):
    """Anything with a header stamp in nanoseconds."""

    @property
    def stamp_ns(self) -> int:
        """Header stamp, nanoseconds."""


S = TypeVar("S", bound=Stamped)


@dataclass
class _Input:
    index: int
    patience_ns: int
    restart_ns: int
    latest_ns: int | None = None
    doubted_ns: int | None = None
    """A stamp that did not follow on the one before; the next one shows which was right."""
    joins_at_ns: int | None = None
    silent_until_ns: int = 0
    """No sample will come with a stamp up to this one."""


class StreamMerge(Generic[S]):
    """Orders the samples of named inputs by stamp; ties go in the order of the names.

    An input that stays silent is waited for as long as its patience, on the stamps of the
    others, and then no longer. Provided that no input is delivered later than that, the output
    is a function of the stamps alone; a larger patience costs time only while an input is silent.

    A stamp that does not increase is refused and counted. One that leaves a gap, or runs far
    backwards, is left out until the next sample of its input follows on it, so that a single
    broken stamp changes nothing. After a gap the input joins again one second later, after a
    jump backwards (a looped bag, a clock that was set) everything restarts, and
    `restarted` is true for that call; with one of CLOCKS a small jump is enough.
    """

    def __init__(self, patience_s: Mapping[str, float]) -> None:
        """Make a merge of inputs, given how long to wait for each, in seconds."""
        self._silence_ns = round(SILENCE_S * NANOSECONDS)
        self._skew_ns = round(SKEW_S * NANOSECONDS)
        self.refused: Counter[str] = Counter()
        """Samples left out, by reason."""
        self.out_of_order = False
        """True when the last `push` left its sample out for the stamps of its own input."""
        self.restarted = False
        """True when the last `push` began a new recording."""
        self.set_patience(patience_s)
        self._begin()

    def set_patience(self, patience_s: Mapping[str, float]) -> None:
        """Change how long to wait for each input from the next recording on, in seconds."""
        self._patience_ns = {name: round(s * NANOSECONDS) for name, s in patience_s.items()}

    def _begin(self) -> None:
        self._inputs = {
            name: _Input(
                index, patience, round((SET_BACK_S if name in CLOCKS else RESTART_S) * NANOSECONDS)
            )
            for index, (name, patience) in enumerate(self._patience_ns.items())
        }
        self._waiting: list[tuple[int, int, str, S]] = []
        self._first_ns: int | None = None
        self._newest_ns = 0
        self._released_ns: int | None = None
        self._slowest: _Input | None = None
        """The input that holds the others up; None where that has to be found out."""
        self._certain_ns = self._waited_until_ns = 0

    def push(self, name: str, sample: S) -> list[tuple[str, S]]:
        """Take one sample; return the samples that became certain, in order of stamp."""
        self.restarted = self.out_of_order = False
        stamp = sample.stamp_ns
        if not self._follows(name, stamp):
            return []
        source = self._inputs[name]
        if source.latest_ns is None:
            self._begin_input(source, stamp)
        source.latest_ns = stamp
        self._newest_ns = max(self._newest_ns, stamp)
        if self._released_ns is not None and stamp <= self._released_ns:
            self.refused[f"{name}: arrived too late"] += 1
        elif source.joins_at_ns is not None and stamp < source.joins_at_ns:
            self.refused[f"{name}: rejoining after an outage"] += 1
        else:
            heapq.heappush(self._waiting, (stamp, source.index, name, sample))
        return self._released(self._certain_until(source, stamp))

    def push_run(self, name: str, samples: Sequence[S]) -> tuple[int, list[tuple[str, S]]]:
        """Take samples of one input that follow on it and on each other, for the price of one.

        Returns:
            How many of the first samples were taken, and what became certain. The next one, if
            any is left, must be given to `push`, which knows what to do with its stamp.
        """
        self.restarted = self.out_of_order = False
        source = self._inputs[name]
        latest_ns, doubted = source.latest_ns, source.doubted_ns is not None
        if latest_ns is None or doubted:
            return 0, []
        taken, earliest_ns = 0, max(self._released_ns or 0, (source.joins_at_ns or 0) - 1)
        for sample in samples:
            stamp_ns = sample.stamp_ns
            if not 0 < stamp_ns - latest_ns <= self._silence_ns or stamp_ns <= earliest_ns:
                break
            heapq.heappush(self._waiting, (stamp_ns, source.index, name, sample))
            latest_ns = stamp_ns
            taken += 1
        if not taken:
            return 0, []
        source.latest_ns = latest_ns
        self._newest_ns = max(self._newest_ns, latest_ns)
        return taken, self._released(self._certain_until(source, latest_ns))

    def advance(self, name: str, stamp_ns: int) -> list[tuple[str, S]]:
        """Take it that no sample of an input will come with a stamp up to this one.

        Who makes the samples may know, long before the next one is there. That changes neither
        what is released nor the order, only how early.
        """
        self.restarted = self.out_of_order = False
        source = self._inputs[name]
        if source.latest_ns is None or stamp_ns <= source.silent_until_ns:
            return []
        source.silent_until_ns = stamp_ns
        if source is not self._slowest:
            return []
        return self._released(self._certain_until(source, stamp_ns))

    @property
    def certain_ns(self) -> int:
        """Stamp up to which everything has been released; 0 before the first sample."""
        return self._certain_ns

    def _released(self, certain_ns: int) -> list[tuple[str, S]]:
        released: list[tuple[str, S]] = []
        while self._waiting and self._waiting[0][0] <= certain_ns:
            self._released_ns, _, name, sample = heapq.heappop(self._waiting)
            released.append((name, sample))
        return released

    def _follows(self, name: str, stamp: int) -> bool:
        """Whether the stamp follows on those before it, of this or of a new recording."""
        source = self._inputs[name]
        latest, doubted = source.latest_ns, source.doubted_ns
        if latest is None or 0 < stamp - latest <= self._silence_ns:
            source.doubted_ns = None
            return True
        if 0 <= latest - stamp <= source.restart_ns:
            self._refuse(name, "stamp does not increase")
            return False
        if doubted is None or not 0 < stamp - doubted <= self._silence_ns:
            source.doubted_ns = stamp
            self._refuse(name, "stamp jumps")
            return False
        if stamp < latest:
            self._begin()
            self.restarted = True
        else:
            source.doubted_ns = None
            source.joins_at_ns = stamp + self._skew_ns
        return True

    def _refuse(self, name: str, reason: str) -> None:
        self.refused[f"{name}: {reason}"] += 1
        self.out_of_order = True

    def _begin_input(self, source: _Input, stamp: int) -> None:
        """Take note of the first stamp of an input."""
        if self._first_ns is None:
            self._first_ns = self._newest_ns = stamp
        self._slowest = None
        self._first_ns = min(self._first_ns, stamp)
        if stamp - self._first_ns > self._silence_ns:
            source.joins_at_ns = stamp + self._skew_ns

    def _certain_until(self, source: _Input, stamp: int) -> int:
        """Newest stamp that every input which is still waited for has passed.

        It moves on only with the slowest input, or when that has been waited for long enough; and
        back, with one that had been given up.
        """
        slowest = self._slowest
        known = slowest is not None and slowest is not source and stamp >= self._certain_ns
        if not known or self._newest_ns > self._waited_until_ns:
            self._find_slowest()
        return self._certain_ns

    def _find_slowest(self) -> None:
        """Look at every input; none is the slowest if the newest stamp is certain."""
        assert self._first_ns is not None
        self._certain_ns, self._slowest = self._newest_ns, None
        for source in self._inputs.values():
            latest = source.latest_ns
            since, passed = self._first_ns, self._first_ns - 1
            if latest is not None:
                since, passed = latest, max(latest, source.silent_until_ns)
            if self._newest_ns - since > source.patience_ns:
                continue
            if source.joins_at_ns is not None:  # nothing of it is let in before
                passed = max(passed, source.joins_at_ns - 1)
            if passed < self._certain_ns:
                self._certain_ns, self._slowest = passed, source
                self._waited_until_ns = since + source.patience_ns


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


OnError = Callable[[str, str, Sequence[Any], Exception], None]


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
        self._subscribers: dict[str, list[tuple[str, Stage]]] = defaultdict(list)
        self._passed_ns = dict.fromkeys(self.stages, 0)
        for name, stage in self.stages.items():
            for source in stage.component.inputs:
                self._subscribers[source].append((name, stage))

    def push(self, name: str, samples: Sequence[Any]) -> list[tuple[str, Any]]:
        """Take successive samples of one input; return (part, output) of all that followed.

        What a part puts out is in order. Many samples at a time cost less than one by one, and
        lead to the same outputs.
        """
        return self._run(self.clock.push_run(name, samples))

    def note_time(self, stamp_ns: int) -> list[tuple[str, Any]]:
        """Take the stamp of an IMU sample that no part has as an input; return as `push`."""
        passed = self.clock.note_reference(stamp_ns)
        return self._run((name, [sample]) for name, sample in passed)

    def _run(self, runs: Iterable[tuple[str, Sequence[Any]]]) -> list[tuple[str, Any]]:
        outputs: list[tuple[str, Any]] = []
        waiting: deque[tuple[str, Sequence[Any], int | None]] = deque(
            (name, samples, None) for name, samples in runs
        )
        while waiting:
            source, samples, passed_ns = waiting.popleft()
            for part, stage in self._subscribers.get(source, ()):
                found = self._outputs(part, stage, source, samples, passed_ns)
                outputs += [(part, output) for output in found]
                own_ns = stage.passed_ns
                if part in self._subscribers and (found or own_ns > self._passed_ns[part]):
                    self._passed_ns[part] = own_ns
                    waiting.append((part, found, own_ns))
        return outputs

    def _outputs(
        self, part: str, stage: Stage, source: str, samples: Sequence[Any], passed_ns: int | None
    ) -> list[Any]:
        """What a part makes of samples of an input that brings nothing more up to a stamp."""
        found: list[Any] = []
        try:
            if samples:
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
