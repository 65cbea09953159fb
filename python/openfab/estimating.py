# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Estimates of a print: time, memory, material, money."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from . import _core
from ._given import Real, Whole
from ._options import fields_of
from .printing import Print
from .world import AnyWorld


@dataclass(frozen=True)
class MaterialEstimate:
    """The amount of a material in a print.

    Attributes
    ----------
    name : str
        Its name in the world.
    ml, g : float
        The amount in the part, in millilitres and grams.
    waste_ml : float
        The additional waste of the machine's passes, in millilitres; 0 if the printer's profile has no `cost`.
    money : float or None
        The price of both, in `Estimate.currency`; None if it is unknown.
    """

    name: str
    ml: float
    g: float
    waste_ml: float
    money: float | None


@dataclass(frozen=True)
class Estimate:
    """An estimate of a print; `estimate` makes it.

    Attributes
    ----------
    voxels : int
        The number of voxels of the whole grid.
    slices : int
        The number of slices.
    memory_bytes : int
        The memory that the print will take on this machine, in bytes.
    seconds : float
        The computing time of this machine, in seconds.
    print_seconds : float or None
        The time of the printer, in seconds; None if its profile has none.
    keeps_up : bool or None
        Whether the printer never has to wait for this machine; None if the printer's time is unknown.
    money : float or None
        The price of all materials that have one, including waste; None if the profile has no `cost`.
    currency : str or None
        The currency of all prices.
    passes : int or None
        The number of passes of the head over the tray.
    materials : tuple of MaterialEstimate
        The materials of the print, in the order of their codes.
    warnings : tuple of str
        The warnings that the print would give.
    notes : tuple of str
        What may well be meant: places of objects that get no material.
    """

    voxels: int
    slices: int
    memory_bytes: int
    seconds: float
    print_seconds: float | None
    keeps_up: bool | None
    money: float | None
    currency: str | None
    passes: int | None
    materials: tuple[MaterialEstimate, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> MaterialEstimate:
        """Returns the material with that name."""
        for one in self.materials:
            if one.name == name:
                return one
        raise KeyError(name)


def estimate(
    world: AnyWorld,
    *,
    printer: str | os.PathLike[str] | None = None,
    process: str | os.PathLike[str] | None = None,
    voxel: Real | str | Sequence[Real] | None = None,
    dpi: Real | str | Sequence[Real] | None = None,
    layer: Real | str | None = None,
    draft: Whole | None = None,
    slices: Sequence[Whole] | None = None,
    z: Sequence[Real | str] | None = None,
    uniforms: Mapping[str, Any] | None = None,
    support: bool | str | None = None,
    crop: Literal["parts", "tray"] | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
) -> Estimate:
    """Estimates a print without printing, as `openfab print --estimate` does.

    Amounts come from a coarse print, and are within a few per cent if parts are thicker than a few of its voxels. Time
    comes from a sample of slices.

    Parameters
    ----------
    world : World or FileWorld
        The world to estimate.
    printer : str or path, optional
        The printer to use instead of the world's.
    process : str or path, optional
        A file whose items replace those of the printer's `process`, such as its `cost`.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm: one, or three for x, y and z. Default: that of the printer.
    dpi : float, str or sequence of 2 floats, optional
        The resolution along x and y, in dots per inch.
    layer : float or str, optional
        The height of a slice in mm.
    draft : int, optional
        How many times larger than the printer's the voxels are; at least 1.
    slices : sequence of 2 int, optional
        The first slice to print, and one past the last.
    z : sequence of 2 floats or str, optional
        The range of slices as heights, in mm.
    uniforms : mapping of str to Any, optional
        Values to use instead, such as `{"ball.skin": 1.5}`.
    support : bool or str, optional
        Whether to print support material, or the name of the material.
    crop : {"parts", "tray"}, optional
        The area that slices show: the parts, or the whole tray.
    memory : int or str, optional
        The memory budget, in bytes.
    threads : int, optional
        At least 1. Default: one per processor.

    Returns
    -------
    Estimate
        Time and memory, and amount and price of each material.

    Raises
    ------
    InputError
        If an argument or the world is wrong.
    CompileError
        If a fablet does not compile.

    Examples
    --------
    >>> openfab.estimate(world, process="machine.json").money         # doctest: +SKIP
    """
    fields = fields_of(
        printer=printer, process=process, voxel=voxel, dpi=dpi, layer=layer, draft=draft, slices=slices, z=z,
        support=support, crop=crop, memory=memory, threads=threads,
    )
    with Print(world, fields, _core.Target.ESTIMATE, uniforms=uniforms) as running:
        running._end()
    return _estimate_of(running.statistics)


def _estimate_of(found: dict[str, Any]) -> Estimate:
    cost = found.get("cost", {})
    lines = cost.get("by_material", {})
    return Estimate(
        voxels=found["voxels_total"],
        slices=found["slices"],
        memory_bytes=found["memory_bytes"],
        seconds=found["seconds_total"],
        print_seconds=cost.get("seconds", found.get("print_seconds")),
        keeps_up=found.get("keeps_up"),
        money=cost.get("money"),
        currency=cost.get("currency"),
        passes=cost.get("passes"),
        materials=tuple(
            MaterialEstimate(
                name, ml, found["g_by_material"][name], lines.get(name, {}).get("waste_ml", 0.0),
                lines.get(name, {}).get("money"),
            )
            for name, ml in found["ml_by_material"].items()
        ),
        warnings=tuple(found["warnings"]),
        notes=tuple(found["notes"]),
    )
