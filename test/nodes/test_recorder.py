# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node recorder: what it leaves on disk, and what it says of it."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from command import hijack_detect
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from feed import START_NS, fix
from live import SECOND, replay, start_monitor, values_of
from rclpy.qos import qos_profile_sensor_data
from recorded_node import STAMPED, TOPICS, Recorded
from ros import KEEP_ALL, ROOT, Graph
from std_msgs.msg import String

from hijack_detect.bags.reader import BagReader
from hijack_detect.nodes import COMPOSED
from hijack_detect.nodes.qos import STATE
from hijack_detect.nodes.running import EXIT_BAD_INPUT

KILLS = 3
CURVED = ROOT / "bags/curved_8"


@pytest.mark.parametrize("space", ["", "/drone1"])
def test_an_alert_leaves_a_bag_of_before_and_after(
    graph: Graph, tmp_path: Path, space: str
) -> None:
    arguments = ("-r", f"__ns:={space}") if space else ()
    flown = Recorded(graph, tmp_path / "kept", *arguments, space=space)
    flown.fly(10.0)
    flown.fly(0.2, alert=True)
    alert = flown.stamp_ns
    (part,) = flown.until_paths(1)
    assert part.name.endswith("Z.part1")
    flown.fly(2.0, alert=True)
    flown.until_rows("fixes", 61)
    flown.fly(2.2, alert=True)
    *_, whole = flown.until_paths(2)
    assert whole.parent == tmp_path / "kept/snapshots"
    assert part.name.startswith(whole.name)
    with BagReader(whole) as reader:
        assert (reader.start_ns, reader.end_ns) == (alert - 5 * SECOND, alert + 2 * SECOND)
        counted = {topic: reader.message_counts[f"{space}/{topic}"] for topic in TOPICS}
        # With headers exactly both ends; those without stand where they arrived.
        assert {topic: counted[topic] for topic in STAMPED} == {
            topic: 35 * TOPICS[topic] + 1 for topic in STAMPED
        }
        assert set(reader.topics) == {f"{space}/{topic}" for topic in TOPICS}
        assert reader.inputs().fix == f"{space}/gps/fix"
    done = hijack_detect("analyze", whole)
    assert done.returncode in (0, 3, 10), done.stderr
    assert flown.node.interrupt() == 0
    assert not part.exists()
    assert flown.select("SELECT alert, causes FROM alerts") == [(0, ""), (1, "date")]
    assert flown.select("SELECT path, complete FROM snapshots") == [(f"snapshots/{whole.name}", 1)]
    assert flown.select("SELECT count(*), count(DISTINCT stamp_ns) FROM fixes") == [(72, 72)]
    assert flown.select("SELECT node, ended_ns > started_ns FROM sessions") == [
        (f"{space}/recorder", 1)
    ]
    assert [kind for (kind,) in flown.select("SELECT kind FROM events")] == ["start", "stop"]


def test_ctrl_c_finishes_snapshot_and_journal(graph: Graph, tmp_path: Path) -> None:
    flown = Recorded(graph, tmp_path)
    flown.fly(3.0)
    flown.fly(1.0, alert=True)
    flown.until_paths(1)
    flown.until_rows("fixes", 20)
    assert flown.node.interrupt() == 0
    ((path, complete, until_ns),) = flown.select("SELECT path, complete, until_ns FROM snapshots")
    assert (complete, until_ns) == (1, flown.stamp_ns)
    assert (tmp_path / path / "metadata.yaml").is_file()
    assert "Traceback" not in flown.node.output


def test_a_folder_that_cannot_be_used_is_reported_and_ends_nothing(
    graph: Graph, tmp_path: Path
) -> None:
    # Below a file nothing can be made, which stops root, too; permission bits would not.
    (tmp_path / "file").touch()
    flown = Recorded(graph, tmp_path / "file/kept")
    status = flown.until_level(DiagnosticStatus.ERROR, "choose another 'folder'")
    assert f"{tmp_path}/file/kept" in status.message
    flown.fly(3.0, alert=True)
    (tmp_path / "file").unlink()
    flown.until_level(DiagnosticStatus.OK)
    flown.until_paths(1)
    flown.until_rows("fixes", 15)
    assert values_of(flown.until_level(DiagnosticStatus.OK))["last problem"] == status.message
    assert flown.node.interrupt() == 0
    assert flown.node.output.count("choose another 'folder'") == 2
    assert flown.node.output.count("works again after") == 1


def test_a_ring_that_is_too_small_is_reported(graph: Graph, tmp_path: Path) -> None:
    flown = Recorded(graph, tmp_path, before_s=600.0, ring_max_mb=1)
    flown.fly(50.0)
    status = flown.until_level(DiagnosticStatus.WARN, "of the 600 s before an alert; raise")
    assert int(values_of(status)["ring bytes"]) <= 1_000_000


def test_messages_that_say_nothing_are_kept_as_bytes_and_counted(
    graph: Graph, tmp_path: Path
) -> None:
    flown = Recorded(graph, tmp_path)
    publisher = graph.node.create_publisher(DiagnosticArray, "date/verdict", KEEP_ALL)
    graph.spin_until(publisher.get_subscription_count, "the recorder")
    flown.fly(1.0)
    empty = DiagnosticArray()
    empty.header.stamp.sec = START_NS // SECOND + 1
    publisher.publish(empty)
    flown.until_rows("verdicts", 5)

    def refused() -> bool:
        one = flown.status()
        return one is not None and values_of(one).get("left out /date/verdict") == "1"

    graph.spin_until(refused, "the count of messages left out")
    assert flown.node.output.count("a verdict has one status, this has 0") == 1
    assert flown.node.interrupt() == 0


def test_inputs_are_heard_from_best_effort_publishers(graph: Graph, tmp_path: Path) -> None:
    flown = Recorded(graph, tmp_path, reliable=False)
    publisher = graph.node.create_publisher(type(fix(0)), "gps/fix", qos_profile_sensor_data)

    def heard() -> bool:
        publisher.publish(fix(START_NS))
        return flown.select("SELECT count(*) FROM fixes") > [(0,)]

    graph.spin_until(heard, "a fix")


def test_parameters_out_of_bounds_end_it_and_others_cannot_change(
    graph: Graph, tmp_path: Path
) -> None:
    small = graph.start("recorder", parameters={"folder": tmp_path, "journal_max_mb": 1})
    misspelt = graph.start("recorder", parameters={"folders": tmp_path})
    assert small.wait() == misspelt.wait() == EXIT_BAD_INPUT
    assert "error: recorder: parameter 'journal_max_mb' must be within [8, 1000000] MB" in (
        small.output
    )
    assert "error: recorder: unknown parameter 'folders' (known: after_s" in misspelt.output


@pytest.mark.slow
def test_kills_while_alerts_come_in_leave_whole_files(graph: Graph, tmp_path: Path) -> None:
    flown = Recorded(graph, tmp_path)
    for number in range(KILLS):
        (made,) = flown.select("SELECT count(*) FROM snapshots")[0] if number else (0,)
        for _ in range(number):
            flown.fly(5.0)
            flown.fly(0.4, alert=True)
            made += 1
            flown.until_rows("snapshots", made)
        flown.fly(3.0)
        flown.fly(0.4, alert=True)  # and whatever is being done for this one
        flown.node.signal(signal.SIGKILL)
        assert flown.node.wait() == -signal.SIGKILL
        assert flown.select("PRAGMA integrity_check") == [("ok",)]
        rows = flown.select("SELECT path, messages FROM snapshots WHERE NOT removed")
        for path, messages in rows:
            with BagReader(tmp_path / path) as reader:
                assert sum(1 for _ in reader.messages()) == messages
        names = {path.split("/")[1].split(".part")[0] for path, _ in rows}
        assert {Path(one.data).name.split(".part")[0] for one in flown.paths.messages} <= names
        flown.start_again()
    assert flown.node.interrupt() == 0
    ended = [one is not None for (one,) in flown.select("SELECT ended_ns FROM sessions")]
    assert ended.count(False) == KILLS
    assert ended[-1]


@pytest.mark.slow
def test_a_replay_at_any_rate_gives_the_same_seconds(graph: Graph, tmp_path: Path) -> None:
    paths = graph.listen(String, "recorder/snapshot", STATE)
    lossless = ("--params-file", str(ROOT / "config/replay.yaml"))
    recorder = graph.start("recorder", *lossless, parameters={"folder": tmp_path})
    start_monitor(graph, "default", [COMPOSED])
    scenario = ROOT / "config/scenarios/turn_away_track.yaml"
    nodes = ("fusion", "monitor", "recorder")
    replay(graph, CURVED, 120.0, nodes, rate=6.0, scenario=scenario)
    # Only the newest path is kept for who hears of it late.
    graph.spin_until(
        lambda: paths.messages and ".part" not in paths.messages[-1].data, "the whole snapshot"
    )
    assert recorder.interrupt() == 0
    whole = Path(paths.messages[-1].data)
    with BagReader(whole) as reader:
        assert reader.duration_s == pytest.approx(90.0, abs=0.5)
        assert reader.message_counts["/spoof_active"] > 200
        assert reader.message_counts["/imu/data_raw"] == pytest.approx(90 * 100, abs=50)
    done = hijack_detect("analyze", whole)
    assert done.returncode == 10, done.stdout + done.stderr
