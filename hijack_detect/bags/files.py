# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which files a bag consists of."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import Any

import yaml

from hijack_detect.bags.errors import BagError

METADATA = "metadata.yaml"
MAX_METADATA_BYTES = 16 * 2**20
"""Chosen, not swept; far above the metadata of a bag."""


def mcap_files(path: Path) -> list[Path]:
    """Return the mcap files of a bag, in the order of the recording.

    Args:
        path: A rosbag2 directory, a directory that holds exactly one mcap file (the recorder
            died before it wrote metadata.yaml), or an mcap file.

    Raises:
        BagError: Nothing is there, or it is no mcap bag.
    """
    if not path.exists():
        raise BagError(f"{path}: does not exist; check the path")
    if not path.is_dir():
        return [path]
    if (path / METADATA).exists():
        return _listed(path / METADATA)
    found = sorted(path.glob("*.mcap"))
    if len(found) != 1:
        raise BagError(
            f"{path}: has no {METADATA} and {len(found)} .mcap files, so it is not clear what to "
            "read; name one .mcap file, or run `ros2 bag reindex` on the directory"
        )
    return found


def _listed(metadata: Path) -> list[Path]:
    information = _load(metadata)
    storage = information.get("storage_identifier")
    if storage != "mcap":
        raise BagError(
            f"{metadata}: storage is {storage!r}, only mcap is read; convert the bag with "
            "`rosbags-convert` or `ros2 bag convert`"
        )
    compression = str(information.get("compression_mode") or "none").lower()
    if compression != "none":
        raise BagError(
            f"{metadata}: compression mode {compression!r} of rosbag2 is not read; convert the "
            "bag with `ros2 bag convert`, or record with compressed mcap chunks "
            "(`--storage-preset-profile zstd_fast`)"
        )
    names = information.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise BagError(f"{metadata}: lists no files; run `ros2 bag reindex` on the directory")
    files = [metadata.parent / PurePath(name).name for name in names]
    for file in files:
        if not file.is_file():
            raise BagError(f"{file}: is missing, but {METADATA} lists it; copy the whole bag")
    return files


def _load(metadata: Path) -> dict[str, Any]:
    advice = "run `ros2 bag reindex` on the directory, or name its .mcap file"
    try:
        if metadata.stat().st_size > MAX_METADATA_BYTES:
            raise BagError(f"{metadata}: is larger than any bag's; {advice}")
        content = yaml.safe_load(metadata.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, RecursionError, ValueError) as error:
        if isinstance(error, BagError):
            raise
        raise BagError(f"{metadata}: cannot be read ({error}); {advice}") from error
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise BagError(f"{metadata}: is not the metadata of a rosbag2 bag; {advice}")
    return information
