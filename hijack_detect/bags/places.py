# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Where a bag is: a path, or a URL of any file system that fsspec knows."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from hijack_detect.bags.errors import BagError

URL = "://"


def place(text: str) -> Path:
    """A path, or what behaves like one for a URL: s3://bucket/flights, zip://a/b::https://...

    Raises:
        BagError: The file system of a URL is not known, or what reads it is not installed.
    """
    if URL not in text:
        return Path(text)
    try:
        from upath import UPath  # noqa: PLC0415  an extra, for URLs only

        found = UPath(text)
        found.fs  # noqa: B018  finds out now whether there is such a file system
        return cast(Path, found)
    except ImportError as error:
        raise BagError(
            f"{text}: needs more to be installed, see the extra 'corpora': {error}"
        ) from error
    except (OSError, ValueError) as error:
        raise BagError(f"{text}: cannot be used: {error}") from error
