# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Primitive shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._given import Real, positive, vector
from .errors import InputError


class Primitive:
    """A shape that needs no file and stands on z = 0.

    Use box, sphere, cylinder, plane, cone, torus, capsule, extrusion and revolution, which check sizes.

    Parameters
    ----------
    kind : str
        Its key in a `.fab.json`.
    size : Any
        Its value in a `.fab.json`, in mm.
    """

    def __init__(self, kind: str, size: Any) -> None:
        self.kind = kind
        self.size = size

    def _spec(self) -> dict[str, Any]:
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
        The sizes along x, y and z, in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("box", _lengths(width=width, depth=depth, height=height))


def sphere(diameter: Real) -> Primitive:
    """Makes a sphere.

    Parameters
    ----------
    diameter : float
        The diameter in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("sphere", positive(diameter, "`diameter`"))


def cylinder(diameter: Real, height: Real) -> Primitive:
    """Makes a cylinder; `face` is 0 on the top, 1 on the bottom and 2 on the side.

    Parameters
    ----------
    diameter, height : float
        The sizes in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("cylinder", _lengths(diameter=diameter, height=height))


def plane(width: Real, depth: Real) -> Primitive:
    """Makes a sheet with a back of its own, for displacement; `face` is 0 on the front and 1 on the back.

    Parameters
    ----------
    width, depth : float
        The sizes along x and y, in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("plane", _lengths(width=width, depth=depth))


def cone(low_diameter: Real, high_diameter: Real, height: Real) -> Primitive:
    """Makes a truncated cone, or a pointed one with a diameter of 0; `face` is 0 on the top, 1 on the bottom, 2 on the side.

    Parameters
    ----------
    low_diameter, high_diameter, height : float
        The sizes in mm; one of the diameters may be 0.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    low, high = positive(low_diameter, "`low_diameter`", 0), positive(high_diameter, "`high_diameter`", 0)
    if low == high == 0:
        raise InputError("`low_diameter` and `high_diameter` are 0 both; one of them is more")
    return Primitive("cone", [low, high, *_lengths(height=height)])


def torus(diameter: Real, section: Real) -> Primitive:
    """Makes a ring with a round section.

    Parameters
    ----------
    diameter, section : float
        The diameters of its centre line and of its section, in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("torus", _lengths(diameter=diameter, section=section))


def capsule(diameter: Real, length: Real) -> Primitive:
    """Makes a cylinder along z with a hemisphere on each end.

    Parameters
    ----------
    diameter, length : float
        The sizes in mm; the length includes the hemispheres.

    Returns
    -------
    Primitive
        A shape that stands on z = 0, centred on the z axis.

    Raises
    ------
    InputError
        If a size is not a number greater than 0.
    """
    return Primitive("capsule", _lengths(diameter=diameter, length=length))


def _corners(polygon: Any) -> list[list[float]]:
    return [vector(corner, "a corner of a polygon", (2,)) for corner in polygon]


def extrusion(polygons: Sequence[Any], height: Real) -> Primitive:
    """Extrudes an area up from z = 0; `face` is 0 on the top, 1 on the bottom and 2 on the sides.

    Parameters
    ----------
    polygons : sequence of array_like of float, shape (n, 2)
        The corners of each polygon in mm. A polygon inside another one bounds a hole.
    height : float
        The height in mm.

    Returns
    -------
    Primitive
        A shape that stands on z = 0.

    Raises
    ------
    InputError
        If a corner is not a pair of numbers, or the height is not greater than 0.
    """
    corners = [_corners(polygon) for polygon in polygons]
    return Primitive("extrusion", {"polygons": corners, "height": positive(height, "`height`")})


def revolution(polygon: Any) -> Primitive:
    """Revolves a polygon around the z axis, with 128 facets.

    `face` is 0 where the surface faces straight up, 1 where it faces straight down, and 2 elsewhere.

    Parameters
    ----------
    polygon : array_like of float, shape (n, 2)
        The corners as (distance from the axis, z), in mm.

    Returns
    -------
    Primitive
        A shape at the height given by the polygon.

    Raises
    ------
    InputError
        If a corner is not a pair of numbers.
    """
    return Primitive("revolution", _corners(polygon))
