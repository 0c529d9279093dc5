# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What several tests need and takes seconds to compute: once in a session, in whatever worker.

Results are pickled into the session's own temporary folder, which pytest removes, so no session
sees those of another::

    run = kept("offline curved_8 default", lambda: run_offline(...))

What is given is the same object for all tests of a process: it must not be changed.
"""

from __future__ import annotations

import fcntl
import hashlib
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import pytest

T = TypeVar("T")

_kept: dict[str, Any] = {}
_folder: Path | None = None


def keep_in(factory: pytest.TempPathFactory) -> None:
    """Choose the folder; workers of one session have theirs side by side below the session's."""
    global _folder  # noqa: PLW0603  set once in each process
    base = factory.getbasetemp()
    _folder = (base.parent if base.name.startswith("popen-") else base) / "kept"
    _folder.mkdir(exist_ok=True)


def kept(key: str, make: Callable[[], T]) -> T:
    """Give what `make` gives, which depends on nothing but the key.

    Whoever comes first computes it, others wait for that.
    """
    if key not in _kept:
        assert _folder is not None, "conftest.py chooses the folder"
        path = _folder / hashlib.sha256(key.encode()).hexdigest()[:16]
        with path.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if path.exists():
                _kept[key] = pickle.loads(path.read_bytes())
            else:
                _kept[key] = make()
                path.write_bytes(pickle.dumps(_kept[key], pickle.HIGHEST_PROTOCOL))
    return _kept[key]  # type: ignore[no-any-return]
