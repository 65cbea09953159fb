# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Materials of prints."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from ._given import plain, positive, short
from .errors import InputError

@dataclass(frozen=True)
class Material:
    """A material of a print.

    Attributes
    ----------
    name : str
        Its name in the world.
    key : str
        Its colour in slices, `#rrggbb`.
    preview : str or None
        Its colour in pictures, `#rrggbb` or `#rrggbbaa`. Default: the key.
    density_g_cm3 : float
        Its density in g/cm³, for estimates.
    channel : str or None
        The printer's name for it.

    Raises
    ------
    InputError
        If a colour has another form, or the density is not greater than 0.
    """

    name: str
    key: str
    preview: str | None = None
    density_g_cm3: float = 1.18
    channel: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"a material cannot be called {short(self.name)}; its name is a text")
        what = f"of material `{self.name}`"
        for key, value, form in (("key", self.key, _OPAQUE), ("preview", self.preview, _COLOR)):
            if value is None and key == "preview":
                continue
            if not isinstance(value, str) or not re.fullmatch(form, value):
                known = "#rrggbb or #rrggbbaa" if form is _COLOR else "#rrggbb, which is opaque"
                raise InputError(f"`{key}` {what} cannot be {short(value)}; write it as {known}")
        positive(self.density_g_cm3, f"`density_g_cm3` {what}")

    def _spec(self) -> dict[str, Any]:
        spec = {"key": self.key, "preview": self.preview, "density_g_cm3": self.density_g_cm3, "channel": self.channel}
        given = {key: value for key, value in spec.items() if value is not None}
        described: dict[str, Any] = plain(given, f"material `{self.name}`")
        return described


_OPAQUE, _COLOR = "#[0-9a-fA-F]{6}", "#[0-9a-fA-F]{6}([0-9a-fA-F]{2})?"

VOID = "VOID"
"""The material of empty space, for uniforms."""
