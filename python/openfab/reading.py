# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Reads written prints as arrays: slices, boxes or the whole."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._given import Real, Whole, number, short, vector, whole
from .errors import InputError, raise_error
from .sampling import Samples
from .slices import PrintInfo, PrintMaterial, Slice, smaller

_MOST_THUMBNAILS = 24
_MEMORY = 1_500_000_000


class _Source(Protocol):
    """A source of slices."""

    info: dict[str, Any]
    whole_slices: int
    hash: str | None

    def read(self, z: int, window: Sequence[int]) -> NDArray[np.uint8]: ...


class _Kept:
    """An .ofr file, or a folder of slices."""

    def __init__(self, file: _core.PrintFile) -> None:
        self._file = file
        self.info: dict[str, Any] = file.info
        self.whole_slices: int = file.whole_slices
        self.hash: str | None = file.hash

    def read(self, z: int, window: Sequence[int]) -> NDArray[np.uint8]:
        codes = self._file.read(z, window)
        if isinstance(codes, _core.Error):
            raise_error(codes)
        return codes


class _Array:
    """A memory-mapped .npy file."""

    def __init__(self, array: NDArray[np.uint8], info: dict[str, Any], said: dict[str, Any]) -> None:
        self._array = array
        self.info = info
        self.whole_slices = len(array)
        self.hash = said.get("hash") if said.get("complete") else None

    def read(self, z: int, window: Sequence[int]) -> NDArray[np.uint8]:
        x0, x1, y0, y1 = window
        return self._array[z - self.info["slices"][0], y0:y1, x0:x1]


@dataclass(frozen=True)
class VoxelBox:
    """The voxels of a box; `Voxels.box` reads them.

    Attributes
    ----------
    codes : ndarray of uint8, shape (z, y, x)
        0 is void, c is the c-th material.
    origin_mm : tuple of float
        The lowest corner of its first voxel along x, y and z, in mm, in the space of the print.
    pitch_mm : tuple of float
        The size of a voxel along x, y and z, in mm.
    materials : tuple of PrintMaterial
        The materials of the codes.
    """

    codes: NDArray[np.uint8]
    origin_mm: tuple[float, float, float]
    pitch_mm: tuple[float, float, float]
    materials: tuple[PrintMaterial, ...]


class Voxels:
    """A written print as an array [z][y][x] of codes; `read` makes it.

    Indices and slices as in numpy read only the voxels that they select, though each slice is unpacked whole.
    `numpy.asarray` reads everything. Index 0 of the first axis is the first slice in the file, `info.slices[0]`.

    Attributes
    ----------
    path : pathlib.Path
        The file or folder.
    info : PrintInfo
        The grid, pitch and origin (mm), and the materials. `memory_bytes` is 0.
    shape : tuple of int
        The numbers of slices, rows and columns: (z, y, x). A print that was cut short has fewer slices.
    dtype : numpy.dtype
        uint8: 0 is void, c is the c-th material.
    hash : str or None
        The hash of the print, as shown by `openfab info`; None if the print is not complete.

    Examples
    --------
    >>> ball = openfab.read("ball.ofr")                    # doctest: +SKIP
    >>> ball[10], ball[:, ::2, 5], (ball[20:30] == 1).sum()   # doctest: +SKIP
    """

    dtype = np.dtype(np.uint8)
    ndim = 3

    def __init__(self, path: Path, source: _Source) -> None:
        self._source = source
        self.path = path
        data = dict(source.info)
        data["materials"] = tuple(PrintMaterial(**one) for one in data["materials"])
        self.info = PrintInfo(**data)
        self.shape: tuple[int, int, int] = (source.whole_slices, self.info.size[1], self.info.size[0])
        self.hash = source.hash

    @property
    def is_complete(self) -> bool:
        """Whether the print is complete, with all of its slices."""
        return self.hash is not None

    @property
    def size(self) -> int:
        """The number of its voxels."""
        return self.shape[0] * self.shape[1] * self.shape[2]

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Slice]:
        """Yields the slices from the lowest up, like a print; any number of times."""
        for place in range(self.shape[0]):
            yield Slice(self.info.slices[0] + place, self[place])

    def __getitem__(self, key: Any) -> NDArray[np.uint8]:
        rows = self._places(key)
        taken = [one if isinstance(one, range) else range(one, one + 1) for one in rows]
        layers, spans = taken[0], [_span(one) for one in taken[1:]]
        (y0, y1), (x0, x1) = spans
        steps = tuple(_within(one, low) for one, (low, _) in zip(taken[1:], spans))
        out = np.empty((len(layers), len(taken[1]), len(taken[2])), np.uint8)
        if out.size:
            for place, z in enumerate(layers):
                out[place] = self._source.read(self.info.slices[0] + z, (x0, x1, y0, y1))[steps]
        return out[tuple(0 if isinstance(one, int) else slice(None) for one in rows)]

    def _places(self, key: Any) -> list[int | range]:
        """Returns the selected positions along each axis."""
        keys = list(key) if isinstance(key, tuple) else [key]
        dots = [place for place, one in enumerate(keys) if one is Ellipsis]
        if len(dots) > 1 or len(keys) - len(dots) > 3:
            raise InputError(f"{short(key)} names more than the three axes (z, y, x) of a print")
        at = dots[0] if dots else len(keys)
        keys[at : at + len(dots)] = [slice(None)] * (3 - (len(keys) - len(dots)))
        places: list[int | range] = []
        for one, count, axis in zip(keys, self.shape, "zyx"):
            if isinstance(one, slice):
                try:
                    places.append(range(*one.indices(count)))
                except (TypeError, ValueError) as error:
                    raise InputError(f"{short(one)} along {axis} is no slice: {error}") from error
                continue
            if isinstance(one, (list, np.ndarray)) and np.ndim(one) > 0:
                raise InputError(
                    f"{short(one)} cannot be an index along {axis}; it is a whole number, a slice or `...`",
                    help="take numpy.asarray of the print, or of a part of it, for other indices",
                )
            place = whole(one, f"an index along {axis}")
            if not -count <= place < count:
                raise IndexError(f"index {place} along {axis} is beyond the {count} that {self.path.name} has")
            places.append(place % count)
        return places

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("the voxels of a file are read, so that an array of them is a copy")
        return self[...].astype(dtype or self.dtype, copy=False)

    def box(self, low: Sequence[Real], high: Sequence[Real]) -> VoxelBox:
        """Reads the voxels of a box in millimetres, across slices.

        Parameters
        ----------
        low, high : sequence of 3 floats
            The lowest and the highest corner along x, y and z, in mm, in the space of the print. The box is rounded out to
            whole voxels.

        Returns
        -------
        VoxelBox
            The codes, of shape (z, y, x), and their position.

        Raises
        ------
        InputError
            If the box is invalid, or reaches beyond the voxels in the file.
        """
        ends = vector(low, "`low`"), vector(high, "`high`")
        if not all(a < b for a, b in zip(*ends)):
            raise InputError(f"the box from {short(low)} to {short(high)} is none; give its lowest and its highest corner")
        first = self.info.slices[0]
        has = ((0, self.shape[2]), (0, self.shape[1]), (first, first + self.shape[0]))
        begin, end = [], []
        for axis, origin, pitch, (least, most), a, b in zip("xyz", self.info.origin_mm, self.info.pitch_mm, has, *ends):
            # A corner within a millionth of a voxel is meant to be on the grid.
            i, j = int(np.floor((a - origin) / pitch + 1e-6)), int(np.ceil((b - origin) / pitch - 1e-6))
            if i < least or j > most:
                edges = origin + least * pitch, origin + most * pitch
                raise InputError(
                    f"the box from {short(low)} to {short(high)} reaches beyond the voxels, which are from {edges[0]:.6g} "
                    f"to {edges[1]:.6g} mm along {axis}"
                )
            begin.append(i)
            end.append(j)
        codes = self[begin[2] - first : end[2] - first, begin[1] : end[1], begin[0] : end[0]]
        x, y, z = (o + i * p for o, i, p in zip(self.info.origin_mm, begin, self.info.pitch_mm))
        return VoxelBox(codes, (x, y, z), self.info.pitch_mm, self.info.materials)

    @property
    def thumbnails(self) -> list[tuple[int, NDArray[np.uint8]]]:
        """Some slices at a reduced size, for notebooks."""
        step = max(1, -(-len(self) // _MOST_THUMBNAILS))
        first = self.info.slices[0]
        return [(first + place, smaller(self[place])) for place in range(0, len(self), step)]

    def __reduce__(self) -> Any:
        return read, (self.path,)

    def __repr__(self) -> str:
        state = "" if self.is_complete else ", not complete"
        return f"Voxels({str(self.path)!r}, shape={self.shape}{state})"


def _span(places: range) -> tuple[int, int]:
    """Returns the lowest position, and one past the highest."""
    return (min(places[0], places[-1]), max(places[0], places[-1]) + 1) if places else (0, 0)


def _within(places: range, low: int) -> slice:
    """Returns the slice that selects a range in an array that begins at the lowest of its positions."""
    if not places:
        return slice(0, 0)
    stop = places[-1] - low + (1 if places.step > 0 else -1)
    return slice(places[0] - low, stop if stop >= 0 else None, places.step)


def read(file: str | os.PathLike[str], *, memory: Whole = _MEMORY) -> Voxels | Samples:
    """Opens a written print. Only the header is read at first; slices are read on demand.

    Parameters
    ----------
    file : str or path
        An .ofr file, a folder of slices (PNG or BMP), a .zarr store, or an .npy file with its .npy.json. If an .ofr file is cut short or
        still being written, its complete slices are read.
    memory : int, optional
        The memory budget in bytes; a file with slices larger than a quarter of it is refused.

    Returns
    -------
    Voxels or Samples
        The codes of materials, [z][y][x]; for an output of `--fractions`, the mixtures, [z][y][x][material], mapped from
        the file.

    Raises
    ------
    InputError
        If OpenFab has not written the file, or it is damaged. A damaged slice raises when it is read.
    """
    path = Path(os.fsdecode(file)).absolute()
    if path.suffix == ".npy" and not path.is_dir():
        return _read_array(path)
    found = _core.open_print_file(str(path), int(number(memory, "`memory`")))
    if isinstance(found, _core.Error):
        raise_error(found)
    return Voxels(path, _Kept(found))


def _read_array(path: Path) -> Voxels | Samples:
    beside = path.with_name(path.name + ".json")
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except OSError as error:
        raise InputError(f"cannot open `{path}`: {error.strerror or error}", file=str(path)) from error
    except ValueError as error:
        raise InputError(f"{path}: it is no array of numpy: {error}", file=str(path)) from error
    try:
        said = json.loads(beside.read_text(encoding="utf-8"))
        materials = [_material(one) for one in said["materials"]]
        pitch, origin = (tuple(vector(said[key], f"`{key}`")) for key in ("pitch_mm", "origin_mm"))
    except OSError as error:
        raise InputError(
            f"cannot open `{beside}`: {error.strerror}", help="it says what the array is, and is written beside it",
            file=str(beside),
        ) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{beside}: it is not what OpenFab writes: {error!r}", file=str(beside)) from error
    if array.ndim == 4 and array.dtype == np.float32 and array.shape[3] <= len(materials):
        made = tuple(PrintMaterial(**one) for one in materials[: array.shape[3]])
        return Samples(array, cast(Any, origin), cast(Any, pitch), made)
    if array.ndim != 3 or array.dtype != np.uint8:
        raise InputError(f"{path}: it is {short(array)}, which is neither codes nor fractions", file=str(path))
    first = int(said.get("first_slice_z", 0))
    info = {
        "size": (array.shape[2], array.shape[1], first + len(array)), "pitch_mm": pitch, "origin_mm": origin,
        "slices": (first, first + len(array)), "materials": materials, "support_code": 0,
        "printer": str(said.get("printer", "")), "title": str(said.get("title", "")), "memory_bytes": 0,
    }
    return Voxels(path, _Array(array, info, said))


def _material(said: dict[str, Any]) -> dict[str, Any]:
    color = tuple(bytes.fromhex(said["color"].removeprefix("#")))
    return {
        "name": str(said["name"]), "key": color, "preview": color, "density_g_cm3": float(said.get("density_g_cm3", 0)),
        "channel": str(said.get("channel", "")),
    }
