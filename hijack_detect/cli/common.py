# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Shared by the commands: refusal of input, search of scenarios, progress bars."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import place

if TYPE_CHECKING:
    from hijack_detect.spoofing.scenario import Scenario

VARIABLE = "AMENT_PREFIX_PATH"


def add_own_prefix() -> None:
    """Put this Python's prefix on AMENT_PREFIX_PATH if it is an ament prefix.

    The wheels do not set the variable, and without it the ament index knows nothing.
    """
    known = [path for path in os.environ.get(VARIABLE, "").split(os.pathsep) if path]
    index = Path(sys.prefix, "share/ament_index/resource_index/packages")
    if index.is_dir() and sys.prefix not in known:
        os.environ[VARIABLE] = os.pathsep.join([sys.prefix, *known])


EXIT_BAD_INPUT = 2
PATH = click.Path(path_type=Path)


class BadInput(click.ClickException):
    """Input that cannot be used: one line on stderr and exit code 2."""

    exit_code = EXIT_BAD_INPUT


class Place(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.5
    """A path, or a URL of any file system that fsspec knows."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """See click.ParamType."""
        try:
            return value if isinstance(value, Path) else place(value)
        except BagError as error:
            raise BadInput(str(error)) from error


PLACE = Place()


@contextlib.contextmanager
def refusing_bad_input() -> Iterator[None]:
    """Turn every ValueError, which names what is wrong with the input, into BadInput."""
    try:
        yield
    except ValueError as error:
        raise BadInput(str(error)) from error


def find_scenario(given: str, onset_s: float | None = None) -> Scenario:
    """Read a scenario file, given by its path or by the bare name of one in config/scenarios.

    Args:
        given: Path or name.
        onset_s: Moves the first attack to this second, if given.

    Raises:
        ScenarioError: It cannot be used.
    """
    from hijack_detect.spoofing.scenario import load_scenario  # noqa: PLC0415  slow to load

    own = share_folder() / "config/scenarios" / f"{given}.yaml"
    scenario = load_scenario(own if own.is_file() else Path(given))
    return scenario if onset_s is None else scenario.moved_to(onset_s)


def pool_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the place where many flights run, passed to the command as `pool`."""

    @click.option("--jobs", type=click.IntRange(1), help="Processes [one per core].")
    @click.option("--scheduler", default="", help="Run on the Dask cluster at this address.")
    @click.option(
        "--results",
        type=PATH,
        help="Keep results as Parquet in this folder, and go on from what is there.",
    )
    @functools.wraps(command)
    def with_pool(
        *given: Any, jobs: int | None, scheduler: str, results: Path | None, **named: Any
    ) -> None:
        from hijack_detect.evaluation.trials.parallel import Pool  # noqa: PLC0415  slow to load

        if scheduler and jobs is not None:
            raise click.UsageError("give --jobs or --scheduler, not both")
        cores = len(os.sched_getaffinity(0))
        command(*given, pool=Pool(jobs or cores, scheduler, results), **named)

    return with_pool


def make_folder(path: Path) -> None:
    """Make a folder to write into, if it is not there.

    Raises:
        BadInput: It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{path}: cannot be made: {error.strerror}") from error


def share_folder() -> Path:
    """Folder of the installed configuration, launch files and bags."""
    try:
        from ament_index_python.packages import (  # noqa: PLC0415  there may be no ROS
            get_package_share_directory,
        )

        return Path(get_package_share_directory("hijack_detect"))
    except (ImportError, LookupError):
        return Path(sys.prefix, "share/hijack_detect")


@contextlib.contextmanager
def progress(text: str, total: float) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr while something long runs, if that is a terminal.

    Yields:
        Takes how much of the total is done.
    """
    from rich.console import Console  # noqa: PLC0415  slow to load
    from rich.progress import (  # noqa: PLC0415
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    with Progress(
        TextColumn(text),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=not sys.stderr.isatty(),
    ) as bar:
        task = bar.add_task("", total=total)
        yield lambda done: bar.update(task, completed=done)
