"""Base of all results."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Model(BaseModel):
    """Fixed once made, and no NaN in JSON."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)
