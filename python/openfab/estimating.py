# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What a print will take: time, memory, material, money."""

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
    """How much of a material a print takes.

    Attributes
    ----------
    name : str
        What the world calls it.
    ml, g : float
        What lands in the part, in millilitres and grams.
    waste_ml : float
        What the machine's passes waste besides, in millilitres; 0 where the printer's profile has no `cost`.
    money : float or None
        The price of both, in `Estimate.currency`; None where none is known.
    """

    name: str
    ml: float
    g: float
    waste_ml: float
    money: float | None


@dataclass(frozen=True)
class Estimate:
    """What a print will take; `estimate` makes it.

    Attributes
    ----------
    voxels : int
        Those of the whole grid.
    slices : int
        How many there are.
    memory_bytes : int
        What the print will take here, in bytes.
    seconds : float
        How long this machine will compute, in seconds.
    print_seconds : float or None
        How long the printer will take, in seconds; None where its profile has no time.
    keeps_up : bool or None
        Whether the printer would never wait for this machine; None where its time is not known.
    money : float or None
        The price of all materials that have one, and of their waste; None where the profile has no `cost`.
    currency : str or None
        Of all money.
    passes : int or None
        How often the head goes over the tray.
    materials : tuple of MaterialEstimate
        Those of the print, in the order of their codes.
    warnings : tuple of str
        What the print would warn of.
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

    def __getitem__(self, name: str) -> MaterialEstimate:
        """Returns the material of that name."""
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
    """Tells what a print will take, as `openfab print --estimate` does, and prints nothing.

    Amounts come from a coarse print, and are within a few per cent where parts are thicker than a few of its voxels;
    time comes from some slices.

    Parameters
    ----------
    world : World or FileWorld
        What would be printed.
    printer : str or path, optional
        Instead of the world's.
    process : str or path, optional
        A file of items that replace those of the printer's `process`, such as its `cost`.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm; one, or of x, y and z. Else that of the printer.
    dpi : float, str or sequence of 2 floats, optional
        The same along x and y, in dots an inch.
    layer : float or str, optional
        The height of a slice in mm.
    draft : int, optional
        How many times as large voxels are as the printer's, 1 at least.
    slices : sequence of 2 int, optional
        The first slice that is printed, and one past the last.
    z : sequence of 2 floats or str, optional
        The same as heights, in mm.
    uniforms : mapping of str to Any, optional
        Other values, as `{"ball.skin": 1.5}`.
    support : bool or str, optional
        Whether there is support material, or which.
    crop : {"parts", "tray"}, optional
        What the slices show.
    memory : int or str, optional
        The budget, in bytes.
    threads : int, optional
        1 at least; else as many as there are processors.

    Returns
    -------
    Estimate
        Time, memory, and by material amounts and money.

    Raises
    ------
    InputError
        Where an argument or the world is wrong.
    CompileError
        Where a fablet does not compile.

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
    )
