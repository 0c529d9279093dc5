# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The analysis of a bag as data: spans, outcome, and the JSON with its schema."""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from live import SCENARIO, SECOND
from ros import ROOT
from small_bags import START_NS, STEP_NS, flag, flight, raw, write

from hijack_detect.analysis.account import MONITOR
from hijack_detect.analysis.alarms import AlertSpan, AlertSpans, Span, StateSpans
from hijack_detect.analysis.analyse import (
    Analysed,
    analyse,
    first_hit,
    outcome_of,
)
from hijack_detect.analysis.analysis import Analysis, Outcome, schema_text
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.truth import Attack
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import FixSample, ImuSample, PressureSample

jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")

SCHEMA = ROOT / "docs/analysis.schema.json"
REMAKE = (
    'python -c "from hijack_detect.analysis.analysis import schema_text; '
    "print(schema_text(), end='')\" > docs/analysis.schema.json"
)
ATTACK = Attack(60 * SECOND, 90 * SECOND)


Verdicts = dict[str, list[Verdict]]


@pytest.fixture(scope="module")
def analysed() -> tuple[Analysed, Verdicts]:
    verdicts: Verdicts = defaultdict(list)

    def receive(part: str, output: Any) -> None:
        if isinstance(output, Verdict):
            verdicts[part].append(output)

    with BagReader(ROOT / "bags/curved_8") as reader:
        scenario, parameters = load_scenario(SCENARIO), policy_parameters("default")
        return analyse(reader, parameters, scenario, on_output=receive), verdicts


@pytest.fixture(scope="module")
def spoofed(analysed: tuple[Analysed, Verdicts]) -> Analysed:
    return analysed[0]


def state_spans(
    verdicts: Sequence[Verdict], start_ns: int, end_ns: int, stale_ns: int
) -> list[Span]:
    spans = StateSpans(start_ns, stale_ns)
    for one in verdicts:
        spans.add(one)
    return spans.finish(end_ns)


def said(*states: tuple[float, State]) -> list[Verdict]:
    return [
        Verdict("date", round(at_s * SECOND), state, 0.0, 1.0, f"at {at_s:g}")
        for at_s, state in states
    ]


def result(at_s: float, *, alert: bool) -> FusionResult:
    stamp_ns = round(at_s * SECOND)
    since_ns = stamp_ns if alert else None
    state = State.ALARM if alert else State.NORMAL
    return FusionResult(stamp_ns, state, alert, since_ns, 0.9, f"at {at_s:g}", {}, (), ("date",))


def alerts_at(*times_s: float) -> list[AlertSpan]:
    return [AlertSpan(round(at_s * SECOND), 110 * SECOND, ("date",), 1.0, "") for at_s in times_s]


def test_a_verdict_holds_until_the_next_and_then_goes_stale() -> None:
    verdicts = said(
        (1.0, State.NORMAL), (2.0, State.NORMAL), (3.0, State.ALARM), (8.0, State.NORMAL)
    )
    assert state_spans(verdicts, 0, 10 * SECOND, 3 * SECOND) == [
        Span(State.NOT_READY, 0, SECOND, "no verdict yet"),
        Span(State.NORMAL, SECOND, 3 * SECOND, "at 1"),
        Span(State.ALARM, 3 * SECOND, 6 * SECOND, "at 3"),
        Span(State.STALE, 6 * SECOND, 8 * SECOND, "silent"),
        Span(State.NORMAL, 8 * SECOND, 10 * SECOND, "at 8"),
    ]


def test_without_a_verdict_nothing_was_ready() -> None:
    assert state_spans([], 0, SECOND, SECOND) == [
        Span(State.NOT_READY, 0, SECOND, "no verdict yet")
    ]
    assert state_spans([], 0, 0, SECOND) == []


def test_an_alert_lasts_until_it_is_taken_back_or_the_flight_ends() -> None:
    results = [result(at_s, alert=at_s in (2.0, 3.0, 7.0)) for at_s in (1.0, 2.0, 3.0, 5.0, 7.0)]
    spans = AlertSpans()
    for one in results:
        spans.add(one)
    assert [(one.start_ns, one.end_ns, one.cause) for one in spans.finish(9 * SECOND)] == [
        (2 * SECOND, 5 * SECOND, "at 2"),
        (7 * SECOND, 9 * SECOND, "at 7"),
    ]


@pytest.mark.parametrize(
    ("times_s", "attack", "labelled", "outcome", "hit_s"),
    [
        ((65.0,), ATTACK, True, Outcome.DETECTED, 65.0),
        ((60.0,), ATTACK, True, Outcome.DETECTED, 60.0),
        ((), ATTACK, True, Outcome.MISSED, None),
        ((90.0,), ATTACK, True, Outcome.LATE, 90.0),
        ((90.0,), Attack(60 * SECOND, None), True, Outcome.DETECTED, 90.0),
        ((59.9,), ATTACK, True, Outcome.FALSE_ALERT, None),
        ((10.0, 65.0), ATTACK, True, Outcome.FALSE_ALERT, 65.0),
        ((10.0,), None, True, Outcome.FALSE_ALERT, None),
        ((), None, True, Outcome.NO_ATTACK_NO_ALERT, None),
        ((10.0,), None, False, Outcome.ALERT_UNLABELLED, None),
        ((), None, False, Outcome.NO_ALERT_UNLABELLED, None),
    ],
)
def test_the_first_alert_is_judged(
    times_s: Sequence[float],
    attack: Attack | None,
    labelled: bool,
    outcome: Outcome,
    hit_s: float | None,
) -> None:
    alerts = alerts_at(*times_s)
    assert outcome_of(alerts, attack, labelled=labelled) is outcome
    hit = first_hit(alerts, attack)
    assert (None if hit is None else hit.start_ns / SECOND) == hit_s


def test_a_spoofed_flight_is_detected(spoofed: Analysed) -> None:
    found = spoofed.analysis
    assert found.outcome is Outcome.DETECTED
    assert found.spoof is not None
    assert (found.spoof.onset_s, found.spoof.end_s) == (60.0, 90.0)
    assert found.spoof.known_from == "scenario"
    (alert,) = found.alerts
    assert found.time_to_detect_s == pytest.approx(alert.start_s - 60.0)
    assert alert.end_s == found.duration_s
    assert set(alert.detectors) <= set(found.detectors)
    assert found.deviation_at_alarm_m == spoofed.flight.separation_at(spoofed.alerts[0].start_ns)
    assert found.spoof.largest_deviation_m is not None
    assert found.deviation_at_alarm_m is not None
    assert 0.0 < found.deviation_at_alarm_m <= found.spoof.largest_deviation_m
    assert f"{alert.start_s:.1f} s" in found.verdict
    assert found.skipped == {}


def test_states_cover_the_flight_and_alarms_are_those_of_the_verdicts(
    analysed: tuple[Analysed, Verdicts],
) -> None:
    spoofed, said_by = analysed
    for name, detector in spoofed.analysis.detectors.items():
        verdicts = said_by[name]
        whole = sum(detector.state_s.values())
        assert whole == pytest.approx(spoofed.analysis.duration_s, abs=0.1)
        in_alarm = sum(one.end_s - one.start_s for one in detector.alarms)
        assert in_alarm == pytest.approx(detector.state_s[State.ALARM], abs=1e-3)
        firsts = [
            spoofed.seconds(now.stamp_ns)
            for before, now in pairwise(verdicts)
            if now.state is State.ALARM is not before.state
        ]
        assert [one.start_s for one in detector.alarms] == firsts
        assert detector.largest_margin is not None
        assert detector.largest_margin.margin == max(one.margin for one in verdicts)
    assert MONITOR in spoofed.spans


def test_the_committed_schema_is_the_generated_one() -> None:
    assert SCHEMA.read_text(encoding="utf-8") == schema_text(), f"made anew with: {REMAKE}"


def test_the_json_fits_the_schema_and_reads_back_equal(spoofed: Analysed) -> None:
    schema, text = json.loads(SCHEMA.read_text()), spoofed.analysis.model_dump_json()
    document = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in the JSON"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema, jsonschema.Draft202012Validator)
    for key in schema["required"]:
        less = {name: value for name, value in document.items() if name != key}
        with pytest.raises(jsonschema.ValidationError, match=key):
            jsonschema.validate(less, schema, jsonschema.Draft202012Validator)
    assert Analysis.model_validate_json(text) == spoofed.analysis


def test_left_out_messages_are_counted_by_reason(tmp_path: Path) -> None:
    at = START_NS + 3 * SECOND + STEP_NS // 2
    bad = [
        raw("/imu/data_raw", ImuSample(at, (math.nan, 0.0, 0.0), (0.0, 0.0, 9.8))),
        raw("/imu/data_raw", ImuSample(at + 1, (math.nan, 0.0, 0.0), (0.0, 0.0, 9.8))),
        raw("/gps/fix", FixSample(at, 91.0, 11.0, 500.0)),
        raw("/imu/data_raw", ImuSample(at - SECOND // 20, (0.0,) * 3, (0.0, 0.0, 9.8)), at + 2),
        raw("/pressure", PressureSample(at, 95_000.0)),
        raw("/pressure", PressureSample(at, 95_001.0), at + 3),
    ]
    messages = sorted([*flight(6.0), *bad], key=lambda one: one.log_ns)
    with BagReader(write(tmp_path / "bad", messages)) as reader:
        found = analyse(reader, policy_parameters("default")).analysis
    assert found.skipped == {
        "/gps/fix: latitude out of range": 1,
        "/imu/data_raw: angular_velocity.x out of range": 2,
        "imu: stamp does not increase": 1,
        "pressure: rejoining after an outage": 1,
        "pressure: stamp does not increase": 1,
    }


def test_what_is_known_of_the_flight_decides_what_quiet_means(tmp_path: Path) -> None:
    def outcome(path: Path) -> tuple[Outcome, str | None]:
        with BagReader(path) as reader:
            found = analyse(reader, policy_parameters("default")).analysis
            return found.outcome, None if found.spoof is None else found.spoof.known_from

    bare = write(tmp_path / "bare", flight(6.0))
    assert outcome(bare) == (Outcome.NOT_JUDGED, None)

    active = [flag("/spoof_active", START_NS + at * SECOND, at == 3) for at in (2, 3, 4)]
    messages = sorted([*flight(6.0), *active], key=lambda one: one.log_ns)
    assert outcome(write(tmp_path / "truth", messages)) == (Outcome.MISSED, "ground_truth")

    label = bare / "label.json"
    label.write_text('{"kind": "straight", "attack": null}')
    assert outcome(bare) == (Outcome.NOT_JUDGED, None)
    label.write_text('{"kind": "hijack", "attack": {"t_start": 2.0, "t_end": 5.0}}')
    assert outcome(bare) == (Outcome.MISSED, "label")
    label.write_text("[]")
    with pytest.raises(BagError, match=r"label\.json"):
        outcome(bare)
