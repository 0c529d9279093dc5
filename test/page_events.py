# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the live page is told, read as any client of HTTP reads it."""

from __future__ import annotations

import http.client
import json
from typing import Any
from urllib.parse import urlsplit


def seen(url: str) -> dict[str, Any]:
    """What a reader that comes now is told first: the history, and how it is now."""
    client = http.client.HTTPConnection(urlsplit(url).netloc, timeout=5.0)
    client.request("GET", "/events")
    response = client.getresponse()
    while not (line := response.readline()).startswith(b"data: "):
        pass
    client.close()
    told: dict[str, Any] = json.loads(line[6:])
    return told
