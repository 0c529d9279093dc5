# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs the live page: its node in this thread, its server in another."""

from __future__ import annotations

import signal
import sys
import webbrowser
from collections.abc import Sequence

import click
import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from hijack_detect.cli.processes import interrupt_held
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.live.picture import Picture
from hijack_detect.live.server import Server
from hijack_detect.monitor.parts import weights
from hijack_detect.nodes.live_viewer import LiveViewer
from hijack_detect.nodes.running import NOT_BUILT_IN, SPIN_S, end_soon, is_asked_for, unprotected


def run_live(
    host: str, port: int, namespace: str, further: Sequence[str], *, mavros: bool, opens: bool
) -> None:
    """Serve until Ctrl-C.

    Args:
        host: Address to serve at.
        port: Port, 0 for any that is free.
        namespace: Namespace of the vehicle.
        further: Detectors beside those of this package, by name.
        mavros: Whether fixes come from the topic of mavros.
        opens: Whether to open the page in the browser.

    Raises:
        ValueError: The address cannot be served, a namespace or detector has no name that a topic
            can have, or DDS security was asked for and is not built in.
        RuntimeError: The server has ended by itself.
    """
    picture = Picture(tuple(weights(FusionParameters(further_detectors=" ".join(further)))))
    server = Server(picture, host, port)
    # ROS would end the node in the middle of a callback; Ctrl-C and SIGTERM wait for the loop.
    rclpy.init(args=None, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = _listener(picture, namespace, mavros=mavros)
        executor = EventsExecutor()
        executor.add_node(node)
        server.start()
        _announce(server, node)
        if opens and not webbrowser.open(server.url):
            click.echo("no browser could be opened here", err=True)
        ended: list[int] = []
        signal.signal(signal.SIGTERM, lambda number, _: ended.append(number))
        try:
            with interrupt_held() as pressed:
                while not pressed and not ended and server.alive:
                    executor.spin_once(timeout_sec=SPIN_S)
        except KeyboardInterrupt:
            pass
        if not server.alive:
            raise RuntimeError("the server of the page has ended by itself")
    finally:
        server.stop()
        end_soon()
        rclpy.try_shutdown()
        signal.alarm(0)


def _listener(picture: Picture, namespace: str, *, mavros: bool) -> LiveViewer:
    try:
        return LiveViewer(picture, namespace=namespace, mavros=mavros)
    except NameValidationException as error:
        raise ValueError(f"--namespace {namespace}: {' '.join(str(error).split())}") from error
    except RuntimeError as error:
        if is_asked_for() and "security libraries" in str(error):
            raise ValueError(NOT_BUILT_IN) from error
        raise


def _announce(server: Server, node: LiveViewer) -> None:
    """Print where the page is, and which machines can see it."""
    if why := unprotected(sys.argv):
        click.echo(f"error: {why}", err=True)
    if not server.local:
        click.echo(
            "warning: anyone who reaches this address sees the vehicle's position and the "
            "monitor's verdicts without a login. Without --host only this machine can; from "
            "another one use ssh -L 8765:127.0.0.1:8765 VEHICLE",
            err=True,
        )
    fix = node.resolve_topic_name(node.fix_topic)
    space = node.get_namespace().rstrip("/")
    click.echo(f"subscribes to {space}/*/verdict, {space}/hijack_alert and {fix}; Ctrl-C ends it")
    click.echo(server.url)
