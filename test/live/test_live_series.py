# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bounded histories: nothing twice, nothing lost that is kept, no peak thinned away."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.live.picture import Curve, Series

MARGINS = st.floats(0.0, 100.0)


@given(st.lists(st.one_of(st.integers(), st.none())), st.integers(1, 20))
def test_a_reader_gets_every_entry_once_as_far_as_it_is_kept(
    steps: list[int | None], most: int
) -> None:
    """None is a look of the reader."""
    series: Series[int] = Series(most)
    came: list[int] = []
    had = 0
    for step in [*steps, None]:
        if step is not None:
            series.append(step)
            came.append(step)
            continue
        news = series.since(had)
        assert news == came[max(had, len(came) - most) :]
        had = series.count
    assert len(series.since(0)) <= most


@given(st.lists(MARGINS, min_size=1, max_size=300))
def test_a_curve_keeps_one_point_a_period_and_its_largest(values: list[float]) -> None:
    curve = Curve(1000, 1.0)
    for index, value in enumerate(values):
        curve.add(index * 0.1, value)
    kept = curve.points.since(0)
    for period in range(len(values) // 10 - 1):
        whole = values[period * 10 : period * 10 + 10]
        inside = [one for one in kept if int((one[0] + 1e-9) // 1.0) == period]
        assert len(inside) <= 2
        assert max(value for _, value in inside if value is not None) == max(whole)


def test_a_gap_is_kept_once() -> None:
    curve = Curve(10, 1.0)
    for index, value in enumerate((None, 0.5, 0.7, None, None, 0.2, None)):
        curve.add(index * 0.1, value)
    assert [value for _, value in curve.points.since(0)] == [0.7, None, 0.2, None]
