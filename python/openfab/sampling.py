# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Mixtures in boxes, and at points."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._given import Real, Whole, floats, number, several, short, vector
from ._options import fields_of
from ._progress import Progress
from .errors import InputError
from .printing import Print
from .slices import PrintMaterial
from .world import AnyWorld

@dataclass(frozen=True)
class Samples:
    """Mixtures in a box of voxels; `sample` makes it.

    The centre of voxel (i, j, k) is at `origin_mm` + (i + 0.5, j + 0.5, k + 0.5) `pitch_mm`.

    Attributes
    ----------
    fractions : ndarray of float32, shape (z, y, x, material)
        The share of each material; the rest up to 1 is void.
    origin_mm : tuple of 3 floats
        The lowest corner of the box along x, y and z, in mm.
    pitch_mm : tuple of 3 floats
        The size of a voxel along x, y and z, in mm.
    materials : tuple of PrintMaterial
        The materials of the last axis.
    jacobian : mapping of str to ndarray of float32, shape (z, y, x, material, ...)
        By name of a uniform the derivatives of the fractions, one for each of its numbers; the last axes are those of
        the uniform: none for a `float`, (3,) for a `float3`, (2, 2) for a `float2x2`, an array's before. In 1 per unit of
        the uniform.
    """

    fractions: NDArray[np.float32]
    origin_mm: tuple[float, float, float]
    pitch_mm: tuple[float, float, float]
    materials: tuple[PrintMaterial, ...]
    jacobian: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)

    def at(self, points: ArrayLike) -> NDArray[np.float32]:
        """Looks up the mixtures at points.

        Parameters
        ----------
        points : array_like of float, shape (..., 3)
            Positions in mm.

        Returns
        -------
        ndarray of float32, shape (..., material)
            The mixtures of the voxels that contain the points; zeros outside the box.

        Raises
        ------
        InputError
            If the points have the wrong shape.
        """
        if np.shape(points)[-1:] != (3,):
            raise InputError(f"`points` has the shape {np.shape(points)}; it should be (..., 3)")
        places = (np.asarray(points, float) - self.origin_mm) / self.pitch_mm
        index = np.floor(places).astype(np.int64)
        size = np.array(self.fractions.shape[2::-1])
        inside = np.all((index >= 0) & (index < size), axis=-1)
        i, j, k = np.moveaxis(np.clip(index, 0, size - 1), -1, 0)
        return np.where(inside[..., None], self.fractions[k, j, i], np.float32(0))

    def mean(self, values: Mapping[str, float], void: float = 0.0) -> NDArray[np.float64]:
        """Averages a property of materials, weighted by their amounts.

        Parameters
        ----------
        values : mapping of str to float
            The value for each material, by name.
        void : float, optional
            The value for void.

        Returns
        -------
        ndarray of float64, shape (z, y, x)
            The means, in the unit of the values.

        Raises
        ------
        InputError
            If a material has no value, or a name is unknown.
        """
        return _mean(self.fractions, self.materials, values, void)


@dataclass(frozen=True)
class PointSamples:
    """Mixtures at points; `sample_at` makes it.

    Attributes
    ----------
    fractions : ndarray of float32, shape (..., material)
        The share of each material in the voxel that contains the point; the rest up to 1 is void.
    materials : tuple of PrintMaterial
        The materials of the last axis.
    jacobian : mapping of str to ndarray of float32, shape (..., material, ...)
        By name of a uniform the derivatives of the fractions, as in `Samples`.
    """

    fractions: NDArray[np.float32]
    materials: tuple[PrintMaterial, ...]
    jacobian: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)

    def mean(self, values: Mapping[str, float], void: float = 0.0) -> NDArray[np.float64]:
        """Averages a property of materials, weighted by their amounts.

        Parameters
        ----------
        values : mapping of str to float
            The value for each material, by name.
        void : float, optional
            The value for void.

        Returns
        -------
        ndarray of float64, shape (...)
            The means, in the unit of the values.

        Raises
        ------
        InputError
            If a material has no value, or a name is unknown.
        """
        return _mean(self.fractions, self.materials, values, void)


def _mean(
    fractions: NDArray[np.float32], materials: tuple[PrintMaterial, ...], values: Mapping[str, float], void: float
) -> NDArray[np.float64]:
    names = [material.name for material in materials]
    unknown = set(values) - set(names)
    if unknown:
        raise InputError(f"no material is called {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    missing = [name for name in names[: fractions.shape[-1]] if name not in values]
    if missing:
        raise InputError(f"there is no value for {', '.join(missing)}; give one for each of {', '.join(names)}")
    weights = np.array([number(values[name], f"`{name}`") for name in names[: fractions.shape[-1]]])
    means: NDArray[np.float64] = fractions @ weights + void * (1 - fractions.sum(axis=-1))
    return means


def sample(
    world: AnyWorld,
    box: tuple[Sequence[Real], Sequence[Real]] | None = None,
    *,
    voxel: Real | str | Sequence[Real],
    sampling: Literal["volume", "centre"] | None = None,
    jacobian: str | Sequence[str] = (),
    uniforms: Mapping[str, Any] | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
    progress: Progress = False,
) -> Samples:
    """Evaluates the mixtures of a world in a box, with voxels of any size.

    Only the box is evaluated, which may be a small part of a large world. Voxels larger than the printer's get the mean
    mixture of the printer's voxels in them, including void.

    Parameters
    ----------
    world : World or FileWorld
        What to evaluate, in its state at the call.
    box : sequence of 2 sequences of 3 floats, optional
        The lowest and the highest corner, in mm. Default: the box of all parts. It is rounded out to whole voxels, whose
        corners are at multiples of the pitch.
    voxel : float, str or sequence of 3 floats
        The size of a voxel in mm: one, or three for x, y and z.
    sampling : {"volume", "centre"}, optional
        Whether a voxel larger than the printer's gets the mean over its volume, which takes as long as a print, or the
        mixture at its centre, which misses details smaller than the voxel. Default: `volume`, and `centre` with a
        `jacobian`, which knows no other.
    jacobian : str or sequence of str, optional
        Uniforms by which the fractions are differentiated, too, as `OBJECT.UNIFORM`: floats, their vectors, matrices and
        arrays, of at most 16 numbers in each fablet; one element of an array is `OBJECT.UNIFORM[3]`. A step or a branch has
        the derivative of what it takes, so that a fraction that jumps has the derivative 0, and a CompilerWarning says where.
        All placements of the object count.
    uniforms : mapping of str to Any, optional
        Values to use instead, such as `{"ball.skin": 1.5}`.
    memory : int or str, optional
        The memory budget, in bytes.
    threads : int, optional
        At least 1. Default: one per processor.
    progress : bool or callable, optional
        True for a progress bar, or a function that takes the number of finished slices and of all slices.

    Returns
    -------
    Samples
        The mixtures before the dither, of shape (z, y, x, material).

    Raises
    ------
    InputError
        If an argument or the world is wrong.
    CompileError
        If a fablet does not compile.
    """
    by, sampling = _asked(jacobian, sampling)
    fields = fields_of(voxel=voxel, memory=memory, threads=threads, support=False, sampling=sampling)
    window: tuple[float, ...] | None = None
    if box is not None:
        corners = several(box, "`box`", (2,), "its lowest and its highest corner")
        low, high = (vector(corner, "`box`") for corner in corners)
        if not all(a < b for a, b in zip(low, high)):
            raise InputError(f"the box {short(box)} is none; give its lowest and its highest corner")
        window = (*low, *high)
    with Print(
        world, fields, _core.Target.SLICES, fractions=True, uniforms=uniforms, window=window, progress=progress,
        derivatives=by,
    ) as running:
        info = running.info
        out: NDArray[np.float32] | None = None
        rates: NDArray[np.float32] | None = None
        for one in running:
            assert one.fractions is not None
            if out is None:
                out = np.empty((info.size[2], *one.fractions.shape), np.float32)
            out[one.z] = one.fractions
            if running._rates is not None:
                if rates is None:
                    rates = np.empty((info.size[2], *running._rates.shape), np.float32)
                rates[one.z] = running._rates
        columns = running._core.rate_columns
    assert out is not None
    return Samples(out, info.origin_mm, info.pitch_mm, info.materials[: out.shape[-1]], _by_name(rates, columns))


def sample_at(
    world: AnyWorld,
    points: ArrayLike,
    *,
    voxel: Real | str | Sequence[Real],
    sampling: Literal["volume", "centre"] | None = None,
    jacobian: str | Sequence[str] = (),
    uniforms: Mapping[str, Any] | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
) -> PointSamples:
    """Evaluates the mixtures of a world at scattered points: those of the voxels that contain them.

    The voxels are those of `sample`, with corners at multiples of the pitch. Boxes around neighbouring points are
    evaluated, one after the other: few points far apart cost little, whatever lies between them.

    Parameters
    ----------
    world : World or FileWorld
        What to evaluate, in its state at the call.
    points : array_like of float, shape (..., 3)
        Positions in mm.
    voxel : float, str or sequence of 3 floats
        The size of a voxel in mm: one, or three for x, y and z.
    sampling : {"volume", "centre"}, optional
        As for `sample`.
    jacobian : str or sequence of str, optional
        As for `sample`.
    uniforms : mapping of str to Any, optional
        Values to use instead, such as `{"ball.skin": 1.5}`.
    memory : int or str, optional
        The memory budget, in bytes.
    threads : int, optional
        At least 1. Default: one per processor.

    Returns
    -------
    PointSamples
        The mixtures before the dither, of shape (..., material); zeros beside the parts.

    Raises
    ------
    InputError
        If an argument or the world is wrong.
    CompileError
        If a fablet does not compile.
    """
    given = floats(points, "`points`", np.float64)
    if given.shape[-1:] != (3,) or not given.size:
        raise InputError(f"`points` has the shape {given.shape}; it should be (..., 3), with one point at least")
    by, sampling = _asked(jacobian, sampling)
    fields = fields_of(voxel=voxel, memory=memory, threads=threads, support=False, sampling=sampling)
    pitch = np.full(3, fields["voxel_mm"]) if "voxel_mm" in fields else np.array([*(25.4 / np.array(fields["dpi"])), fields["layer_mm"]])
    flat = given.reshape(-1, 3)
    out: NDArray[np.float32] | None = None
    rates: NDArray[np.float32] | None = None
    columns: Sequence[tuple[str, int, int, int, str]] = ()
    materials: tuple[PrintMaterial, ...] = ()
    for some in _neighbours(flat, pitch, np.arange(len(flat)))[1]:
        own = flat[some]
        # Points in the faces of voxels are within the box, too.
        window = (*(own.min(axis=0) - _MARGIN * pitch), *(own.max(axis=0) + _MARGIN * pitch))
        with Print(
            world, fields, _core.Target.SLICES, fractions=True, uniforms=uniforms, window=window, derivatives=by
        ) as running:
            info = running.info
            place = np.floor((own - info.origin_mm) / info.pitch_mm).astype(np.int64)
            for one in running:
                assert one.fractions is not None
                if out is None:
                    out = np.zeros((len(flat), one.fractions.shape[-1]), np.float32)
                    materials = info.materials[: out.shape[-1]]
                here = (place[:, 2] == one.z) & np.all((place[:, :2] >= 0) & (place[:, :2] < info.size[:2]), axis=1)
                out[some[here]] = one.fractions[place[here, 1], place[here, 0]]
                if running._rates is not None:
                    if rates is None:
                        rates = np.zeros((len(flat), *running._rates.shape[2:]), np.float32)
                    rates[some[here]] = running._rates[place[here, 1], place[here, 0]]
            columns = running._core.rate_columns
    assert out is not None
    if rates is not None:
        rates = rates.reshape(*given.shape[:-1], *rates.shape[1:])
    return PointSamples(out.reshape(*given.shape[:-1], -1), materials, _by_name(rates, columns))


def _asked(
    jacobian: str | Sequence[str], sampling: Literal["volume", "centre"] | None
) -> tuple[tuple[str, ...], Literal["volume", "centre"]]:
    """Returns the names of uniforms, each once, and the sampling."""
    names = (jacobian,) if isinstance(jacobian, str) else tuple(dict.fromkeys(jacobian))
    for name in names:
        if not isinstance(name, str) or "." not in name:
            raise InputError(f"`jacobian` cannot be {short(name)}; name uniforms, as `OBJECT.UNIFORM`")
    if names and sampling == "volume":
        raise InputError(
            "a `jacobian` is one at the voxels' centres, not of means over their volumes",
            help="leave `sampling` out, or sample with voxels of the printer's size",
        )
    return names, sampling or ("centre" if names else "volume")


def _by_name(
    rates: NDArray[np.float32] | None, columns: Sequence[tuple[str, int, int, int, str]]
) -> dict[str, NDArray[np.float32]]:
    """Takes derivatives (..., column, material) apart, by uniform."""
    out: dict[str, NDArray[np.float32]] = {}
    for name, first, components, count, declared in columns:
        assert rates is not None
        matrix = re.search(r"([2-4])x([2-4])$", declared)
        of_one = tuple(map(int, matrix.groups())) if matrix else (components,) if components > 1 else ()
        own = np.moveaxis(rates[..., first : first + components * count, :], -2, -1)
        out[name] = own.reshape(*own.shape[:-1], *((count,) if count > 1 else ()), *of_one)
    return out


# In voxels, what setting up one more box costs.
_SET_UP = 2e6
# Of a voxel; a box is rounded to voxels with a slack.
_MARGIN = 0.01


def _neighbours(
    points: NDArray[np.float64], pitch: NDArray[np.float64], some: NDArray[np.int64]
) -> tuple[float, list[NDArray[np.int64]]]:
    """Returns points in groups whose boxes cost least, and that cost."""
    own = points[some]
    sides = np.ptp(own, axis=0) / pitch + 1
    whole = _SET_UP + float(np.prod(sides))
    if whole <= 2 * _SET_UP or len(some) == 1:
        return whole, [some]
    order = np.argsort(own[:, int(np.argmax(sides))], kind="stable")
    halves = [_neighbours(points, pitch, some[part]) for part in np.array_split(order, 2)]
    apart = sum(cost for cost, _ in halves)
    return (apart, [group for _, groups in halves for group in groups]) if apart < whole else (whole, [some])
