# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Replays a recorded flight, and injects spoofing attacks into it.

Publishes every topic of an mcap bag whose type is installed, with the recorded header stamps or,
with `restamp`, moved to now; /clock for nodes with use_sim_time; spoof_active (Bool, latched) with
every fix: whether an attack covers it; ~/position (Float64, seconds from the bag's first message),
~/finished (Bool, latched) and /diagnostics. Services ~/pause, ~/resume and ~/step
(std_srvs/Trigger); ~/step publishes one message. Parameters: bag (required), scenario, preset
(auto, default, mavros), rate, start_s, duration_s, loop, restamp, clock_hz, start_paused,
settle_s, wait_for, progress, exit_at_end. The rate can be changed while it plays.

Nothing is dropped: a reliable subscriber that keeps all (history KEEP_ALL) slows the replay down
to its own pace. Ends with exit code 0 at the bag's end, with 2 when the bag turns out damaged.
"""

from __future__ import annotations

import sys
import time

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.messages import message_class, time_message
from hijack_detect.nodes.parameters import current, declare, own_changes
from hijack_detect.nodes.qos import STATE
from hijack_detect.nodes.running import EXIT_BAD_INPUT, run
from hijack_detect.parameters import ParameterError
from hijack_detect.replay.playback import TRUTH_TOPIC, Outgoing, Playback, ReplayParameters
from hijack_detect.replay.player import Player, State, Tick


class ProgressBar:
    """Draws on stderr; does nothing if that is no terminal."""

    def __init__(self, total: float, unit: str, *, wanted: bool = True) -> None:
        """Start a bar that is full at `total`."""
        self._bar: Progress | None = None
        if wanted and sys.stderr.isatty():
            self._bar = Progress(
                BarColumn(),
                TextColumn(f"{{task.completed:.1f}} of {{task.total:.1f}} {unit}"),
                TextColumn("{task.description}"),
                console=Console(stderr=True),
                auto_refresh=False,
            )
            self._task = self._bar.add_task("", total=total)
            self._bar.start()

    def show(self, done: float, text: str) -> None:
        """Draw it."""
        if self._bar is not None:
            self._bar.update(self._task, completed=done, description=text)
            self._bar.refresh()

    def stop(self) -> None:
        """Leave the terminal as it was."""
        if self._bar is not None:
            self._bar.stop()


LOSSLESS = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
"""Publishing waits for slow reliable subscribers instead of overwriting what they did not get."""
BATCH_S = 0.02
"""Longest time spent publishing before services and signals are served. Chosen, not swept."""
MIN_WAIT_S, MAX_WAIT_S = 0.001, 0.05
LATE_S = 1.0
"""A replay this much behind reports that it cannot keep up. Chosen, not swept."""
LAST_WORDS_S = 4.0
"""Longest time to wait at the end until the last messages are acknowledged; Fast DDS asks for
that every 3 s."""


class BagReplay(Node):
    """Publishes what is due by its `Player`."""

    def __init__(self) -> None:
        """Open the bag and advertise.

        Raises:
            ValueError: A parameter, the bag or the scenario is refused.
        """
        super().__init__("bag_replay", automatically_declare_parameters_from_overrides=True)
        self.exit_code = 0
        self._settings = declare(self, ReplayParameters, read_only=False)
        self._playback = Playback(self._settings, message_class)
        self._player = Player(self._playback, self._settings)
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._apply_change)
        self._truth = self.create_publisher(Bool, TRUTH_TOPIC, STATE)
        self._outputs = {
            route.topic: self._truth
            if route.topic == TRUTH_TOPIC
            else self.create_publisher(route.kind, route.topic, LOSSLESS)
            for route in self._playback.routes.published.values()
        }
        self._clock_output = self.create_publisher(ClockMessage, "/clock", 10)
        self._position = self.create_publisher(Float64, "~/position", 10)
        self._finished = self.create_publisher(Bool, "~/finished", STATE)
        self._finished.publish(Bool(data=False))
        self._diagnostics = Diagnostics(self)
        self.create_service(Trigger, "~/pause", self._pause)
        self.create_service(Trigger, "~/resume", self._resume)
        self.create_service(Trigger, "~/step", self._step)
        length_s = self._player.end_s - self._settings.start_s
        self._bar = ProgressBar(length_s, "s", wanted=self._settings.progress)
        self._told: set[tuple[str, str]] = set()
        self._late_told = False
        self._graph: object = None
        self._graph_since = self._ended_at = time.monotonic()
        self._introduce()
        wall = Clock(clock_type=ClockType.STEADY_TIME)  # use_sim_time would wait for itself
        self._timer = self.create_timer(MIN_WAIT_S, self._advance, clock=wall)
        self.create_timer(0.1, self._show_position, clock=wall)
        self.create_timer(1.0, self._report, clock=wall)

    def destroy_node(self) -> None:
        """Close the bag and the progress bar too."""
        self._bar.stop()
        self._playback.close()
        super().destroy_node()

    def _introduce(self) -> None:
        """Log what is replayed and what is not."""
        log, reader, chosen = self.get_logger(), self._playback.reader, self._playback.routes
        names = ", ".join(
            topic if topic.lstrip("/") == route.topic else f"{topic} as {route.topic}"
            for topic, route in chosen.published.items()
        )
        scenario = self._settings.scenario
        attack = f"with the attacks of {scenario}" if scenario else "without attacks"
        log.info(f"{reader.path}: {reader.duration_s:.1f} s, {attack}; publishes {names}")
        for topic, reason in chosen.skipped.items():
            log.info(f"{reader.path}: topic {topic} is left out: {reason}")

    def _advance(self) -> None:
        """Publish what is due, and come back when the next is."""
        player = self._player
        if player.state is State.WAITING and self._settled():
            player.play()
        until = time.monotonic() + BATCH_S
        sent = True
        while sent and (event := player.due()) is not None and time.monotonic() < until:
            sent = self._publish(event)
            if sent:
                player.advance(event)
        self._tell_rejected()
        if player.state is State.ENDED:
            self._end()
            return
        if player.behind_s > LATE_S and not self._late_told:
            self._late_told = True
            self.get_logger().warning(
                f"{player.behind_s:.1f} s late at {player.where()}: rate {self._settings.rate:g} "
                "is more than this machine or a subscriber can follow; nothing is dropped"
            )
        wait_s = min(max(player.wait_s(), MIN_WAIT_S), MAX_WAIT_S) if sent else MIN_WAIT_S
        self._wake_after(wait_s)

    def _publish(self, event: Tick | Outgoing) -> bool:
        """Publish one event; false if a subscriber is too slow, or the process is ending."""
        try:
            if isinstance(event, Tick):
                self._clock_output.publish(ClockMessage(clock=time_message(event.ns)))
                return True
            if event.spoofed is not None:
                self._truth.publish(Bool(data=event.spoofed))
            self._outputs[event.topic].publish(event.data)
        except rclpy_implementation.RCLError:
            return False
        return True

    def _wake_after(self, seconds: float) -> None:
        self._timer.timer_period_ns = round(seconds * 1e9)
        self._timer.reset()

    def _settled(self) -> bool:
        """Whether every awaited node is there and subscriptions have stopped changing."""
        present = self.get_node_names_and_namespaces()
        names = {name for name, _ in present} | {f"{ns.rstrip('/')}/{name}" for name, ns in present}
        missing = set(self._settings.wait_for.split()) - names
        graph = [output.get_subscription_count() for output in self._outputs.values()]
        now = time.monotonic()
        if missing or graph != self._graph:
            self._graph, self._graph_since = graph, now
        if missing:
            self.get_logger().info(
                f"waits for {', '.join(sorted(missing))}",
                throttle_duration_sec=5.0,
                skip_first=True,
            )
        return not missing and now - self._graph_since >= self._settings.settle_s

    def _end(self) -> None:
        """Report that the replay is over; then leave, once everything has arrived."""
        if not self._timer.is_canceled():
            self._timer.cancel()
            self._ended_at = time.monotonic()
            self._finished.publish(Bool(data=True))
            self._show_position()
            self._report()
            if self._player.error:
                self.exit_code = EXIT_BAD_INPUT
                self.get_logger().error(f"{self._player.error}; the replay ends here")
            else:
                total = sum(self._player.published.values())
                self.get_logger().info(f"{self._player.where()}, {total} messages published")
            if self._settings.exit_at_end:
                steady = Clock(clock_type=ClockType.STEADY_TIME)
                self.create_timer(0.01, self._leave, clock=steady)

    def _leave(self) -> None:
        outputs: list[Publisher] = [*self._outputs.values(), self._truth, self._finished]
        arrived = all(output.wait_for_all_acked(Duration(nanoseconds=0)) for output in outputs)
        if arrived or time.monotonic() - self._ended_at > LAST_WORDS_S:
            self.context.try_shutdown()

    def _pause(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._player.pause()
        return self._answer(response, State.PAUSED)

    def _resume(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._player.play()
        if self._player.state is State.PLAYING:
            self._wake_after(MIN_WAIT_S)
        return self._answer(response, State.PLAYING)

    def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        stepped = self._player.step()
        self._advance()
        response.success = bool(stepped)
        response.message = f"{stepped or 'not paused, no step'}; {self._player.where()}"
        return response

    def _answer(self, response: Trigger.Response, wanted: State) -> Trigger.Response:
        response.success = self._player.state is wanted
        response.message = self._player.where()
        return response

    def _check_change(self, changes: list[Parameter]) -> SetParametersResult:
        own = own_changes(ReplayParameters, changes)
        fixed = sorted(set(own) - {"rate"})
        if fixed:
            reason = f"parameter '{fixed[0]}' cannot change while the bag plays, only 'rate' can"
            return SetParametersResult(successful=False, reason=reason)
        try:
            current(self, ReplayParameters, own)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply_change(self, changes: list[Parameter]) -> None:
        for change in changes:
            if change.name == "rate":
                self._settings = current(self, ReplayParameters, {"rate": change.value})
                self._player.set_rate(self._settings.rate)
                self._late_told = False
                self.get_logger().info(f"rate {self._settings.rate:g}: {self._player.where()}")

    def _tell_rejected(self) -> None:
        """Log the first refused message of each kind."""
        rejected = self._playback.rejected
        for key in rejected.first.keys() - self._told:
            self.get_logger().warning(f"{rejected.first[key]} (told once, counted further)")
            self._told.add(key)

    def _show_position(self) -> None:
        self._position.publish(Float64(data=self._player.position_s))
        done_s = self._player.position_s - self._settings.start_s
        self._bar.show(done_s, self._player.state.value)

    def _report(self) -> None:
        """Publish on /diagnostics what was published and left out, once a second."""
        player = self._player
        level = DiagnosticStatus.OK
        if self._playback.rejected.total or player.behind_s > LATE_S:
            level = DiagnosticStatus.WARN
        if player.error:
            level = DiagnosticStatus.ERROR
        self._diagnostics.report("replay", level, player.error or player.where(), player.report())


def main() -> None:
    """Run the node; ends the process with its exit code."""
    made: list[BagReplay] = []

    def make() -> BagReplay:
        made.append(BagReplay())
        return made[0]

    run(make, __doc__ or "")
    sys.exit(made[0].exit_code if made else 0)


if __name__ == "__main__":
    main()
