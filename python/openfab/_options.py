# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments of prints as the words of `openfab print`."""

from __future__ import annotations

import os
from typing import Any

from ._given import is_sequence, length, pitch, positive, several, short, whole
from .errors import InputError


def words_of(**options: Any) -> list[str]:
    """Returns the words for some arguments; those that are None have none."""
    words: list[str] = []
    for key, value in options.items():
        if value is not None:
            words += _words(key, f"--{key.replace('_', '-')}", value)
    return words


def _words(key: str, name: str, value: Any) -> list[str]:
    what = f"`{key}`"
    if key == "voxel" and is_sequence(value):
        x, y, z = (positive(one, what) for one in several(value, what, (3,), "one pitch, or three, of x, y and z"))
        return [f"--dpi={25.4 / x!r}x{25.4 / y!r}", f"--layer={z!r}mm"]
    if key in ("voxel", "layer", "mesh_pitch"):
        return [f"{name}={pitch(value, what)}"]
    if key == "dpi" and not isinstance(value, str):
        pair = several(value, what, (2,), "one resolution, or two, of x and y") if is_sequence(value) else [value]
        return [f"{name}={'x'.join(repr(positive(one, what)) for one in pair)}"]
    if key == "slices":
        first, end = (whole(one, what) for one in several(value, what, (2,), "the first slice, and one past the last"))
        if not 0 <= first < end:
            raise InputError(f"{what} cannot be {short(value)}; they are from 0 on, and the second is larger")
        return [f"{name}={first}:{end}"]
    if key == "z":
        low, high = (length(one, what) for one in several(value, what, (2,), "the lowest height, and the highest"))
        return [f"{name}={low}:{high}"]
    if key in ("draft", "seed", "threads"):
        found = whole(value, what)
        if key != "seed" and found < 1:
            raise InputError(f"{what} cannot be {short(value)}; it is 1 at least")
        return [f"{name}={found}"]
    if key == "memory" and not isinstance(value, str):
        return [f"{name}={int(positive(value, what, 1))}B"]
    if key == "support" and not isinstance(value, str):
        if value not in (True, False):
            raise InputError(f"{what} cannot be {short(value)}; it is True, False or the name of a material")
        return [f"{name}={'on' if value else 'off'}"]
    if isinstance(value, (str, os.PathLike)):
        return [f"{name}={os.fsdecode(value)}"]
    raise InputError(f"{what} cannot be {short(value)}")
