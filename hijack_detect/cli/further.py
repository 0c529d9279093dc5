# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Detectors of the user's own, each a class in a file."""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from types import ModuleType

from hijack_detect.cli.common import BadInput
from hijack_detect.monitor.graph import Baselines, MonitorParameters
from hijack_detect.parameters import Parameters

GIVE = "give FILE.py:CLASS"


def load_detectors(given: Sequence[str]) -> Baselines:
    """Makers of detectors that are given as FILE.py:CLASS, by their names.

    A class has NAME, PARAMETERS (a subclass of Parameters, of which it gets the defaults), `inputs`
    and `update`, as the detectors of this package have.

    Raises:
        BadInput: There is no such file or class, or it is no detector.
    """
    found = {}
    for one in given:
        file, _, name = one.rpartition(":")
        if not file:
            raise BadInput(f"{one}: {GIVE}")
        kind = getattr(_module(Path(file)), name, None)
        if kind is None:
            raise BadInput(f"{file}: has no class {name}; {GIVE}")
        try:
            parameters, called = kind.PARAMETERS, str(kind.NAME)
            if not issubclass(parameters, Parameters):
                raise TypeError("PARAMETERS is no subclass of Parameters")
            make = partial(kind, parameters())
            detector = make()
            if not (detector.inputs and callable(detector.update)):
                raise TypeError("it has no inputs")
        except (AttributeError, TypeError, ValueError) as error:
            raise BadInput(f"{one}: is no detector: {error}") from error
        found[called] = make
    return found


def heard_too(parameters: MonitorParameters, names: Sequence[str]) -> MonitorParameters:
    """Parameters with which the fusion hears further detectors too.

    Raises:
        ParameterError: A name cannot be used.
    """
    fusion = parameters.fusion
    all_names = dict.fromkeys((*fusion.further, *names))
    heard = dataclasses.replace(fusion, further_detectors=" ".join(all_names))
    return dataclasses.replace(parameters, fusion=heard)


def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"hijack_detect_further_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise BadInput(f"{path}: is no Python file; {GIVE}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where a dataclass looks its module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise BadInput(f"{path}: cannot be loaded: {error!r}") from error
    return module
