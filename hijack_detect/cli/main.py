# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect`."""

from __future__ import annotations

import importlib
import platform
from typing import Any

import click
from click.shell_completion import CompletionItem

from hijack_detect import __version__
from hijack_detect.cli.common import BadInput, add_own_prefix

EXTRAS = {
    **dict.fromkeys(("matplotlib", "plotly", "scipy"), "analysis"),
    **dict.fromkeys(("pymavlink", "pyulog"), "logs"),
    "tornado": "live",
}
"""Libraries that only some commands import, and the extra that has them."""


COMMANDS = {
    "analyze": ("analyze", "Judge whether the GPS of a recorded flight was spoofed"),
    "completion": ("completion", "Print the script that completes this command in a shell"),
    "convert": ("convert", "Make a bag of a log of PX4, ArduPilot, ROS, or of a CSV"),
    "demo": ("demonstrate", "Replay a flight, spoof its GPS, and show the alert"),
    "doctor": ("doctor.command", "Check whether the monitor can run here, and what to mend"),
    "evaluate": ("evaluate", "Run every method on many flights, and count"),
    "inject": ("inject", "Make a spoofed copy of a bag"),
    "journal": ("journal", "Show and export what the recorder has kept"),
    "live": ("live", "Show a running monitor in a browser"),
    "params": ("params", "Print a parameter file, the manual of its parameters"),
    "simulate": ("simulate", "Make a bag of a simulated flight"),
    "sweep": ("sweep", "Vary one thing and see how many flights are judged correctly"),
    "tune": ("tune", "Choose thresholds for one vehicle from its flights"),
}
"""Module of each command, and its line in the list of commands: only one is loaded."""


class Commands(click.Group):
    """The commands; names what to install where one needs an optional library."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command.

        Raises:
            BadInput: A library of an extra is missing.
        """
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as error:
            library = (error.name or "").split(".")[0]
            if library not in EXTRAS:
                raise
            extra = EXTRAS[library]
            raise BadInput(
                f"this needs {library}, which is not installed; it comes with the extra "
                f"'{extra}': pip install '.[{extra}]'"
            ) from error

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load a command, None if there is none of that name."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"hijack_detect.cli.{COMMANDS[cmd_name][0]}")
        found = getattr(module, cmd_name)
        assert isinstance(found, click.Command)
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in the help."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in self.list_commands(ctx)])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Offer the commands, without loading them."""
        names = [name for name in self.list_commands(ctx) if name.startswith(incomplete)]
        found = [CompletionItem(name, help=COMMANDS[name][1]) for name in names]
        return [*found, *click.Command.shell_complete(self, ctx, incomplete)]


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(
    __version__,
    prog_name="hijack-detect",
    message=f"%(prog)s, version %(version)s (Python {platform.python_version()})",
)
def main() -> None:
    """Detect GPS spoofing of a drone."""
    add_own_prefix()


if __name__ == "__main__":
    main()
