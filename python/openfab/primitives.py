# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of a few numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ._given import Real, positive, vector
from .errors import InputError


class Primitive:
    """A shape that needs no file and stands on z = 0.

    See box, sphere, cylinder, plane, cone, torus, capsule, extrusion and revolution, which check sizes.

    Parameters
    ----------
    kind : str
        As a `.fab.json` calls it.
    size : Any
        As a `.fab.json` has it, in mm.
    """

    def __init__(self, kind: str, size: Any) -> None:
        self.kind = kind
        self.size = size

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        return {self.kind: self.size}

    def __repr__(self) -> str:
        return f"Primitive({self.kind!r}, {self.size!r})"


def _lengths(**lengths: Any) -> list[float]:
    return [positive(value, f"`{name}`") for name, value in lengths.items()]


def box(width: Real, depth: Real, height: Real) -> Primitive:
    """Makes a box.

    Its faces have the int attribute `face`: 0 +z, 1 -z, 2 -y, 3 +x, 4 +y, 5 -x.

    Parameters
    ----------
    width, depth, height : float
        Along x, y and z, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("box", _lengths(width=width, depth=depth, height=height))


def sphere(diameter: Real) -> Primitive:
    """Makes a sphere.

    Parameters
    ----------
    diameter : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("sphere", positive(diameter, "`diameter`"))


def cylinder(diameter: Real, height: Real) -> Primitive:
    """Makes a cylinder; `face` is 0 on its top, 1 on its bottom and 2 around it.

    Parameters
    ----------
    diameter, height : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("cylinder", _lengths(diameter=diameter, height=height))


def plane(width: Real, depth: Real) -> Primitive:
    """Makes a sheet closed by its own back, for displacement; `face` is 0 in front, 1 on the back.

    Parameters
    ----------
    width, depth : float
        Along x and y, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("plane", _lengths(width=width, depth=depth))


def cone(low_diameter: Real, high_diameter: Real, height: Real) -> Primitive:
    """Makes a cone, cut off or, with a diameter of 0, pointed; `face` is 0 on its top, 1 on its bottom and 2 around it.

    Parameters
    ----------
    low_diameter, high_diameter, height : float
        In mm; one of the diameters may be 0.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    low, high = positive(low_diameter, "`low_diameter`", 0), positive(high_diameter, "`high_diameter`", 0)
    if low == high == 0:
        raise InputError("`low_diameter` and `high_diameter` are 0 both; one of them is more")
    return Primitive("cone", [low, high, *_lengths(height=height)])


def torus(diameter: Real, section: Real) -> Primitive:
    """Makes a ring of round section.

    Parameters
    ----------
    diameter, section : float
        The diameters of its middle and of its section, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("torus", _lengths(diameter=diameter, section=section))


def capsule(diameter: Real, length: Real) -> Primitive:
    """Makes a cylinder along z with a half ball on each end.

    Parameters
    ----------
    diameter, length : float
        In mm; the length includes the ends.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("capsule", _lengths(diameter=diameter, length=length))


def _corners(polygon: Any) -> list[list[float]]:
    return [vector(corner, "a corner of a polygon", (2,)) for corner in polygon]


def extrusion(polygons: Sequence[Any], height: Real) -> Primitive:
    """Makes what an area sweeps from z = 0 up; `face` is 0 on the top, 1 on the bottom and 2 around.

    Parameters
    ----------
    polygons : sequence of array_like of float, shape (n, 2)
        The corners of each polygon in mm. One that lies within another bounds a hole.
    height : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0.

    Raises
    ------
    InputError
        Where a corner is no pair of numbers, or the height is not more than 0.
    """
    corners = [_corners(polygon) for polygon in polygons]
    return Primitive("extrusion", {"polygons": corners, "height": positive(height, "`height`")})


def revolution(polygon: Any) -> Primitive:
    """Makes what a polygon sweeps around the z axis, with 128 facets around.

    `face` is 0 where it faces straight up, 1 straight down and 2 elsewhere.

    Parameters
    ----------
    polygon : array_like of float, shape (n, 2)
        Corners as (distance from the axis, z), in mm.

    Returns
    -------
    Primitive
        It stands where the polygon says.

    Raises
    ------
    InputError
        Where a corner is no pair of numbers.
    """
    return Primitive("revolution", _corners(polygon))
