# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Finding of a check."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from dataclasses import dataclass


class Level(enum.Enum):
    """Severity of a finding."""

    OK = "ok"
    INFO = "info"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True)
class Finding:
    """One line.

    Attributes:
        what: What was looked at, in a word or two.
        level: How bad it is.
        text: What was found.
        mend: What to do, a command or a sentence; empty where nothing has to be done.
    """

    what: str
    level: Level
    text: str
    mend: str = ""


Check = Callable[[], Iterator[Finding]]


def findings_of(name: str, check: Check) -> Iterator[Finding]:
    """Findings of a check; if it breaks, that is one too."""
    try:
        yield from check()
    except Exception as error:
        text = f"the check broke: {type(error).__name__}: {error}"
        yield Finding(name, Level.WARN, text, "please report this line")
