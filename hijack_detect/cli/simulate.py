# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `simulate`: a bag of a flight that is flown by its GPS, honest or spoofed."""

from __future__ import annotations

from pathlib import Path

import click

from hijack_detect.bags.topics import OPTIONAL_INPUTS
from hijack_detect.cli.common import PATH, find_scenario, refusing_bad_input
from hijack_detect.cli.completion import ROUTES, scenarios


@click.command()
@click.argument("out", type=PATH)
@click.option("--route", type=click.Choice(ROUTES), default="curved", show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--duration", type=float, default=110.0, show_default=True, help="Seconds.")
@click.option("--speed", type=float, default=None, help="m/s on the route [drawn, 6 to 9].")
@click.option("--height", type=float, default=20.0, show_default=True, help="Metres.")
@click.option("--wind", type=float, default=None, help="Mean wind, m/s [drawn, 0 to 5].")
@click.option(
    "--attack",
    default=None,
    shell_complete=scenarios,
    help="Scenario file, or the name of one of config/scenarios, as 'carry_off'.",
)
@click.option("--onset", type=float, default=None, help="Move the attack to this second.")
@click.option("--without", type=click.Choice(OPTIONAL_INPUTS), multiple=True, help="Leave out.")
def simulate(
    out: Path,
    route: str,
    seed: int,
    duration: float,
    speed: float | None,
    height: float,
    wind: float | None,
    attack: str | None,
    onset: float | None,
    without: tuple[str, ...],
) -> None:
    """Make a bag of a simulated flight; the same options make the same bag.

    The autopilot flies by the GPS that it receives: an attack really drags the vehicle away. Beside
    the bag lies label.json with what was flown and attacked.
    """
    from hijack_detect.replay.simulated_bag import make_bag  # noqa: PLC0415  slow to load
    from hijack_detect.simulation.plan import FlightPlan  # noqa: PLC0415

    with refusing_bad_input():
        plan = FlightPlan(
            route=route, duration_s=duration, speed=speed, height_m=height, wind_m_s=wind
        )
        scenario = None if attack is None else find_scenario(attack, onset)
        if attack is None and onset is not None:
            raise ValueError("--onset moves an attack, and there is none: give --attack")
        label = make_bag(out, plan, seed, scenario=scenario, without=without)
    click.echo(
        f"{out}: {duration:g} s, route {route}, {label['speed_m_s']:.1f} m/s, "
        f"wind {label['wind']['spd']:.1f} m/s, seed {seed}"
    )
    if scenario is not None:
        away = label["attack"]["max_deviation_m"]
        click.echo(
            f"Attacked from {scenario.segments[0].start_s:g} s: up to {away:.0f} m off its route."
        )
