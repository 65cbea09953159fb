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
from ._options import options_of
from .errors import raise_error
from .fablet import programs

@dataclass(frozen=True, eq=False)
class Snapshot:
    """A world as one print reads it: its own file, which nothing changes while the print holds this."""

    path: Path
    sources: tuple[Path, ...]
    allowed: tuple[str, ...]
    """What it may read: folders, and the word for programs."""
    settings: tuple[str, ...]
    """Other values of uniforms, as `OBJECT.UNIFORM=VALUE`."""
    description: dict[str, Any]
    names: Mapping[str, str] = field(default_factory=dict)
    """What messages call files that were made for it: what the user calls them."""
    kept: tuple[Any, ...] = ()
    """What owns the files that it names."""

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of Options that name it to a print."""
        return {"input": str(self.path), "allow": list(self.allowed), "settings": list(self.settings)}

    def program(self, enable_printf: bool = False) -> _core.Program:
        """Returns the kernels of its fablets."""
        return programs.find(self.sources, enable_printf, dither_rule(options_of(self.fields)))[0]


def allowed_by(folders: Iterable[Any], programs: bool) -> tuple[str, ...]:
    """What a world may read, as Options have it."""
    return (*map(str, folders), *([_core.PROGRAMS_WORD] if programs else []))


def settings_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Values of uniforms, as Options have them."""
    return tuple(
        f"{target}={value if isinstance(value, str) else json.dumps(value)}" for target, value in values.items()
    )


def dither_rule(options: _core.Options) -> tuple[str, str] | None:
    """The file and the function of the dither rule that the world of a print names."""
    rule = _core.world_dither(options)
    if isinstance(rule, _core.Error):
        raise_error(rule)
    return rule
