# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sentences of pydantic's findings: the segment, the key, the value, the bounds."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from hijack_detect.spoofing.schema import MODELS, Document, Segment

MAX_SENTENCES = 20
"""Most problems listed of one document. Chosen: every number of a list can be wrong."""
_COLUMNS = ("t_s", "east_m", "north_m", "up_m")
_REASONS = {
    "greater_than": "{value} is not above {gt:g}",
    "greater_than_equal": "{value} is below {ge:g}",
    "less_than": "{value} is not below {lt:g}",
    "less_than_equal": "{value} is above {le:g}",
    "finite_number": "{value} is not a finite number",
    "float_type": "{value} is not a number",
    "int_type": "{value} is not a whole number",
    "bool_type": "{value} is not true or false",
    "string_type": "{value} is not text",
    "string_too_long": "has more than {max_length} characters",
    "tuple_type": "{value} is not a list",
    "too_short": "has {actual_length} entries, at least {min_length} are needed",
    "too_long": "has more than {max_length} entries",
    "literal_error": "{value} is unknown; allowed: {expected}",
    "model_type": "{value} is not a mapping of keys",
    "model_attributes_type": "{value} is not a mapping of keys",
    "invalid_key": "{value} is no key; keys are text",
}


def sentences(error: ValidationError, data: Any) -> list[str]:
    """Return each problem in one sentence, without the name of the file.

    Args:
        error: What the validation of `data` against the schema found.
        data: The document as it was read, for the names of its segments.
    """
    listed = [_sentence(found, data) for found in error.errors() if not _follows(found)]
    more = len(listed) - MAX_SENTENCES
    return [*listed[:MAX_SENTENCES], f"and {more} more problems"] if more > 0 else listed


def label(number: int, name: Any) -> str:
    """Return the words for a segment: its number, counted from 1, and its name if it has one."""
    return f"segment {number} '{name}'" if isinstance(name, str) and name else f"segment {number}"


def _follows(found: ErrorDetails) -> bool:
    """Whether a list counts as too short only because of entries that are listed already."""
    return found["type"] == "too_short" and len(found["input"]) >= found["ctx"]["min_length"]


def _sentence(found: ErrorDetails, data: Any) -> str:
    loc = list(found["loc"])
    parts = []
    holder: type[BaseModel] = Document
    if len(loc) >= 2 and loc[0] == "segments" and isinstance(loc[1], int):
        parts.append(label(loc[1] + 1, _name_of(data["segments"][loc[1]])))
        loc, holder = loc[2:], Segment
    return ": ".join([*parts, *_key_and_reason(found, loc, holder)])


def _name_of(segment: Any) -> Any:
    return segment.get("name") if isinstance(segment, Mapping) else None


def _key_and_reason(
    found: ErrorDetails, loc: list[int | str], holder: type[BaseModel]
) -> list[str]:
    prefix = ""
    if holder is Segment and loc[:1] == ["model"] and len(loc) > 1:
        prefix, holder, loc = "model.", MODELS[str(loc[1])], loc[2:]
    kind = found["type"]
    if kind == "value_error":
        return [prefix + str(found["ctx"]["error"])]
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return ["model.type", _tag_reason(found)]
    if not loc:
        return [prefix.rstrip("."), _reason(found)] if prefix else [_reason(found)]
    if kind == "extra_forbidden":
        return [f"{prefix}{loc[0]}", _unknown_key(str(loc[0]), holder)]
    if kind == "missing":
        return [f"{prefix}{loc[0]}", f"missing; {_description(str(loc[0]), holder)}"]
    return [prefix + _key(loc), _reason(found)]


def _reason(found: ErrorDetails) -> str:
    value = found["input"]
    template = _REASONS.get(found["type"])
    if template is None:
        return f"{found['msg']}, got {reprlib.repr(value)}"
    reason = template.format(value=reprlib.repr(value), **found.get("ctx", {}))
    if found["type"] == "float_type" and isinstance(value, str) and _is_number(value):
        reason += " but text; write it without quotes, a power of ten as 1.0e+3"
    return reason


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _tag_reason(found: ErrorDetails) -> str:
    allowed = f"allowed: {', '.join(MODELS)}"
    if found["type"] == "union_tag_not_found":
        return f"missing; {allowed}"
    return f"{found['ctx']['tag']!r} is unknown; {allowed}"


def _keys(holder: type[BaseModel]) -> dict[str, str]:
    """Every key of a part of the file with its description."""
    return {
        field.alias or name: field.description or "" for name, field in holder.model_fields.items()
    }


def _description(key: str, holder: type[BaseModel]) -> str:
    return _keys(holder).get(key, "")


def _unknown_key(key: str, holder: type[BaseModel]) -> str:
    known = _keys(holder)
    close = difflib.get_close_matches(key, known, n=1)
    hint = f"did you mean {close[0]}? " if close else ""
    return f"unknown key; {hint}allowed: {', '.join(known)}"


def _key(loc: list[int | str]) -> str:
    """A place below a part of the file; entries of a list by number, from 1."""
    words = [str(loc[0])]
    for depth, step in enumerate(loc[1:]):
        if loc[0] == "positions" and depth == 0 and isinstance(step, int):
            words.append(f"row {step + 1}")
        elif loc[0] == "positions" and isinstance(step, int):
            words.append(_COLUMNS[step] if step < len(_COLUMNS) else f"number {step + 1}")
        elif isinstance(step, int):
            words.append(f"number {step + 1}")
        else:
            words.append(str(step))
    return words[0] + (f": {', '.join(words[1:])}" if len(words) > 1 else "")
