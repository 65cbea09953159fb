# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Beams: nodes joined by struts, for trusses, foams and trees."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _files
from ._given import array, floats, integers, short
from .errors import InputError


class Beams:
    """A solid of struts between nodes: the union of round cones. `beams` makes it.

    The arrays are copied; those of the beams are read-only, since prints read them at any time.

    Parameters
    ----------
    nodes : array_like of float, shape (n, 3)
        Positions in mm.
    struts : array_like of int, shape (m, 2)
        The two nodes of each strut; the same node twice makes a ball.
    radii : array_like of float, shape (), (n,) or (m, 2)
        Radii in mm: one for all, one for each node, or one for each end of a strut.
    attributes : mapping of str to array_like, shape (n,), (n, 2 to 4) or (m,), optional
        Attributes that fablets read under these names: floats at nodes, (n,) or (n, 2 to 4), which are interpolated;
        integers of struts, (m,).

    Raises
    ------
    InputError
        If an array has the wrong shape, a value is not finite, or a strut has an unknown node or no inside.
    """

    def __init__(
        self, nodes: ArrayLike, struts: ArrayLike, radii: ArrayLike, attributes: Mapping[str, ArrayLike] | None = None
    ) -> None:
        self._nodes: NDArray[np.float64] = floats(nodes, "`nodes`", np.float64)
        self._struts = integers(struts, "`struts`")
        self._radii: NDArray[np.float64] = floats(radii, "`radii`", np.float64)
        for one, what, width in ((self._nodes, "nodes", 3), (self._struts, "struts", 2)):
            if one.ndim != 2 or one.shape[1] != width:
                letter = "n" if width == 3 else "m"
                raise InputError(f"`{what}` has the shape {one.shape}; it should be ({letter}, {width})")
        count, joined = len(self._nodes), len(self._struts)
        if joined == 0:
            raise InputError("`struts` is empty; there is nothing to print")
        odd = np.argwhere((self._struts < 0) | (self._struts >= count))
        if len(odd):
            strut, end = odd[0]
            raise InputError(
                f"strut {strut} has the node {self._struts[strut, end]}; there are {count}, from 0 to {count - 1}"
            )
        if self._radii.shape not in ((), (1,), (count,), (joined, 2)):
            raise InputError(
                f"`radii` has the shape {self._radii.shape}; it should be one number, ({count},) for the nodes, or "
                f"({joined}, 2) for the ends of the struts"
            )
        if (self._radii < 0).any():
            raise InputError(f"a radius is {self._radii.min()}; it is 0 or more")
        ends = self._radii.reshape(-1)[self._struts] if self._radii.shape == (count,) else self._radii
        empty = np.flatnonzero(np.broadcast_to(ends, (joined, 2)).max(axis=1) == 0)
        if len(empty):
            raise InputError(f"strut {empty[0]} has the radius 0 at both ends, so it has no inside")
        self._attributes = {
            _name(name): _values(name, values, count, joined) for name, values in (attributes or {}).items()
        }
        for array in self._arrays().values():
            array.setflags(write=False)
        self._own_file()

    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {"nodes": self._nodes, "struts": self._struts, "radii": self._radii, **self._attributes}

    def _own_file(self) -> None:
        arrays = self._arrays()
        self._file = _files.OwnedFile(self, "beams", ".npz", lambda path: _write(path, arrays))

    @property
    def nodes(self) -> NDArray[np.float64]:
        """The positions of the nodes in mm, of shape (n, 3)."""
        return self._nodes

    @property
    def struts(self) -> NDArray[np.int32]:
        """The nodes of the struts, of shape (m, 2)."""
        return self._struts

    @property
    def radii(self) -> NDArray[np.float64]:
        """The radii in mm, as they were given."""
        return self._radii

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key != "_file"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for array in self._arrays().values():
            array.setflags(write=False)
        self._own_file()

    def _spec(self) -> dict[str, Any]:
        path = self._file.path()
        return {"beams": str(path)}

    def __repr__(self) -> str:
        return f"Beams({len(self._nodes)} nodes, {len(self._struts)} struts)"


def beams(
    nodes: ArrayLike, struts: ArrayLike, radii: ArrayLike, attributes: Mapping[str, ArrayLike] | None = None
) -> Beams:
    """Makes a solid of struts between nodes: the union of round cones, with balls at the nodes.

    Parameters
    ----------
    nodes : array_like of float, shape (n, 3)
        Positions in mm.
    struts : array_like of int, shape (m, 2)
        The two nodes of each strut; the same node twice makes a ball.
    radii : array_like of float, shape (), (n,) or (m, 2)
        Radii in mm: one for all, one for each node, or one for each end of a strut.
    attributes : mapping of str to array_like, shape (n,), (n, 2 to 4) or (m,), optional
        Attributes that fablets read with `@nearest`: floats at nodes, (n,) or (n, 2 to 4), which are interpolated; integers
        of struts, (m,).

    Returns
    -------
    Beams
        Usable in place of a mesh.

    Raises
    ------
    InputError
        If an array has the wrong shape, a value is not finite, or a strut has an unknown node or no inside.
    """
    return Beams(nodes, struts, radii, attributes)


def _name(name: str) -> str:
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name, re.ASCII):
        raise InputError(
            f"an attribute of beams cannot be called {short(name)}; names are those of fablets: letters, digits and `_`"
        )
    if name in ("nodes", "struts", "radii"):
        raise InputError(f"an attribute of beams cannot be called `{name}`, which is taken; rename it")
    return name


def _values(name: str, values: ArrayLike, count: int, joined: int) -> NDArray[Any]:
    what = f"attribute `{name}`"
    if array(values, what).dtype.kind != "f":
        whole = integers(values, what)
        if whole.shape != (joined,):
            raise InputError(
                f"{what} has the shape {whole.shape} of integers, which are of struts; it should be ({joined},), or floats "
                f"({count},) of nodes"
            )
        return whole
    found = floats(values, what)
    if found.shape != (count,) and not (found.ndim == 2 and len(found) == count and 1 <= found.shape[1] <= 4):
        raise InputError(
            f"{what} has the shape {found.shape}; it should be ({count},) or ({count}, 2 to 4), floats of nodes, or integers "
            f"({joined},) of struts"
        )
    return found


def _write(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    # Like numpy.savez, which cannot take an array with the name `file`.
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.ascontiguousarray(values), allow_pickle=False)
