# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A spoofed copy of a bag, with the truth beside it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from hijack_detect.bags.encoding import encode_bool
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.samples import Rejected, Rejection
from hijack_detect.bags.topics import TYPES
from hijack_detect.bags.writer import BagWriter
from hijack_detect.replay.playback import MessageSpoofer, is_answer
from hijack_detect.replay.truth import (
    LABEL,
    MEASURED_FIX,
    SPOOF_ACTIVE,
    attack_label,
    known_attack,
    read_label,
)
from hijack_detect.spoofing.on_messages import SPOOFED_INPUTS
from hijack_detect.spoofing.scenario import Scenario


@dataclass
class Injection:
    """Counts of an injection.

    Attributes:
        messages: Number of messages.
        spoofed: Number of fixes that an attack covers.
        left_out: Topics that are not in the copy, with the reason. The ground truth of the
            original is replaced.
        refused: Messages with values that no receiver can mean; they are as they were.
    """

    messages: int = 0
    spoofed: int = 0
    left_out: dict[str, str] = field(default_factory=dict)
    refused: Rejected = field(default_factory=Rejected)


def inject(
    reader: BagReader,
    out: Path,
    scenario: Scenario,
    *,
    preset: str = "auto",
    on_message: Callable[[int], None] | None = None,
) -> Injection:
    """Copy a bag with the attacks of a scenario on its GPS.

    All other messages are copied byte for byte. The copy has two more topics: /spoof_active, with
    each fix, whether it is spoofed; /truth/measured_fix, the fixes as they were. A label.json
    beside the bag holds the same for an evaluation.

    Args:
        reader: The bag.
        out: The bag directory to make; it must not exist.
        scenario: The attacks.
        preset: Topic names, see `bags.topics`.
        on_message: Called with the log time of each message, for progress.

    Raises:
        BagError: The bag cannot be read, holds an attack already, or `out` cannot be written.
        ScenarioError: A segment lies outside the flight.
    """
    scenario.check_within(reader.duration_s)
    if known_attack(reader).attack is not None:
        raise BagError(f"{reader.path}: holds an attack already; inject into a flight without one")
    names = {topic: name for name, topic in reader.inputs(preset).items()}
    done = Injection()

    def refuse(raw: RawMessage, stamp_ns: int, reason: str) -> None:
        done.refused.add(Rejection(reader.path, raw.topic, raw.log_ns, stamp_ns, reason))

    spoofer = MessageSpoofer(scenario, reader.start_ns, refuse)
    with BagWriter(out) as writer:
        kept = _kept(reader, writer, done)
        for raw in reader.messages(kept):
            if on_message is not None:
                on_message(raw.log_ns)
            name = names.get(raw.topic, "")
            data = raw.data
            if name in SPOOFED_INPUTS:
                data, active = spoofer.apply(raw, name, _message(reader, raw, name))
                if name == "fix":
                    done.spoofed += active
                    if MEASURED_FIX not in kept:
                        writer.write_raw(MEASURED_FIX, raw.msgtype, raw.log_ns, raw.data)
                    msgtype, flag = encode_bool(active)
                    writer.write_raw(SPOOF_ACTIVE, msgtype, raw.log_ns, flag)
            writer.write_raw(raw.topic, raw.msgtype, raw.log_ns, data)
            done.messages += 1
    _write_label(reader, out, scenario)
    return done


def _kept(reader: BagReader, writer: BagWriter, done: Injection) -> set[str]:
    """The topics to copy; makes their types known to the writer and notes the others."""
    kept = set()
    for topic, msgtype in reader.topics.items():
        if topic == SPOOF_ACTIVE:
            continue
        if is_answer(topic):
            done.left_out[topic] = "it is what the monitor said of the original"
            continue
        try:
            writer.define(msgtype, reader.definition(topic))
        except BagError:
            done.left_out[topic] = f"its type {msgtype!r} is not known, nor defined in the bag"
            continue
        kept.add(topic)
    return kept


def _message(reader: BagReader, raw: RawMessage, name: str) -> object:
    if raw.msgtype != TYPES[name]:
        raise BagError(
            f"{reader.path}: topic {raw.topic} at log time {raw.log_ns} ns has type "
            f"{raw.msgtype}, the input '{name}' needs {TYPES[name]}; name another topic"
        )
    return reader.deserialize(raw)


def _write_label(reader: BagReader, out: Path, scenario: Scenario) -> None:
    """Write the label of the copy: that of the original, with the attack."""
    last = scenario.segments[-1]
    end_s = reader.duration_s if last.end_s is None else last.end_s
    label = {
        **(read_label(reader.path) or {"route": "recorded", "duration": reader.duration_s}),
        "id": out.name,
        "kind": "hijack",
        "attack": attack_label(scenario, end_s),
    }
    text = json.dumps(label, indent=1, ensure_ascii=False)
    (out / LABEL).write_text(text + "\n", encoding="utf-8")
