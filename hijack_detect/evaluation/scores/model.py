# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Base of all results."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Model(BaseModel):
    """Fixed once made, and no NaN in JSON."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)
