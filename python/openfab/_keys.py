# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Keys of a `.fab.json`, of which the loader has the table: which there are, and which are paths."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from . import _core
from ._given import choice
from .errors import raise_error

def check_keys(given: Iterable[str], kind: str, what: str, own: Sequence[str]) -> None:
    """Refuses keys that do not exist in a `.fab.json`, and those that have arguments of their own."""
    known = [key for key in _core.world_keys(kind) if key not in own]
    for key in given:
        choice(key, f"a key of {what}", known)


def absolute_paths(world: str) -> tuple[str, list[Path]]:
    """Returns the JSON of a world whose paths count from the working directory with absolute paths, and these."""
    found = _core.absolute_paths(world, os.getcwd())
    if isinstance(found, _core.Error):
        raise_error(found)
    return found[0], list(map(Path, found[1]))


def absolute(world: dict[str, Any]) -> dict[str, Any]:
    """Returns some keys of a world, whose paths count from the working directory, with absolute paths."""
    found: dict[str, Any] = json.loads(absolute_paths(json.dumps(world))[0])
    return found
