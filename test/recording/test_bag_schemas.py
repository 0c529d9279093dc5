# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is written opens in other tools: each mcap has the whole definition of every type."""

from __future__ import annotations

from pathlib import Path

import pytest
from recorded import Flown
from ros import ROOT
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

make_reader = pytest.importorskip("mcap.reader", reason="mcap is not installed").make_reader

BAGS = sorted((ROOT / "bags").glob("*/*.mcap"))
VERDICT = "diagnostic_msgs/msg/DiagnosticArray"


def decoded(path: Path) -> set[str]:
    """Decode the first messages of each topic by the file alone; give the types that it has."""
    seen: dict[str, int] = {}
    kinds = set()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            seen[channel.topic] = seen.get(channel.topic, 0) + 1
            if seen[channel.topic] > 3:
                continue
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            known = get_typestore(Stores.EMPTY)
            known.register(get_types_from_msg(schema.data.decode(), schema.name))
            known.deserialize_cdr(message.data, schema.name)
            kinds.add(schema.name)
    return kinds


@pytest.mark.parametrize("path", BAGS, ids=lambda path: path.stem)
def test_our_bags_are_complete(path: Path) -> None:
    assert {"sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix"} <= decoded(path)


def test_a_snapshot_of_the_black_box_is_complete(tmp_path: Path) -> None:
    flown = Flown(tmp_path, before_s=2, after_s=1)
    flown.fly(4)
    flown.fly(4, alert=True)
    flown.tick_until(lambda: any(".part" not in one.name for one in flown.announced))
    flown.recorder.close()
    (path,) = flown.announced[-1].glob("*.mcap")
    assert {VERDICT, "std_msgs/msg/Bool", "sensor_msgs/msg/NavSatFix"} <= decoded(path)
