# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Wind and drag from forces that the model itself makes."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from filter_start import AIR

from hijack_detect.estimation.drag_filter import BIAS, DRAG, WIND, AirBlock, DragFilter

Vector = npt.NDArray[np.float64]


def block(t: float, course: float, wind: Vector, *, k: float = 0.3) -> AirBlock:
    """Level flight along the nose at 3 to 9 m/s, with a bias of (0.1, -0.05) m/s².

    At a constant speed drag and bias along the nose would look the same.
    """
    c, s = math.cos(course), math.sin(course)
    turn = np.array([[c, s], [-s, c]])
    velocity = np.array([6.0 + 3.0 * math.sin(0.5 * t), 0.0])
    force = -k * (velocity - turn @ wind) + np.array([0.1, -0.05])
    return AirBlock(round(t * 1e9), 0.4, turn, velocity, force)


def learnt(wind: Vector, turning: float = 0.2) -> DragFilter:
    found = DragFilter(AIR)
    for index in range(300):
        found.wait(0.4)
        found.update(block(0.4 * index, turning * 0.4 * index, wind))
    return found


def test_a_circle_tells_wind_drag_and_bias_apart() -> None:
    wind = np.array([3.0, -2.0])
    found = learnt(wind)
    assert found.state[WIND] == pytest.approx(wind, abs=0.4)
    assert found.state[BIAS] == pytest.approx([0.1, -0.05], abs=0.05)
    assert found.state[DRAG] == pytest.approx(0.3, abs=0.04)
    assert np.linalg.eigvalsh(found.covariance)[0] > 0.0


@pytest.mark.parametrize("change", [(0.0, 0.0), (4.0, 0.0), (-2.0, 3.0)])
def test_a_change_of_wind_is_found(change: tuple[float, float]) -> None:
    wind = np.array([1.0, 1.0])
    after = [block(0.4 * n, 0.08 * n, wind + np.array(change)) for n in range(50)]
    found = learnt(wind).wind_change(after, 5.0)
    assert found.change == pytest.approx(change, abs=0.5)
    assert found.sigma < 1.0


def test_a_turn_after_a_straight_route_is_not_known_as_well() -> None:
    wind = np.zeros(2)
    after = [block(0.4 * n, math.pi / 2, wind) for n in range(50)]
    straight = learnt(wind, turning=0.0).wind_change(after, 5.0)
    circling = learnt(wind).wind_change(after, 5.0)
    assert straight.sigma > 2.0 * circling.sigma
