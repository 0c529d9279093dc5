# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is chosen without a vehicle does not know that vehicle."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.left_out import (
    DETECTORS,
    FACTOR,
    FlightRow,
    beyond,
    chosen,
    detectors_table,
    main,
    vehicles_table,
)
from experiments.vehicles import vehicle_of


def row(vehicle: str, name: str = "", **margins: float) -> FlightRow:
    return FlightRow(
        name=name or vehicle,
        vehicle=vehicle,
        kind="flight",
        at_risk_s=360.0,
        alert=None,
        told_s=dict.fromkeys(margins, 180.0),
        margins=margins,
    )


def flights() -> list[FlightRow]:
    return [
        row("one", "one a", coast=0.5, date=0.2),
        row("one", "one b", coast=0.8, date=0.4),
        row("two", coast=0.4, date=0.4),
        row("three", coast=0.6),
    ]


def test_the_limit_leaves_the_factor_to_the_largest_score_of_the_others() -> None:
    coast = chosen(flights(), "coast")
    assert coast.limit == FACTOR * 0.8
    assert coast.limits == {"one": FACTOR * 0.6, "two": FACTOR * 0.8, "three": FACTOR * 0.8}
    assert coast.left_out("one", 0.8) == pytest.approx(0.8 / 0.6 / FACTOR)


def test_a_flight_beyond_the_limit_in_force_is_shown_and_has_no_say() -> None:
    rows = [*flights(), row("four", coast=1.5)]
    coast = chosen(rows, "coast")
    assert coast.limits["one"] == FACTOR * 0.6
    assert coast.largest["four"] == 1.5
    for left_out in (False, True):
        found = [one.name for one in beyond(rows, {"coast": coast}, left_out=left_out)]
        assert found == (["one b", "four"] if left_out else ["four"])


margins = st.dictionaries(st.sampled_from("abcde"), st.floats(0.0, 0.99), min_size=2)


@given(margins, st.floats(0.0, 5.0))
def test_no_limit_depends_on_the_vehicle_that_it_is_shown_on(
    largest: dict[str, float], other: float
) -> None:
    vehicle = min(largest)
    before, after = (
        chosen([row(name, coast=one) for name, one in found.items()], "coast").limits[vehicle]
        for found in (largest, {**largest, vehicle: other})
    )
    assert before == after


def test_the_tables_show_both_columns() -> None:
    by_vehicle = {cells[0]: cells for cells in vehicles_table(flights()).rows}
    coast, date = (3 + DETECTORS.index(name) for name in ("coast", "date"))
    assert by_vehicle["one"][1:3] == ("2", "0.20")
    assert by_vehicle["one"][coast] == "0.80, **1.07**"
    assert by_vehicle["three"][date] == "–"

    by_detector = {cells[0]: cells for cells in detectors_table(flights()).rows}
    assert by_detector["coast"][1:] == (
        *("3", "0.20", "0.80 (one)", "0.60 (three)", "1.00, 0.75", "1.33", "0", "1"),
    )
    assert by_detector["kld"][1:] == ("0", *("–",) * 7)
    assert by_detector["any that alerts"][-2:] == ("0", "1")


def test_rows_that_were_kept_make_the_tables_again(tmp_path: Path) -> None:
    from click.testing import CliRunner  # noqa: PLC0415

    rows, document = tmp_path / "rows.json", tmp_path / "page.md"
    rows.write_text(json.dumps([one.model_dump() for one in flights()]), "utf-8")
    document.write_text("before\n<!-- table left_out vehicles -->\n<!-- table sitl each -->\n")
    done = CliRunner().invoke(main, [str(document), "--rows", str(rows), "--no-flights"])
    assert done.exit_code == 0, done.output
    assert "in force: 0/3" in done.output
    assert "without the vehicle: 1/3" in done.output
    before, marked = document.read_text("utf-8").split("<!-- table left_out vehicles -->")
    assert before == "before\n"
    assert marked.count("| one | 2 |") == 1
    assert marked.endswith("<!-- table sitl each -->\n")


@pytest.mark.parametrize(
    ("name", "vehicle"),
    [
        ("erlerobot__10-11-2014_103", "erle_quad"),
        ("arducopter_3.3_218.BIN", "erle_quad"),
        ("dronekit_la__log171", "log171"),
        ("arducopter_3.3_log171.bin", "log171"),
        ("joeydouglas__2014-10-18_20-04-24", "quad_texas"),
        ("inertialnav__quad106", "quad106"),
        ("dev_007_straight", "sitl_copter"),
        ("mine.bin", "mine"),
    ],
)
def test_a_vehicle_is_one_whatever_its_flights_are_called(
    tmp_path: Path, name: str, vehicle: str
) -> None:
    assert vehicle_of(tmp_path / name) == vehicle
    labels = [{"file": name, "vehicle": "said", "class": "flight", "attack": None}]
    (tmp_path / "labels.json").write_text(json.dumps(labels))
    assert vehicle_of(tmp_path / name) == "said"
