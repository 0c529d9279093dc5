# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Says when DDS security was asked for and is not there (SROS2; docs/security.md)."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

NOT_BUILT_IN = (
    "ROS_SECURITY_ENABLE is true, but this Fast DDS was built without DDS security, as all wheels "
    "from PyPI are: use an installed ROS 2 Jazzy, or unset ROS_SECURITY_ENABLE to run without "
    "protection"
)


def is_asked_for(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether ROS was told to protect this process."""
    return environment.get("ROS_SECURITY_ENABLE") == "true"


def unprotected(arguments: Sequence[str], environment: Mapping[str, str] = os.environ) -> str:
    """Why this process runs without the protection that was asked for; empty if it does not.

    With any strategy but Enforce, rcl goes on without security where it finds no keys.
    """
    if not is_asked_for(environment):
        return ""
    enclave = environment.get("ROS_SECURITY_ENCLAVE_OVERRIDE") or _enclave(arguments)
    keystore = environment.get("ROS_SECURITY_KEYSTORE", "")
    keys = Path(keystore, "enclaves", enclave.strip("/"))
    if keystore and keys.is_dir():
        return ""
    return (
        f"NOT PROTECTED although ROS_SECURITY_ENABLE is true: {keys} has no keys for the enclave "
        f"{enclave}; make them with `ros2 security create_enclave`, and set "
        "ROS_SECURITY_STRATEGY=Enforce to rather not start"
    )


def _enclave(arguments: Sequence[str]) -> str:
    for flag, value in itertools.pairwise(arguments):
        if flag in ("-e", "--enclave"):
            return value
    return "/"
