# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect live`."""

from __future__ import annotations

import click

from hijack_detect.cli.common import BadInput


@click.command()
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to serve at.")
@click.option("--port", type=click.IntRange(0, 65535), default=8765, show_default=True)
@click.option("--namespace", default="", help="Namespace of the vehicle, such as uav1.")
@click.option("--mavros", is_flag=True, help="Take the fixes from the topic of mavros.")
@click.option(
    "--detector",
    "further",
    multiple=True,
    metavar="NAME",
    help="Show a detector of your own too. Can be given again.",
)
@click.option("--open", "opens", is_flag=True, help="Open the page in the browser.")
def live(
    host: str, port: int, namespace: str, mavros: bool, further: tuple[str, ...], opens: bool
) -> None:
    """Show a running monitor on a web page: alert, track and margins, ten times a second.

    The page needs no network but this server. It only reads: nothing on it reaches the vehicle.
    --port 0 takes any port that is free. Ctrl-C ends it.
    """
    from hijack_detect.cli.live_run import run_live  # noqa: PLC0415  needs ROS and tornado

    try:
        run_live(host, port, namespace, further, mavros=mavros, opens=opens)
    except ValueError as error:
        raise BadInput(str(error)) from error
