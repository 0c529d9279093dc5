# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Gives one parser random bytes, led by what they reach (Atheris, libFuzzer)."""

from __future__ import annotations

import mmap
import sys
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["hijack_detect", "rosbags", "yaml"]):
    from stress.fuzz.targets import COUNTS, TARGETS


def main(name: str, folder: Path, options: list[str]) -> None:
    """Try until an option of libFuzzer ends it, or something is found."""
    target = TARGETS[name]
    work, corpus = folder / "work", folder / "corpus"
    for one in (work, corpus):
        one.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(target.seeds(work)):
        (corpus / f"seed{number}").write_bytes(seed)
    attempt = target.make(work)
    with (folder / "counts").open("w+b") as file:
        file.write(bytes(COUNTS.size))
        file.flush()
        counts = mmap.mmap(file.fileno(), COUNTS.size)

        def one_input(data: bytes) -> None:
            tried, accepted = COUNTS.unpack_from(counts)
            COUNTS.pack_into(counts, 0, tried + 1, accepted)
            if attempt(data):
                COUNTS.pack_into(counts, 0, tried + 1, accepted + 1)

        atheris.Setup([sys.argv[0], *options, str(corpus)], one_input)
        atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
