# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The answers of generators: beams, meshes, placements, and boxes with more of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._given import floats, integers, positive, short
from .errors import InputError

ROOT = "root"
"""The key of the first question."""

_LONGEST_KEY = 63


class Bound(NamedTuple):
    """A question to a generator.

    Attributes
    ----------
    key : str
        The key given to `more`; `procedural.ROOT` for the first question.
    low, high : tuple of 3 floats
        Two corners of the box in question, in mm: the world's at first, then that of `more`.
    """

    key: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


class Lines(NamedTuple):
    """An item that a generator yields; `beam`, `beams`, `mesh`, `place` and `more` make it.

    Attributes
    ----------
    word : str
        The first word of its lines.
    numbers : numpy.ndarray
        The floats of each line.
    values : mapping of str to Any
        The attributes.
    more_lines : str
        Lines that follow.
    name : str
        The word after the first.
    """

    word: str
    numbers: Any
    values: Mapping[str, Any]
    more_lines: str = ""
    name: str = ""


def _three(value: Any, what: str) -> Any:
    found = floats(value, what, np.float64)
    if found.shape != (3,):
        raise InputError(f"{what} has the shape {found.shape}; it should be three numbers")
    return found


def beam(start: ArrayLike, end: ArrayLike, radius: Any, *, flat: bool = False, **values: Any) -> Lines:
    """Makes a beam: a round cone with balls at its ends, or with flat ends.

    Parameters
    ----------
    start, end : array_like of float, shape (3,)
        Its ends, in mm.
    radius : float or two floats
        Its radius, or one for each end, in mm.
    flat : bool, optional
        Whether its ends are flat, without balls.
    **values
        Attributes: one value each, or for floats a pair of values at the two ends.

    Returns
    -------
    Lines
        A value to yield.

    Raises
    ------
    InputError
        If a value is not a number.
    """
    radii = np.broadcast_to(floats(radius, "`radius`", np.float64), (2,))
    numbers = np.concatenate([_three(start, "`start`"), _three(end, "`end`"), radii])
    return Lines("flat" if flat else "beam", numbers[None], {name: [value] for name, value in values.items()})


def beams(starts: ArrayLike, ends: ArrayLike, radii: ArrayLike, *, flat: bool = False, **values: Any) -> Lines:
    """Makes many beams from arrays, which is faster than one by one.

    Parameters
    ----------
    starts, ends : array_like of float, shape (n, 3)
        Their ends, in mm.
    radii : array_like of float, shape (), (n,) or (n, 2)
        Radii in mm: one for all, one per beam, or one for each end of a beam.
    flat : bool, optional
        Whether their ends are flat.
    **values
        Attributes: arrays of shape (n,) or (n, components); for floats at both ends, (n, 2) or (n, 2, components).

    Returns
    -------
    Lines
        A value to yield.

    Raises
    ------
    InputError
        If shapes do not match, or a value is not a number.
    """
    first, second = floats(starts, "`starts`", np.float64), floats(ends, "`ends`", np.float64)
    if first.ndim != 2 or first.shape[1] != 3 or first.shape != second.shape:
        raise InputError(f"`starts` and `ends` have the shapes {first.shape} and {second.shape}; both should be (n, 3)")
    both = floats(radii, "`radii`", np.float64)
    if both.ndim == 1:
        both = both[:, None]
    try:
        both = np.broadcast_to(both, (len(first), 2))
    except ValueError as error:
        raise InputError(f"`radii` has the shape {both.shape}; it should be ({len(first)},) or ({len(first)}, 2)") from error
    return Lines("flat" if flat else "beam", np.concatenate([first, second, both], axis=1), values)


def mesh(vertices: ArrayLike, triangles: ArrayLike, **values: Any) -> Lines:
    """Makes a closed mesh, its triangles counter-clockwise seen from outside.

    Parameters
    ----------
    vertices : array_like of float, shape (n, 3)
        Positions in mm.
    triangles : array_like of int, shape (m, 3)
        Indices of vertices, from 0.
    **values
        Attributes of the whole.

    Returns
    -------
    Lines
        A value to yield.

    Raises
    ------
    InputError
        If an array has the wrong shape, or a value is not a number.
    """
    points, corners = floats(vertices, "`vertices`", np.float64), integers(triangles, "`triangles`")
    for found, what in ((points, "`vertices`"), (corners, "`triangles`")):
        if found.ndim != 2 or found.shape[1] != 3:
            raise InputError(f"{what} has the shape {found.shape}; it should be (n, 3)")
    text = "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points.tolist())
    text += "".join(f"{a} {b} {c}\n" for a, b, c in corners.tolist())
    counts = np.array([[len(points), len(corners)]])
    return Lines("mesh", counts, {name: [value] for name, value in values.items()}, text)


def place(name: str, at: ArrayLike, axes: ArrayLike | None = None, *, scale: float = 1, **values: Any) -> Lines:
    """Places a copy of an object.

    Parameters
    ----------
    name : str
        The object's name in the world, which the generator lists in `places`.
    at : array_like of float, shape (3,)
        The position of its origin, in mm.
    axes : array_like of float, shape (3, 3), optional
        Rows: the directions of its x, y and z; perpendicular, and of one length, which scales the copy.
    scale : float, optional
        A scale factor.
    **values
        Attributes of the whole.

    Returns
    -------
    Lines
        A value to yield.

    Raises
    ------
    InputError
        If a value is not a number.
    """
    if not isinstance(name, str) or not name or any(c.isspace() or c == "," for c in name):
        raise InputError(f"{short(name)} is no word; an object that is placed by a program has a name without blanks")
    rows = np.eye(3) if axes is None else floats(axes, "`axes`", np.float64)
    if rows.shape != (3, 3):
        raise InputError(f"`axes` has the shape {rows.shape}; it should be (3, 3), a row for each axis")
    numbers = np.concatenate([_three(at, "`at`"), (rows * positive(scale, "`scale`")).ravel()])
    return Lines("place", numbers[None], {key: [value] for key, value in values.items()}, name=name)


def more(key: Any, low: ArrayLike, high: ArrayLike) -> Lines:
    """Announces more geometry in a box; the generator is asked for it when a print comes near.

    Parameters
    ----------
    key : str or int
        A word of up to 63 bytes, without blanks, which names the box in the question to the generator.
    low, high : array_like of float, shape (3,)
        Two corners of a box that contains all of it, in mm.

    Returns
    -------
    Lines
        A value to yield.

    Raises
    ------
    InputError
        If the key is not such a word, or a value is not a number.
    """
    word = str(key)
    if not word or len(word.encode()) > _LONGEST_KEY or any(c.isspace() or c in ",\0" for c in word):
        raise InputError(f"the key {short(word)} is no word of up to {_LONGEST_KEY} bytes, without blanks and commas")
    numbers = np.concatenate([_three(low, "`low`"), _three(high, "`high`")])
    return Lines("more", numbers[None], {}, name=word)
