# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Slices, and the description of their print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

class Slice(NamedTuple):
    """One slice of a print.

    Attributes
    ----------
    z : int
        Its number; 0 is the lowest slice of the whole print.
    codes : ndarray of uint8, shape (y, x)
        0 is void, 1 is the first material; row 0 is at the lowest y. Codes from a print are read-only.
    fractions : ndarray of float32, shape (y, x, material), or None
        The mixture before the dither, if requested; the rest up to 1 is void.
    """

    z: int
    codes: NDArray[np.uint8]
    fractions: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class PrintMaterial:
    """A material of a print; its code is its index in the list plus 1.

    Attributes
    ----------
    name : str
        Its name in the world.
    key, preview : tuple of 4 int
        Its colours in slices and in pictures, RGBA from 0 to 255.
    density_g_cm3 : float
        Its density in g/cm³.
    channel : str
        The printer's name for it.
    """

    name: str
    key: tuple[int, int, int, int]
    preview: tuple[int, int, int, int]
    density_g_cm3: float
    channel: str


@dataclass(frozen=True)
class PrintInfo:
    """The description of a print, known before its first slice.

    Attributes
    ----------
    size : tuple of 3 int
        The number of voxels of the whole grid along x, y and z.
    pitch_mm : tuple of 3 floats
        The size of a voxel along x, y and z, in mm.
    origin_mm : tuple of 3 floats
        The lowest corner of voxel (0, 0, 0) along x, y and z, in mm.
    slices : tuple of 2 int
        The first slice to print, and one past the last.
    materials : tuple of PrintMaterial
        The materials; code c is the c-th.
    support_code : int
        The code of support material; 0 if there is none.
    printer, title : str
        The names of the printer and of the print.
    memory_bytes : int
        The memory that the print is expected to take, in bytes.
    """

    size: tuple[int, int, int]
    pitch_mm: tuple[float, float, float]
    origin_mm: tuple[float, float, float]
    slices: tuple[int, int]
    materials: tuple[PrintMaterial, ...]
    support_code: int
    printer: str
    title: str
    memory_bytes: int


_THUMBNAIL_SIDE = 320


def smaller(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Returns a slice with rows and columns left out, for a notebook."""
    step = max(1, -(-max(codes.shape) // _THUMBNAIL_SIDE))
    return np.ascontiguousarray(codes[step // 2 :: step, step // 2 :: step])
