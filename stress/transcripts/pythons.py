# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Says whether every supported Python gives the same bits: `make pythons`.

    python stress/transcripts/pythons.py build/pythons

Makes an environment for each, with the pinned libraries but ROS, which an analysis does not
import, and compares hashes of the replays: of every bit with one version of NumPy, and of the
transcripts with the pinned versions of NumPy, which are not the same for every Python: they
multiply matrices in another order, which changes the last digit.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
VERSIONS = ("3.10", "3.11", "3.12", "3.13")
PINNED = re.compile(r"^([a-z0-9][\w.\-]*==[^\\]*)", re.MULTILINE)
ROS = "ros-jazzy-"
COMMON = "numpy==2.2.6"
"""The newest NumPy for all of them."""
Found = dict[str, str | None]
"""Hashes by version of Python; None where that is not installed."""


def pinned() -> str:
    """The locked versions of all libraries but ROS, without their hashes."""
    lines = PINNED.findall((ROOT / "requirements.txt").read_text(encoding="utf-8"))
    return "\n".join(line.strip() for line in lines if not line.startswith(ROS)) + "\n"


def environment(version: str, folder: Path) -> Path | None:
    """An interpreter with the pinned libraries; None where this Python is not installed."""
    program = shutil.which(f"python{version}")
    if program is None:
        return None
    if subprocess.run([program, "-V"], check=False, capture_output=True).returncode:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    venv, wanted = folder / version, folder / "requirements.txt"
    wanted.write_text(pinned(), encoding="utf-8")
    subprocess.run([program, "-m", "venv", venv], check=True)
    install(venv / "bin/python", "-r", str(wanted))
    return venv / "bin/python"


def install(python: Path, *what: str) -> None:
    """Install exactly this."""
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    subprocess.run([*pip, *what], check=True)


def digests(python: Path, *options: str) -> str:
    """Hashes of the replays."""
    command = [python, "-m", "stress.transcripts", "--digest", *options]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout


def printed(what: str, found: Found) -> bool:
    """Print the hashes and whether they are the same."""
    print(what)
    for version, text in found.items():
        print(f"  Python {version}:", "not installed" if text is None else text.split()[0][:16])
    same = len({text for text in found.values() if text is not None}) == 1
    print("  the same" if same else "  NOT the same")
    return same


def main(folder: Path) -> int:
    """Compare all versions that are installed; 1 if they differ."""
    pythons = {version: environment(version, folder) for version in VERSIONS}
    installed = {version: one for version, one in pythons.items() if one is not None}
    missing: Found = dict.fromkeys(pythons)
    texts = {version: digests(one, "--rounded") for version, one in installed.items()}
    for one in installed.values():
        install(one, COMMON)
    bits = {version: digests(one) for version, one in installed.items()}
    same = printed("transcripts, each with its own NumPy", missing | texts)
    return int(not (printed(f"every bit, {COMMON}", missing | bits) and same))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
