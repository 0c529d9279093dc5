# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Course over ground against closed formulas of the ellipsoid, and Eq. 1 in all its cases."""

import math

import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.course import (
    CourseEstimator,
    CourseParameters,
    displacement,
    gps_angle,
)
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.streams.samples import CourseSample, FixSample

SECOND = 10**9
PLACES = [
    (0.0, 0.0),
    (48.1, 11.6),
    (-35.4, 149.2),
    (-33.4, -70.7),
    (37.8, -122.4),
    (51.5, 0.0),
    (0.0, 179.99999),
    (-17.0, -179.99999),
    (78.2, 15.6),
    (-89.0, 45.0),
]
COMPASS = {
    "N": (0, 1),
    "NE": (1, 1),
    "E": (1, 0),
    "SE": (1, -1),
    "S": (0, -1),
    "SW": (-1, -1),
    "W": (-1, 0),
    "NW": (-1, 1),
}
"""East and north of the eight directions, clockwise from North."""


def moved(start: FixSample, east: float, north: float, stamp_ns: int) -> FixSample:
    """A fix a few metres away, by the ellipsoid's radii of curvature."""
    a, e2 = 6378137.0, 0.00669437999014
    sine = math.sin(math.radians(start.latitude_deg))
    meridian = a * (1 - e2) / (1 - e2 * sine**2) ** 1.5
    normal = a / math.sqrt(1 - e2 * sine**2)
    latitude = start.latitude_deg + math.degrees(north / (meridian + start.altitude_m))
    radius = (normal + start.altitude_m) * math.cos(math.radians(start.latitude_deg))
    longitude = start.longitude_deg + math.degrees(east / radius)
    longitude = (longitude + 180.0) % 360.0 - 180.0
    return FixSample(stamp_ns, latitude, longitude, start.altitude_m)


def estimator(min_speed: float = 2.0, max_gap_s: float = 2.0) -> CourseEstimator:
    return CourseEstimator(CourseParameters(min_speed=min_speed, max_gap_s=max_gap_s))


def course_between(start: FixSample, end: FixSample, **parameters: float) -> CourseSample:
    one = estimator(**parameters)
    one.update("fix", start)
    return one.update("fix", end)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("direction", COMPASS)
def test_the_eight_directions_everywhere(place: tuple[float, float], direction: str) -> None:
    east, north = COMPASS[direction]
    start = FixSample(0, *place, 100.0)
    course = course_between(start, moved(start, 4.0 * east, 4.0 * north, SECOND))
    assert course.observable
    expected = list(COMPASS).index(direction) * math.pi / 4
    found = gps_angle(course)
    assert math.remainder(found - expected, math.tau) == pytest.approx(0.0, abs=2e-4)
    assert math.remainder(course.angle - math.atan2(north, east), math.tau) == pytest.approx(
        0.0, abs=2e-4
    )


def test_south_and_west_are_not_lost_as_in_the_printed_case_table() -> None:
    start = FixSample(0, 0.0, 10.0, 0.0)
    south = FixSample(SECOND, -1e-4, 10.0, 0.0)
    west = FixSample(SECOND, 0.0, 10.0 - 1e-4, 0.0)
    assert gps_angle(course_between(start, south)) == pytest.approx(math.pi)
    assert gps_angle(course_between(start, west)) == pytest.approx(1.5 * math.pi)


@given(st.floats(-math.pi, math.pi))
def test_gps_angle_is_within_the_papers_range(angle: float) -> None:
    course = CourseSample(0, math.sin(angle / 2), math.cos(angle / 2))
    found = gps_angle(course)
    assert 0.0 <= found < math.tau
    assert math.sin(found) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.cos(found) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize("angle", [math.pi / 2, math.nextafter(math.pi / 2, 4.0)])
def test_gps_angle_at_north_is_zero_and_not_a_whole_turn(angle: float) -> None:
    found = gps_angle(CourseSample(0, math.sin(angle / 2), math.cos(angle / 2)))
    assert 0.0 <= found < math.tau
    assert math.remainder(found, math.tau) == pytest.approx(0.0, abs=1e-12)


@given(
    st.sampled_from(PLACES),
    st.floats(-math.pi, math.pi),
    st.floats(0.5, 200.0),
    st.integers(SECOND // 10, SECOND),
)
def test_speed_and_angle_of_any_displacement(
    place: tuple[float, float], angle: float, distance: float, dt_ns: int
) -> None:
    start = FixSample(7, *place, 50.0)
    end = moved(start, distance * math.cos(angle), distance * math.sin(angle), 7 + dt_ns)
    one = estimator(min_speed=0.0)
    assert not one.update("fix", start).observable
    course = one.update("fix", end)
    assert course.stamp_ns == end.stamp_ns
    assert one.speed == pytest.approx(distance / (dt_ns / SECOND), rel=2e-3)
    assert math.remainder(course.angle - angle, math.tau) == pytest.approx(0.0, abs=2e-3)
    assert course.qz**2 + course.qw**2 == pytest.approx(1.0)


def test_speed_gate() -> None:
    start = FixSample(0, 48.0, 11.0, 500.0)
    for speed, observable in ((1.9, False), (2.1, True)):
        course = course_between(start, moved(start, 0.2 * speed, 0.0, SECOND // 5))
        assert course.observable is observable


def test_a_climb_is_not_a_course() -> None:
    course = course_between(FixSample(0, 48.0, 11.0, 0.0), FixSample(SECOND, 48.0, 11.0, 20.0))
    assert not course.observable


@pytest.mark.parametrize("min_speed", [0.0, 2.0])
def test_repeated_fixes_have_no_course(min_speed: float) -> None:
    start = FixSample(0, 48.0, 11.0, 500.0)
    one = estimator(min_speed)
    one.update("fix", start)
    first = one.update("fix", moved(start, 2.0, 0.0, SECOND // 5))
    again = one.update("fix", moved(start, 2.0, 0.0, 2 * SECOND // 5))
    assert first.observable
    assert not again.observable
    assert one.speed == 0.0


def test_a_gap_gives_no_course_and_the_next_fix_does() -> None:
    start = FixSample(0, 48.0, 11.0, 500.0)
    one = estimator(max_gap_s=2.0)
    one.update("fix", start)
    assert one.update("fix", moved(start, 20.0, 0.0, 2 * SECOND)).observable
    assert not one.update("fix", moved(start, 80.0, 0.0, 4 * SECOND + 1)).observable
    assert one.update("fix", moved(start, 90.0, 0.0, 5 * SECOND)).observable


def test_a_fix_without_position_is_no_end_of_a_displacement() -> None:
    start = FixSample(0, 48.0, 11.0, 500.0)
    lost = FixSample(SECOND // 5, 0.0, 0.0, 0.0, has_fix=False)
    one = estimator()
    one.update("fix", start)
    assert not one.update("fix", lost).observable
    assert not one.update("fix", moved(start, 4.0, 0.0, 2 * SECOND // 5)).observable
    assert one.update("fix", moved(start, 6.0, 0.0, 3 * SECOND // 5)).observable


@given(
    st.floats(-80.0, 80.0),
    st.floats(-180.0, 180.0),
    st.tuples(*[st.floats(-3000.0, 3000.0)] * 2, st.floats(-100.0, 400.0)),
)
def test_the_local_frame_is_the_tangent_plane(
    latitude: float, longitude: float, place: tuple[float, float, float]
) -> None:
    """Through Earth-centred coordinates and a rotation written out here."""
    lat, lon = math.radians(latitude), math.radians(longitude)
    x0, y0, z0 = pymap3d.geodetic2ecef(latitude, longitude, 200.0)
    east, north, up = place
    x = x0 - math.sin(lon) * east - math.sin(lat) * math.cos(lon) * north
    x += math.cos(lat) * math.cos(lon) * up
    y = y0 + math.cos(lon) * east - math.sin(lat) * math.sin(lon) * north
    y += math.cos(lat) * math.sin(lon) * up
    z = z0 + math.cos(lat) * north + math.sin(lat) * up
    fix = FixSample(1, *(float(v) for v in pymap3d.ecef2geodetic(x, y, z)))
    origin = FixSample(0, latitude, longitude, 200.0)
    assert LocalFrame(origin).enu(fix) == pytest.approx(place, abs=1e-3)
    assert displacement(origin, fix) == pytest.approx(place, abs=1e-3)
