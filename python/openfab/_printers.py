# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The printers that are known by name: what `openfab printers` lists."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from . import _core


@dataclass(frozen=True)
class Printer:
    """A printer, as its profile describes it. What is not known is None.

    Attributes
    ----------
    name : str
        What `World(printer=…)` takes.
    maker, model : str
        Empty where it is no machine of a maker.
    pitch_mm : tuple of (float or None)
        The size of a voxel along x, y and z, in mm.
    layers_um : tuple of float
        The thicknesses of a slice that the machine builds, in um.
    build_volume_mm : tuple of (float or None)
        The size of its tray, in mm.
    max_materials : int
        How many materials a print has at most.
    formats : tuple of str
        What its front end takes, the usual one first.
    makes_support : bool
        Whether its front end adds support.
    layer_time_s : float or None
        How long a layer takes, in seconds.
    inks : dict of str to (float or None)
        The maker's inks, with their densities in g/cm³.
    handoff : str
        What the operator does with slices.
    sources : list of dict
        Documents (`document`, `url`), the figures that each `gives`, and how it was `seen`: read, quoted by others,
        or unread.
    unknown : dict of str to str
        What is not known, and why.
    """

    name: str
    maker: str
    model: str
    pitch_mm: tuple[float | None, ...]
    layers_um: tuple[float, ...]
    build_volume_mm: tuple[float | None, ...]
    max_materials: int
    formats: tuple[str, ...]
    makes_support: bool
    layer_time_s: float | None
    inks: dict[str, float | None]
    handoff: str
    sources: list[dict[str, Any]]
    unknown: dict[str, str]


def printers() -> dict[str, Printer]:
    """Return the printers that are known.

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
