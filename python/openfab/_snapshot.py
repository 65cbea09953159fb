# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""A world as one print reads it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _core
from .errors import raise_error
from .fablet import programs

@dataclass(frozen=True, eq=False)
class Snapshot:
    """A world as one print reads it: its own file, which nothing changes while the print holds this."""

    path: Path
    sources: tuple[Path, ...]
    allowed: tuple[str, ...]
    """Options: what it may read."""
    settings: tuple[str, ...]
    """Options: other values of uniforms."""
    description: dict[str, Any]
    names: Mapping[str, str] = field(default_factory=dict)
    """What messages call files that were made for it: what the user calls them."""
    kept: tuple[Any, ...] = ()
    """What owns the files that it names."""

    @property
    def words(self) -> list[str]:
        """What names it to a print."""
        return [str(self.path), *self.allowed, *self.settings]

    def program(self, enable_printf: bool = False) -> _core.Program:
        """Returns the kernels of its fablets."""
        return programs.find(self.sources, enable_printf, dither_rule(self.words))[0]


def allowed_words(folders: Iterable[Any], programs: bool) -> tuple[str, ...]:
    return (*(f"--allow={folder}" for folder in folders), *(["--allow-programs"] if programs else []))


def set_words(settings: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(
        f"--set={target}={value if isinstance(value, str) else json.dumps(value)}" for target, value in settings.items()
    )


def dither_rule(words: list[str]) -> tuple[str, str] | None:
    """The file and the function of the dither rule that a world names; `words` name the world, and what it may read."""
    rule = _core.world_dither(words)
    if isinstance(rule, _core.Error):
        raise_error(rule)
    return rule
