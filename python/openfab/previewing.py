# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of prints."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._given import Real, Whole
from ._options import fields_of, view_of
from ._progress import Progress
from .printing import Print
from .world import AnyWorld

def preview(
    world: AnyWorld, *views: str, uniforms: Mapping[str, Any] | None = None,
    voxel: Real | str | Sequence[Real] | None = None, draft: Whole | None = None,
    printer: str | os.PathLike[str] | None = None, memory: Whole | str | None = None, threads: Whole | None = None,
    progress: Progress = False,
) -> list[NDArray[np.uint8]]:
    """Draws pictures of a print.

    Parameters
    ----------
    world : World or FileWorld
        What to draw, in its state at the call.
    *views : str
        Views as in `--preview`: `top`, `bottom`, `front`, `right`, `back`, `left`, `section`, `slice:N` or
        `model:TURN:TILT` in degrees, optionally followed by `,light=transmitted` or `,cut=x|y|xy`. Default: `model:30:30`.
    uniforms : mapping of str to Any, optional
        Values to use instead, such as `{"ball.skin": 1.5}`.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm: one, or three for x, y and z. Default: that of the printer.
    draft : int, optional
        How many times larger than the printer's the voxels are.
    printer : str or path, optional
        The printer to use instead of the world's.
    memory : int or str, optional
        The memory budget, in bytes.
    threads : int, optional
        At least 1. Default: one per processor.
    progress : bool or callable, optional
        True for a progress bar, or a function that takes the number of finished slices and of all slices.

    Returns
    -------
    list of ndarray of uint8, shape (row, column, 4)
        One picture per view, RGBA in sRGB.

    Raises
    ------
    InputError
        If an argument, a view or the world is wrong.
    CompileError
        If a fablet does not compile.
    """
    fields = fields_of(voxel=voxel, draft=draft, printer=printer, memory=memory, threads=threads)
    fields["previews"] = [view_of(view) for view in views or ("model:30:30",)]
    with Print(world, fields, _core.Target.PICTURES, uniforms=uniforms, progress=progress) as running:
        running._end()
        return running._core.pictures
