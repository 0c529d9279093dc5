# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter sets by name, and names that are refused."""

from __future__ import annotations

import pytest

from hijack_detect.detectors.correlation import CorrelationParameters
from hijack_detect.monitor.policies import MonitorParameters, from_nodes, policy_parameters
from hijack_detect.parameters import ParameterError


def test_the_default_policy_is_the_defaults() -> None:
    assert policy_parameters("default") == MonitorParameters()
    assert policy_parameters("paper") != MonitorParameters()
    assert policy_parameters("paper").of(CorrelationParameters).epsilon == 0.85


def test_an_unknown_policy_or_node_is_refused_and_the_known_ones_are_listed() -> None:
    with pytest.raises(ParameterError, match=r"no policy 'strict'.*default, paper"):
        policy_parameters("strict")
    with pytest.raises(ParameterError, match=r"no node 'kld'.*attitude_estimator.*fusion\)"):
        from_nodes({"kld": {}})
