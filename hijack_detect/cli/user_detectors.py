# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""User detectors, each a class in a file."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from hijack_detect.cli.common import BadInput
from hijack_detect.monitor.parts import Part, own_part

GIVE = "give FILE.py:CLASS"


def load_detectors(given: Sequence[str]) -> tuple[Part, ...]:
    """Rows of detectors that are given as FILE.py:CLASS; see `own_part`.

    Raises:
        BadInput: There is no such file or class, or it is no detector.
    """
    return tuple(map(_load, given))


def _load(given: str) -> Part:
    file, _, name = given.rpartition(":")
    if not file:
        raise BadInput(f"{given}: {GIVE}")
    kind = getattr(_module(Path(file)), name, None)
    if kind is None:
        raise BadInput(f"{file}: has no class {name}; {GIVE}")
    try:
        part = own_part(kind)
        detector = part.kind(part.parameters())
        if not (detector.inputs and callable(detector.update)):
            raise TypeError("it has no inputs")
    except (AttributeError, TypeError, ValueError) as error:
        raise BadInput(f"{given}: is no detector: {error}") from error
    return part


def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"hijack_detect_user_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise BadInput(f"{path}: is no Python file; {GIVE}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where a dataclass looks its module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise BadInput(f"{path}: cannot be loaded: {error!r}") from error
    return module
