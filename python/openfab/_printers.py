# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The known printers, as `openfab printers` lists them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from . import _core
from ._given import choice, short
from .errors import InputError


@dataclass(frozen=True)
class Printer:
    """A printer, as its profile describes it. Unknown values are None.

    Attributes
    ----------
    name : str
        The name for `World(printer=…)`.
    maker, model : str
        Empty for a generic printer.
    pitch_mm : tuple of (float or None)
        The size of a voxel along x, y and z, in mm.
    layers_um : tuple of float
        The slice thicknesses that the machine can build, in um.
    build_volume_mm : tuple of (float or None)
        The size of its tray, in mm.
    max_materials : int
        The largest number of materials in a print.
    formats : tuple of str
        The formats that its front end accepts, the usual one first.
    mesh_colors : bool
        Whether it chooses inks by the colours of a mesh, so that 3MF files have those of mixtures.
    makes_support : bool
        Whether its front end adds support.
    layer_time_s : float or None
        The time per layer, in seconds.
    inks : dict of str to (float or None)
        The maker's inks, with their densities in g/cm³.
    handoff : str
        Instructions for the operator: what to do with the slices.
    sources : list of dict
        Documents (`document`, `url`), the figures that each `gives`, and how each was `seen`: read, quoted by others,
        or unread.
    unknown : dict of str to str
        The unknown figures, each with the reason.
    """

    name: str
    maker: str
    model: str
    pitch_mm: tuple[float | None, ...]
    layers_um: tuple[float, ...]
    build_volume_mm: tuple[float | None, ...]
    max_materials: int
    formats: tuple[str, ...]
    mesh_colors: bool
    makes_support: bool
    layer_time_s: float | None
    inks: dict[str, float | None]
    handoff: str
    sources: list[dict[str, Any]]
    unknown: dict[str, str]


def printers() -> dict[str, Printer]:
    """Returns the known printers.

    Returns
    -------
    dict of str to Printer
        By name.

    Examples
    --------
    >>> printers()["j850"].pitch_mm[2]
    0.027
    """
    known = {}
    for one in json.loads(_core.printers()):
        one.pop("native_format")
        for key in ("pitch_mm", "layers_um", "build_volume_mm", "formats"):
            one[key] = tuple(one[key])
        one["inks"] = {ink["name"]: ink["density_g_cm3"] for ink in one["inks"]}
        known[one["name"]] = Printer(**one)
    return known


@cache
def _names() -> tuple[str, ...]:
    return tuple(one["name"] for one in json.loads(_core.printers()))


def known_printer(value: Any, what: str) -> str:
    """Returns the name of a known printer, or the path of a profile that exists."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"{what} cannot be {short(value)}; it is the name of a printer, or a path")
    name = os.fsdecode(value)
    if name.endswith(".json"):
        if not Path(name).is_file():
            raise InputError(f"{what} cannot be {short(name)}; there is no such file")
        return name
    return choice(name, what, _names())
