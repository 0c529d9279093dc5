# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Message classes by the name of their type."""

from __future__ import annotations

import importlib
import importlib.util
import re
from pathlib import Path
from typing import Any


def message_class(msgtype: str) -> Any:
    """Return the class of a message type such as std_msgs/msg/Bool, None if not installed.

    A bag can name any package: only those that contain messages are imported.
    """
    match = re.fullmatch(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)", msgtype)
    found = importlib.util.find_spec(match[1]) if match else None
    folders = (found and found.submodule_search_locations) or []
    if match is None or not any(Path(folder, "msg").is_dir() for folder in folders):
        return None
    kind = getattr(importlib.import_module(f"{match[1]}.msg"), match[2], None)
    return kind if hasattr(kind, "get_fields_and_field_types") else None
