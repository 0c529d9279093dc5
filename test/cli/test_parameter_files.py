# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter files made from policies and declarations, and files that are refused."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
import yaml
from ros import ROOT

from hijack_detect.cli.parameter_files import (
    OTHER_NODES,
    WIDTH,
    load_parameters,
    node_file,
    parameter_file,
)
from hijack_detect.monitor.parts import PARTS
from hijack_detect.monitor.policies import POLICIES, MonitorParameters, policy_parameters
from hijack_detect.parameters import ParameterError

CONFIG = ROOT / "config"


@pytest.mark.parametrize("policy", POLICIES)
def test_the_committed_file_is_the_generated_one(policy: str) -> None:
    committed = (CONFIG / f"{policy}.yaml").read_text(encoding="utf-8")
    assert committed == parameter_file(policy), f"run: hijack-detect params --policy {policy}"


@pytest.mark.parametrize("node", OTHER_NODES)
def test_nodes_beside_the_monitor_have_files_too(node: str, tmp_path: Path) -> None:
    file = CONFIG / f"{node}.yaml"
    assert file.read_text(encoding="utf-8") == node_file(node), (
        f"hijack-detect params --node {node}"
    )
    assert all(len(line) <= WIDTH for line in node_file(node).splitlines())
    assert load_parameters(file) == MonitorParameters()
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(f"/**/{node}:\n  ros__parameters: {{nonsense: 1}}\n")
    with pytest.raises(ParameterError, match=f"{node}: unknown parameter 'nonsense'"):
        load_parameters(wrong)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_file_gives_the_parameters_of_the_policy(policy: str) -> None:
    assert load_parameters(CONFIG / f"{policy}.yaml") == policy_parameters(policy)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_file_explains_every_parameter_within_its_width(policy: str) -> None:
    text = parameter_file(policy)
    assert all(len(line) <= WIDTH for line in text.splitlines())
    for part in PARTS:
        block = text.split(f"/**/{part.node}:")[1].split("\n\n")[0]
        for field in dataclasses.fields(part.parameters):
            assert re.search(rf"# .*\]\n +{field.name}: ", block), field.name


def test_some_values_are_enough(tmp_path: Path) -> None:
    path = tmp_path / "some.yaml"
    path.write_text("/**/date_detector:\n  ros__parameters: {threshold: 2}\n")
    assert load_parameters(path) == MonitorParameters().having("date", threshold=2.0)
    path.write_text("")
    assert load_parameters(path) == MonitorParameters()


@pytest.mark.parametrize("name", ["fusion", "/fusion", "/**/fusion", "**/fusion"])
def test_names_of_nodes_as_ros_takes_them(tmp_path: Path, name: str) -> None:
    path = tmp_path / "named.yaml"
    path.write_text(yaml.safe_dump({name: {"ros__parameters": {"policy": "any"}}}))
    assert load_parameters(path).fusion.policy == "any"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "not a ROS parameter file"),
        ("- 1", "not a ROS parameter file"),
        ("text", "not a ROS parameter file"),
        ("fusion: {}", "not a ROS parameter file.*ros__parameters"),
        ("fusion: 3", "not a ROS parameter file"),
        ("fusion: {ros__parameters: 3}", "not a ROS parameter file"),
        ("1: {ros__parameters: {}}", "not a ROS parameter file"),
        ("[" * 100_000, "not a ROS parameter file"),
        ("!!python/object/apply:os.abort []", "not a ROS parameter file"),
        (
            "fusion: {ros__parameters: {stale_s: 3.0, stale_s: 9.0}}",
            "'stale_s' is given twice",
        ),
        ("fusoin: {ros__parameters: {}}", "no node 'fusoin'.*attitude_estimator.*fusion, recorder"),
        ("fusion: {ros__parameters: {polcy: any}}", "fusion: unknown parameter 'polcy'.*policy"),
        ("fusion: {ros__parameters: {policy: all}}", "fusion: .*'policy'.*paper, any, default"),
        ("fusion: {ros__parameters: {stale_s: 0}}", r"fusion: .*'stale_s'.*\[0\.1, 600\.0\] s"),
        ("fusion: {ros__parameters: {stale_s: soon}}", "'stale_s' must be float, got 'soon'"),
        ("fusion: {ros__parameters: {1: 2}}", "fusion: unknown parameter"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(text)
    with pytest.raises(ParameterError, match=told) as refused:
        load_parameters(path)
    assert str(refused.value).startswith(f"{path}: ")


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(ParameterError, match=re.escape(str(path))):
            load_parameters(path)
    (tmp_path / "latin.yaml").write_bytes(b"# \xe9\n")
    with pytest.raises(ParameterError, match=r"latin\.yaml"):
        load_parameters(tmp_path / "latin.yaml")


def test_an_unknown_policy_has_no_file() -> None:
    with pytest.raises(ParameterError, match="no policy 'strict'"):
        parameter_file("strict")
