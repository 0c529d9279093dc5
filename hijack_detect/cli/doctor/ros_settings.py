# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The environment variables that ROS and Fast DDS read."""

from __future__ import annotations

import ctypes.util
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from hijack_detect.cli.doctor.finding import Finding, Level

RANGES = ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT")
PORT_BASE, PORTS_OF_DOMAIN = 7400, 250
"""Standard: RTPS well-known ports, PB and DG."""
MAX_DOMAIN, SAFE_DOMAIN = 232, 101
"""Physics: the last whole domain below port 65536, and below 32768, where Linux' own ports
begin."""
PROCESSES = 54
"""On one machine in one domain, so that the ports of domain 101 end below those of Linux."""
PORT_RANGE = Path("/proc/sys/net/ipv4/ip_local_port_range")
PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")


def domain(environment: Mapping[str, str], ports: Path = PORT_RANGE) -> Iterator[Finding]:
    """Check that ROS_DOMAIN_ID is one, and has ports that nothing else takes."""
    given = environment.get("ROS_DOMAIN_ID", "")
    what = "ROS_DOMAIN_ID"
    mend = f"export {what}=0, or another number up to {SAFE_DOMAIN}, the same for all processes"
    if given and not (given.isascii() and given.isdigit()):
        yield Finding(what, Level.FAIL, f"{given!r} is no number", mend)
        return
    number = int(given or 0)
    if number > MAX_DOMAIN:
        yield Finding(what, Level.FAIL, f"{number} is beyond {MAX_DOMAIN}", mend)
        return
    first = PORT_BASE + PORTS_OF_DOMAIN * number
    last = first + 9 + 2 * PROCESSES
    low, high = map(int, ports.read_text().split()) if ports.is_file() else (32768, 60999)
    if first <= high and last >= low:
        text = f"{number}: its UDP ports {first} to {last} are among those that Linux gives away"
        yield Finding(what, Level.WARN, f"{text} ({low} to {high})", mend)
    else:
        yield Finding(what, Level.OK, f"{number}{'' if given else ' (not set)'}")


def discovery(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Check which processes this one discovers."""
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    old = environment.get("ROS_LOCALHOST_ONLY", "")
    what = "discovery"
    if reach and reach not in RANGES:
        mend = f"export ROS_AUTOMATIC_DISCOVERY_RANGE={RANGES[0]}, or {', '.join(RANGES[1:])}"
        yield Finding(what, Level.FAIL, f"ROS_AUTOMATIC_DISCOVERY_RANGE is {reach!r}", mend)
        return
    if old:
        ignored = f", and ROS_AUTOMATIC_DISCOVERY_RANGE={reach} is ignored" if reach else ""
        mend = "unset ROS_LOCALHOST_ONLY; export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"
        text = f"ROS_LOCALHOST_ONLY={old} is deprecated{ignored if old == '1' else ''}"
        yield Finding(what, Level.WARN, text, mend)
    elif reach == "OFF":
        mend = "unset ROS_AUTOMATIC_DISCOVERY_RANGE"
        yield Finding(what, Level.FAIL, "is OFF: no node discovers another", mend)
    else:
        yield Finding(what, Level.OK, reach or "SUBNET (not set)")


def profiles(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Check that the configured profiles of Fast DDS exist."""
    for variable in PROFILES:
        path = environment.get(variable, "")
        if path and Path(path).is_file():
            yield Finding("Fast DDS profiles", Level.INFO, path)
        elif path:
            text = f"{variable}={path} is not there, so all is at its default"
            yield Finding("Fast DDS profiles", Level.WARN, text, f"unset {variable}, or correct it")


def middleware(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Check that the library of the configured RMW can be found."""
    name = environment.get("RMW_IMPLEMENTATION", "") or "rmw_fastrtps_cpp"
    library = f"lib{name}.so"
    folders = [Path(one) for one in environment.get("LD_LIBRARY_PATH", "").split(":") if one]
    folders += [Path(one, "lib") for one in environment.get("AMENT_PREFIX_PATH", "").split(":")]
    wheels = list(Path(sys.prefix).glob(f"lib/python*/site-packages/**/{library}"))
    if (
        any((one / library).is_file() for one in folders)
        or wheels
        or ctypes.util.find_library(name)
    ):
        yield Finding("RMW", Level.OK, name)
    else:
        mend = "unset RMW_IMPLEMENTATION, or install it"
        yield Finding("RMW", Level.FAIL, f"{name}: there is no {library}", mend)
