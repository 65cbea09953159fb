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
    """A world as one print reads it: a file of its own, unchanged while the print holds this."""

    path: Path
    sources: tuple[Path, ...]
    allowed: tuple[str, ...]
    """Its permissions: folders to read from, and the word that allows programs."""
    settings: tuple[str, ...]
    """Values of uniforms that replace the world's, as `OBJECT.UNIFORM=VALUE`."""
    description: dict[str, Any]
    names: Mapping[str, str] = field(default_factory=dict)
    """The user's names for temporary files, which messages use."""
    kept: tuple[Any, ...] = ()
    """The owners of the files that it names."""

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of Options through which a print finds it."""
        return {"input": str(self.path), "allow": list(self.allowed), "settings": list(self.settings)}

    def program(self, enable_printf: bool = False, derivatives: tuple[str, ...] = ()) -> _core.Program:
        """Returns the kernels of its fablets, with derivatives by uniforms of these names."""
        return programs.find(self.sources, enable_printf, dither_rule(options_of(self.fields)), derivatives)[0]


def allowed_by(folders: Iterable[Any], programs: bool) -> tuple[str, ...]:
    """Returns the permissions of a world for Options."""
    return (*map(str, folders), *([_core.PROGRAMS_WORD] if programs else []))


def settings_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Returns values of uniforms for Options."""
    return tuple(
        f"{target}={value if isinstance(value, str) else json.dumps(value)}" for target, value in values.items()
    )


def dither_rule(options: _core.Options) -> tuple[str, str] | None:
    """Returns the file and the function of the dither rule named by the world of a print."""
    rule = _core.world_dither(options)
    if isinstance(rule, _core.Error):
        raise_error(rule)
    return rule
