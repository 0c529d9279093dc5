# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is wrong with a machine is found, with what to do; a check that breaks is a finding."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
from command import hijack_detect
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.cli.common import share_folder
from hijack_detect.cli.doctor import machine, packages, ros_settings, shared_memory
from hijack_detect.cli.doctor.expectations import Received, inputs, monitors, topics_of
from hijack_detect.cli.doctor.finding import Finding, Level, findings_of

SEGMENT = "fastrtps_0123456789abcdef"
PORT = "fastrtps_port7412"


def levels(found: Iterable[Finding]) -> list[Level]:
    return [one.level for one in found]


def only(found: Iterable[Finding]) -> Finding:
    (one,) = found
    assert one.mend or one.level in (Level.OK, Level.INFO)
    return one


def put(folder: Path, *names: str, age_s: float = 60.0) -> None:
    for name in names:
        file = folder / name
        file.write_bytes(b"1234")
        os.utime(file, (time.time() - age_s,) * 2)


def test_leftovers_are_what_nobody_holds(tmp_path: Path) -> None:
    put(tmp_path, SEGMENT, f"{SEGMENT}_el", PORT, f"{PORT}_el", f"sem.{PORT}_mutex", "other")
    put(tmp_path, "fastrtps_aaaaaaaaaaaaaaaa_el", age_s=0.0)
    assert {one.name for one in shared_memory.leftovers(tmp_path)} == {SEGMENT, PORT}
    with (tmp_path / f"{SEGMENT}_el").open("ab") as held:
        fcntl.flock(held, fcntl.LOCK_SH)
        found = shared_memory.leftovers(tmp_path)
        assert [one.name for one in found] == [PORT]
        assert found[0].size == 12
        finding = next(shared_memory.memory(tmp_path))
        assert (finding.level, finding.mend) == (Level.WARN, "hijack-detect doctor --clean")
        assert shared_memory.clean(found) == 1
    left = {file.name for file in tmp_path.iterdir()}
    assert left == {SEGMENT, f"{SEGMENT}_el", "fastrtps_aaaaaaaaaaaaaaaa_el", "other"}


def test_what_is_taken_between_looking_and_cleaning_stays(tmp_path: Path) -> None:
    put(tmp_path, SEGMENT, f"{SEGMENT}_el")
    found = shared_memory.leftovers(tmp_path)
    with (tmp_path / f"{SEGMENT}_el").open("ab") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert shared_memory.clean(found) == 0
    assert (tmp_path / SEGMENT).is_file()


def test_files_of_a_killed_node_are_leftovers_and_those_of_a_living_one_are_not(
    domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_memory, "YOUNG_S", -60.0)
    if not shared_memory.FOLDER.is_dir():
        pytest.skip("there is no shared memory here")
    peer = subprocess.Popen(
        [sys.executable, "-m", "hijack_detect.cli.doctor.peer", "say", "nothing"],
        env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
    )
    try:
        deadline = time.monotonic() + 20.0
        while not (made := _mapped(peer.pid)):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        free = {one.name for one in shared_memory.leftovers()}
        assert not made & free
    finally:
        peer.send_signal(signal.SIGKILL)
        peer.wait()
    mine = [one for one in shared_memory.leftovers() if one.name in made]
    assert mine
    assert shared_memory.clean(mine) == len(mine)
    assert not any(file.exists() for one in mine for file in one.files)


def _mapped(process: int) -> set[str]:
    """Segments of Fast DDS that a process has made."""
    try:
        maps = Path(f"/proc/{process}/maps").read_text()
    except OSError:
        return set()
    words = {Path(line.split()[-1]).name for line in maps.splitlines() if "/fastrtps_" in line}
    return {word for word in words if (shared_memory.FOLDER / f"{word}_el").is_file()}


@pytest.mark.parametrize(
    ("given_id", "level", "said"),
    [
        ("", Level.OK, "0 (not set)"),
        ("42", Level.OK, "42"),
        ("101", Level.OK, "101"),
        ("102", Level.WARN, "are among those that Linux gives away (32768 to 60999)"),
        ("233", Level.FAIL, "beyond 232"),
        ("-1", Level.FAIL, "is no number"),
        ("²", Level.FAIL, "is no number"),
        ("x", Level.FAIL, "is no number"),
    ],
)
def test_the_domain(given_id: str, level: Level, said: str, tmp_path: Path) -> None:
    one = only(ros_settings.domain({"ROS_DOMAIN_ID": given_id}, tmp_path / "none"))
    assert one.level is level
    assert said in one.text


@given(st.text(max_size=12))
def test_any_domain_is_a_finding(text: str) -> None:
    assert only(ros_settings.domain({"ROS_DOMAIN_ID": text})).what == "ROS_DOMAIN_ID"


@pytest.mark.parametrize(
    ("environment", "level", "said"),
    [
        ({}, Level.OK, "SUBNET"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, Level.OK, "LOCALHOST"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, Level.FAIL, "no node discovers another"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "local"}, Level.FAIL, "is 'local'"),
        ({"ROS_LOCALHOST_ONLY": "1"}, Level.WARN, "deprecated"),
        (
            {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
            Level.WARN,
            "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET is ignored",
        ),
    ],
)
def test_discovery(environment: dict[str, str], level: Level, said: str) -> None:
    one = only(ros_settings.discovery(environment))
    assert one.level is level
    assert said in one.text


def test_profiles_and_middleware(tmp_path: Path) -> None:
    assert list(ros_settings.profiles({})) == []
    missing = {"FASTRTPS_DEFAULT_PROFILES_FILE": str(tmp_path / "none.xml")}
    assert only(ros_settings.profiles(missing)).level is Level.WARN
    assert only(ros_settings.middleware(os.environ)).level is Level.OK
    other = only(ros_settings.middleware({"RMW_IMPLEMENTATION": "rmw_nobody_cpp"}))
    assert (other.level, "librmw_nobody_cpp.so" in other.text) == (Level.FAIL, True)


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"ROS_DISTRO": "humble"}, "ROS_DISTRO is humble, needed is jazzy"),
        ({"AMENT_PREFIX_PATH": "/opt/ros/iron:/x"}, "another distribution: /opt/ros/iron"),
    ],
)
def test_another_ros_fails(environment: dict[str, str], said: str) -> None:
    one = only(packages.installation(environment))
    assert (one.level, said in one.text) == (Level.FAIL, True)


def test_two_installations_fail(tmp_path: Path) -> None:
    (tmp_path / "rclpy").mkdir()
    one = only(packages.installation({"PYTHONPATH": str(tmp_path)}))
    assert one.level is Level.FAIL
    assert str(tmp_path) in one.text
    assert only(packages.installation({})).text == "jazzy, from wheels"


def test_shared_files_and_their_version(tmp_path: Path) -> None:
    good = list(packages.share(share_folder(), sys.prefix))
    assert levels(good) == [Level.OK, Level.OK]
    unknown, empty = packages.share(tmp_path, "")
    assert (unknown.level, unknown.mend) == (
        Level.WARN,
        f"export AMENT_PREFIX_PATH={sys.prefix}",
    )
    assert "has no config, launch, bags" in empty.text
    for name in packages.FOLDERS:
        (tmp_path / name).mkdir()
        (tmp_path / name / "one").touch()
    (tmp_path / "package.xml").write_text("<package><version>0.0.9</version></package>")
    old = list(packages.share(tmp_path, sys.prefix))[-1]
    assert (old.level, "is of version 0.0.9, the code of" in old.text) == (Level.FAIL, True)


def test_requirements_are_those_of_the_installed_package() -> None:
    always, extras = packages.requirements()
    assert {"numpy", "click"} <= {one.name for one in always}
    assert {one.name for one in extras["logs"]} == {"pyulog", "pymavlink"}
    found = list(packages.dependencies())
    assert found[0].level is Level.OK


def test_a_missing_extra_and_a_missing_requirement_are_named() -> None:
    """In a process in which two distributions cannot be found."""
    program = (
        "import importlib.metadata as found\n"
        "version = found.version\n"
        "def gone(name):\n"
        "    if name in ('pyulog', 'lz4'):\n"
        "        raise found.PackageNotFoundError(name)\n"
        "    return '0.1' if name == 'rich' else version(name)\n"
        "found.version = gone\n"
        "from hijack_detect.cli.doctor.packages import dependencies\n"
        "for one in dependencies(): print(one.level.name, one.what, one.text, one.mend, sep='|')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    assert "FAIL|dependency|lz4>=4: is not installed|pip install 'lz4>=4'" in lines
    assert "FAIL|dependency|rich>=13: 0.1 is installed|pip install 'rich>=13'" in lines
    assert any(one.startswith("INFO|extra logs|not installed: pyulog") for one in lines)


def test_the_machine(tmp_path: Path) -> None:
    assert levels(machine.clock())
    assert only(machine.disk(tmp_path / "not/yet/there")).level is Level.OK
    (tmp_path / "file").touch()
    assert only(machine.disk(tmp_path / "file/below")).level is Level.WARN
    (tmp_path / "rmem").write_text("4096\n")
    assert "rmem_max is 4096" in only(machine.sockets(tmp_path / "rmem")).text
    assert list(machine.sockets()) == [] or machine.BUFFER.read_text()
    for cpu in ("cpu0", "cpu1"):
        folder = tmp_path / cpu / "cpufreq"
        folder.mkdir(parents=True)
        (folder / "scaling_governor").write_text("powersave\n")
        (folder / "scaling_driver").write_text("acpi-cpufreq\n")
    assert list(machine.processors(tmp_path))[-1].text.startswith("2 run at their lowest")


def test_a_check_that_breaks_is_a_finding() -> None:
    def broken() -> Iterator[Finding]:
        yield Finding("one", Level.OK, "good")
        raise RuntimeError("no such thing")

    good, bad = findings_of("a check", broken)
    assert good.level is Level.OK
    assert (bad.what, bad.level) == ("a check", Level.WARN)
    assert bad.text == "the check broke: RuntimeError: no such thing"


IMU, FIX = "sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix"


def test_inputs_that_are_elsewhere_are_pointed_at() -> None:
    topics = topics_of("", mavros=False)
    others = {"/uav1/mavros/imu/data_raw": [IMU], "/uav1/gps/fix": [FIX]}
    found = {one.what: one for one in inputs(topics, {}, others)}
    assert found["/imu/data_raw"].level is Level.FAIL
    assert "launch with uav:=uav1 mavros:=true;" in found["/imu/data_raw"].mend
    assert found["/imu/data_raw"].mend.endswith("doctor --namespace /uav1 --mavros")
    assert "launch with uav:=uav1;" in found["/gps/fix"].mend
    assert found["/mag"].level is Level.INFO
    assert topics_of("uav1/", mavros=True)["fix"] == "/uav1/mavros/global_position/raw/fix"


def test_inputs_that_are_not_as_they_should_be() -> None:
    topics = {"imu": "/imu/data_raw", "fix": "/gps/fix"}

    def said(imu: Received, fix: Received) -> tuple[Finding, Finding]:
        one, other = inputs(topics, {"imu": imu, "fix": fix}, {})
        return one, other

    good = Received(["/a"], [IMU], 200.0)
    assert levels(said(good, Received(["/b"], [FIX], 5.0))) == [Level.OK, Level.OK]
    assert levels(said(good, Received())) == [Level.OK, Level.FAIL]
    assert levels(said(Received(), Received())) == [Level.WARN, Level.WARN]
    slow, wrong = said(Received(["/a"], [IMU], 20.0), Received(["/b"], [IMU]))
    assert (slow.level, slow.text) == (Level.WARN, "only 20.0 Hz")
    assert (wrong.level, "needed is sensor_msgs/msg/NavSatFix" in wrong.text) == (Level.FAIL, True)
    silent, two = said(Received(["/a"], [IMU]), Received(["/b", "/c"], [FIX], 10.0))
    assert (silent.level, two.level) == (Level.FAIL, Level.WARN)


def test_monitors_and_their_time() -> None:
    assert levels(monitors([], [], clock=False)) == [Level.INFO]
    assert levels(monitors(["/fusion"], ["/fusion"], clock=True)) == [Level.OK]
    assert levels(monitors(["/fusion"], ["/fusion"], clock=False)) == [Level.OK, Level.FAIL]
    assert levels(monitors(["/a/fusion", "/b"], [], clock=False)) == [Level.WARN]


def test_the_command_without_dds_is_quick_and_has_json(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "999")
    done = hijack_detect("doctor", "--no-dds", "--json")
    rows = json.loads(done.stdout)
    assert done.returncode == 1
    assert [one["what"] for one in rows if one["level"] == "fail"] == ["ROS_DOMAIN_ID"]
    assert all(set(one) == {"what", "level", "text", "mend"} for one in rows)
    monkeypatch.setenv("ROS_DOMAIN_ID", "9")
    done = hijack_detect("doctor", "--no-dds")
    assert (done.returncode, done.stderr) == (0, "")
    assert "OK   ROS_DOMAIN_ID: 9" in done.stdout
