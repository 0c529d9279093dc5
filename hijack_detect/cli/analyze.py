# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect analyze`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hijack_detect.cli.common import PATH, PLACE, BadInput, find_scenario, progress
from hijack_detect.cli.completion import NO_ATTACK, POLICY_NAMES, scenarios
from hijack_detect.cli.convert import COLUMNS, read_columns, sensor_options
from hijack_detect.streams.samples import NANOSECONDS

if TYPE_CHECKING:
    from hijack_detect.analysis.analyse import Analysed
    from hijack_detect.analysis.analysis import Analysis
    from hijack_detect.bags.reader import BagReader
    from hijack_detect.logs.logged import Notes
    from hijack_detect.monitor.policies import MonitorParameters
    from hijack_detect.spoofing.scenario import Scenario

EXIT_ALERT = 10
EXIT_NOT_JUDGED = 3
STDOUT = Path("-")


@click.command()
@click.argument("bag", type=PLACE)
@click.option(
    "--scenario",
    shell_complete=scenarios,
    metavar="NAME|FILE",
    default=NO_ATTACK,
    help="Attack to inject: a name of config/scenarios, or a file.",
)
@click.option("--onset", type=float, default=None, help="Move the attack to this second.")
@click.option("--policy", type=click.Choice(POLICY_NAMES), default="default", show_default=True)
@click.option("--params", type=PATH, help="Parameter file to use in place of the policy.")
@click.option("--json", "json_file", type=PATH, help="Write the analysis as JSON; - for stdout.")
@click.option("--report", type=PATH, metavar="DIR", help="Write a page with figures into DIR.")
@click.option(
    "--detector",
    "detectors",
    multiple=True,
    metavar="FILE.py:CLASS",
    help="Run a detector of your own too; the fusion subscribes to it. Can be given again.",
)
@COLUMNS
@sensor_options
def analyze(
    bag: Path,
    scenario: str,
    onset: float | None,
    policy: str,
    params: Path | None,
    json_file: Path | None,
    report: Path | None,
    detectors: tuple[str, ...],
    columns: Path | None,
    imu: int,
    gps: int,
    namespace: str,
) -> None:
    """Judge whether the GPS of a recorded flight was spoofed, when, and on what evidence.

    BAG is an mcap file, a rosbag2 folder, or a log that `convert` knows (--imu, --gps, --columns
    and --namespace are for those). What is known of an attack is compared with: the scenario's,
    the ground truth's in the bag, or that of label.json beside it. The JSON is described by
    docs/analysis.schema.json.

    Exits with 0 if there was no alert, with 10 if there was one, with 3 if there was none and
    nothing could have seen a carry-off (the first sentence names the cause), and with 2 if the
    input cannot be used.
    """
    from hijack_detect.cli.analyze_view import summary  # noqa: PLC0415  slow to load
    from hijack_detect.logs.formats import opened  # noqa: PLC0415
    from hijack_detect.logs.logged import Selection  # noqa: PLC0415

    if onset is not None and scenario == NO_ATTACK:
        raise click.UsageError("--onset moves an attack, and there is none: give --scenario")
    try:
        attack = None if scenario == NO_ATTACK else find_scenario(scenario, onset)
        if report is not None:
            report.mkdir(parents=True, exist_ok=True)
        parameters = _parameters(policy, params, detectors)
        wanted = Selection(imu, gps, namespace)
        with opened(bag, wanted, read_columns(columns)) as (reader, converted):
            if converted is not None and json_file is not None:  # else the summary has them
                for line in converted.notes.lines():
                    click.echo(line, err=True)
            notes = None if converted is None else converted.notes
            done = _analysed(reader, attack, parameters, notes, report)
        text = done.analysis.model_dump_json(indent=2)
        if json_file is not None and json_file != STDOUT:
            json_file.write_text(text + "\n", encoding="utf-8")
    except ValueError as error:
        raise BadInput(str(error)) from error
    except OSError as error:
        raise BadInput(f"{error.filename}: {error.strerror}") from error
    for line in done.flight.rejected.lines():
        click.echo(line, err=True)
    for component in done.flight.absence.names:
        click.echo(f"the {component} is not measured: it is not used", err=True)
    if json_file == STDOUT:
        click.echo(text.encode())
    elif json_file is None:
        summary(done.analysis)
    sys.exit(exit_code(done.analysis))


def exit_code(analysis: Analysis) -> int:
    """The exit code of what was found."""
    if analysis.alerts:
        return EXIT_ALERT
    return 0 if analysis.not_judged is None else EXIT_NOT_JUDGED


def _parameters(policy: str, params: Path | None, detectors: Sequence[str]) -> MonitorParameters:
    """Parameters of the monitor, with the user's own detectors in it."""
    from hijack_detect.cli.parameter_files import load_parameters  # noqa: PLC0415  slow to load
    from hijack_detect.cli.user_detectors import load_detectors  # noqa: PLC0415
    from hijack_detect.monitor.policies import policy_parameters  # noqa: PLC0415

    own = load_detectors(detectors)
    if params is not None:
        return load_parameters(params, own)
    return policy_parameters(policy, own)


def _analysed(
    reader: BagReader,
    attack: Scenario | None,
    parameters: MonitorParameters,
    notes: Notes | None,
    report: Path | None,
) -> Analysed:
    """Run the analysis, and write the report if one is wanted."""
    from hijack_detect.analysis.analyse import analyse  # noqa: PLC0415  slow to load
    from hijack_detect.analysis.report.recording import Recorder, recording  # noqa: PLC0415
    from hijack_detect.streams.samples import FixSample, Sample  # noqa: PLC0415

    recorder = None if report is None else Recorder()
    with progress(reader.path.name, reader.duration_s) as done_s:

        def take(sample: Sample) -> None:
            if recorder is not None:
                recorder.take(sample)
            if isinstance(sample, FixSample):
                done_s((sample.stamp_ns - reader.start_ns) / NANOSECONDS)

        take_output = None if recorder is None else recorder.take_output
        done = analyse(
            reader,
            parameters,
            attack,
            imported=notes,
            on_sample=take,
            on_output=take_output,
        )
    if report is not None and recorder is not None:
        from hijack_detect.analysis.report.page import write_page  # noqa: PLC0415

        page = write_page(report, done, recording(reader, recorder, injected=bool(attack)))
        click.echo(f"report: {page}", err=True)
    return done
