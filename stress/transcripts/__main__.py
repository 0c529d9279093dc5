# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the transcripts, or reports whether every bit is the same.

python -m stress.transcripts            writes stress/transcripts/*.txt
python -m stress.transcripts --digest   prints a hash of every bit of each replay

With names of replays only those.
"""

from __future__ import annotations

from hashlib import sha256

import click

from stress.transcripts.transcript import REPLAYS, digest, transcript


@click.command()
@click.option("--digest", "only_digest", is_flag=True, help="Print hashes and write nothing.")
@click.option("--rounded", is_flag=True, help="Hashes of the transcripts, not of every bit.")
@click.argument("names", nargs=-1, type=click.Choice([one.name for one in REPLAYS]))
def main(only_digest: bool, rounded: bool, names: tuple[str, ...]) -> None:
    """Run the replays."""
    for replay in (one for one in REPLAYS if not names or one.name in names):
        run = replay.run()
        if only_digest:
            found = sha256(transcript(run).encode()).hexdigest() if rounded else digest(run)
            click.echo(f"{found} {replay.name}")
        else:
            replay.path.write_text(transcript(run), encoding="utf-8")
            click.echo(replay.path)


if __name__ == "__main__":
    main()
