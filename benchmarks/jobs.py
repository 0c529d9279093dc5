# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Jobs that are measured, each in a separate process.

    python benchmarks/jobs.py NAME BAG

Prints processor seconds (without the time to import), largest resident memory and the count.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import click
from rosbags.highlevel import AnyReader

from hijack_detect.analysis.analyse import analyse
from hijack_detect.analysis.report.page import write_page
from hijack_detect.analysis.report.recording import Recorder, recording
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.monitor.policies import policy_parameters


def iterate(bag: Path) -> int:
    """Read the messages and do nothing with them."""
    with BagReader(bag) as reader:
        return sum(1 for _ in reader.messages())


def rosbags(bag: Path) -> int:
    """Let rosbags read and deserialise them one by one."""
    with AnyReader([bag]) as reader:
        return sum(
            reader.deserialize(raw, connection.msgtype) is not None
            for connection, _, raw in reader.messages()
        )


def decode(bag: Path) -> int:
    """Make samples of them."""
    with BagReader(bag) as reader:
        return sum(1 for _ in read_samples(reader, reader.inputs(), on_rejected=Rejected().add))


def detect(bag: Path) -> int:
    """Run all detectors: all that `analyze` does but for the report."""
    outputs: Counter[str] = Counter()
    with BagReader(bag) as reader:
        analyse(
            reader, policy_parameters("default"), on_output=lambda part, _: outputs.update([part])
        )
    return outputs["fusion"]


def report(bag: Path) -> int:
    """Do what `analyze --report` does."""
    recorder = Recorder()
    with BagReader(bag) as reader, TemporaryDirectory() as folder:
        parameters = policy_parameters("default")
        done = analyse(reader, parameters, on_sample=recorder.take, on_output=recorder.take_output)
        recorded = recording(reader, recorder, injected=False)
        return write_page(Path(folder), done, recorded).stat().st_size


JOBS: dict[str, Callable[[Path], int]] = {
    job.__name__: job for job in (iterate, rosbags, decode, detect, report)
}


def peak_mb() -> float:
    """Largest resident memory. The figure of getrusage would include the parent's before exec."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024


@click.command()
@click.argument("name", type=click.Choice(list(JOBS)))
@click.argument("bag", type=click.Path(exists=True, path_type=Path))
def main(name: str, bag: Path) -> None:
    """Do one job with a bag."""
    begin = time.process_time()
    count = JOBS[name](bag)
    cpu_s = time.process_time() - begin
    click.echo(json.dumps({"cpu_s": cpu_s, "peak_mb": peak_mb(), "count": count}))


if __name__ == "__main__":
    main()
