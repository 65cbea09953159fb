# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Mechanics of prints: runs `openfab mechanics` and returns its results as numpy arrays.

The package has that program, and prints for it with its own compiler and runtime. The variable OPENFAB_PROGRAM names an
`openfab` to run instead.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy
from numpy.typing import NDArray

from .errors import InputError, InternalError, OutsideError

__all__ = [
    "CellResult",
    "ConductResult",
    "PartResult",
    "StandResult",
    "StrengthenResult",
    "cell",
    "conduct",
    "part",
    "stand",
    "strengthen",
]


@dataclass(frozen=True)
class PartResult:
    """A part under load: numbers, and fields of elements. `part` makes it.

    Attributes
    ----------
    numbers : dict
        The content of `-o FILE.json`: most_moved_mm, safety, weakest, residual, ...
    displacement_mm : array of float32, shape (z, y, x, 3)
        The mean displacement of each element's corners, in mm.
    von_mises_MPa, tension_MPa, compression_MPa : array of float32, shape (z, y, x)
        The von Mises stress, and the largest and the smallest principal stress, in MPa.
    safety : array of float32, shape (z, y, x)
        The strength divided by the von Mises stress; 0 where it is unknown, and in void.
    solid : array of float32, shape (z, y, x)
        The share of material in each element.
    pitch_mm : tuple of 3 floats
        The sides of an element, in mm.
    origin_mm : tuple of 3 floats
        The lowest corner in build space, in mm.
    materials : list of str
        The materials of the print.
    """

    numbers: dict[str, Any]
    displacement_mm: NDArray[numpy.float32]
    von_mises_MPa: NDArray[numpy.float32]
    tension_MPa: NDArray[numpy.float32]
    compression_MPa: NDArray[numpy.float32]
    safety: NDArray[numpy.float32]
    solid: NDArray[numpy.float32]
    pitch_mm: tuple[float, float, float]
    origin_mm: tuple[float, float, float]
    materials: list[str]


@dataclass(frozen=True)
class CellResult:
    """A periodic cell as a material. `cell` makes it.

    Attributes
    ----------
    numbers : dict
        The content of `-o FILE.json`: young_MPa, poisson_xy_yz_zx, zener, share, ...; for a sweep, its `rows`.
    stiffness_MPa : array of float64, shape (6, 6) or (n, 6, 6)
        The stiffness in MPa, in the order xx yy zz yz xz xy with engineering shears; for a sweep, one for each row.
    """

    numbers: dict[str, Any]
    stiffness_MPa: NDArray[numpy.float64]


@dataclass(frozen=True)
class StandResult:
    """A part without loads. `stand` makes it.

    Attributes
    ----------
    numbers : dict
        The content of `-o FILE.json`: mass_g, thinnest, own_weight, modes, ...
    stands : bool
        Whether its centre of mass is above its base, and its base is more than a staircase of voxels.
    margin_deg : float
        The angle by which it may be tilted, in degrees; if it is negative, the part falls.
    """

    numbers: dict[str, Any]
    stands: bool
    margin_deg: float


@dataclass(frozen=True)
class ConductResult:
    """Current or heat through a part. `conduct` makes it.

    Attributes
    ----------
    numbers : dict
        The content of `-o FILE.json`: held, resistance_ohm or resistance_K_W, least, most, densest, residual, ...
    level : array of float32, shape (z, y, x)
        The mean of each element's corners, in volts or degrees Celsius.
    density : array of float32, shape (z, y, x)
        The density of current in A/mm2, or of heat in W/mm2; 0 in void and in insulators.
    solid : array of float32, shape (z, y, x)
        The share of material in each element.
    pitch_mm : tuple of 3 floats
        The sides of an element, in mm.
    origin_mm : tuple of 3 floats
        The lowest corner in build space, in mm.
    """

    numbers: dict[str, Any]
    level: NDArray[numpy.float32]
    density: NDArray[numpy.float32]
    solid: NDArray[numpy.float32]
    pitch_mm: tuple[float, float, float]
    origin_mm: tuple[float, float, float]


@dataclass(frozen=True)
class StrengthenResult:
    """A world with a field that strengthens it. `strengthen` makes it.

    Attributes
    ----------
    world : Path
        The world with the field.
    field : array of float32, shape (z, y, x)
        The values that the fablet reads, from 0 to the limit.
    """

    world: Path
    field: NDArray[numpy.float32]


def part(
    world: str | os.PathLike[str],
    case: str | None = None,
    *,
    voxel_mm: float | Sequence[float] | None = None,
    arguments: Sequence[str] = (),
) -> PartResult:
    """Solves a load case of a world.

    Parameters
    ----------
    world : path
        A `.fab.json` with `cases`.
    case : str, optional
        Its name. Default: the only case of the world.
    voxel_mm : float or 3 floats, optional
        Side of an element in mm, or its three sides. Default: a 96th of the longest side.
    arguments : sequence of str, optional
        Other options of `openfab mechanics part`, such as `["--thin"]`.

    Returns
    -------
    PartResult
        Numbers, and fields of elements.

    Raises
    ------
    InputError
        If the world, the case or the materials are unsuitable, or the solution did not converge.
    OutsideError
        If the program cannot be started, or a file cannot be written.
    """
    numbers, values, beside = _solved("part", world, case, voxel_mm, arguments)
    return PartResult(
        numbers,
        values[..., :3],
        values[..., 3],
        values[..., 4],
        values[..., 5],
        values[..., 6],
        values[..., 7],
        tuple(beside["pitch_mm"]),
        tuple(beside["origin_mm"]),
        beside["materials"],
    )


def conduct(
    world: str | os.PathLike[str],
    case: str | None = None,
    *,
    voxel_mm: float | Sequence[float] | None = None,
    arguments: Sequence[str] = (),
) -> ConductResult:
    """Computes current or heat through a part, for a case with `volt` or `celsius`.

    Parameters
    ----------
    world : path
        A `.fab.json` with `cases`.
    case : str, optional
        Its name. Default: the only case of the world.
    voxel_mm : float or 3 floats, optional
        Side of an element in mm, or its three sides. Default: a 96th of the longest side.
    arguments : sequence of str, optional
        Other options of `openfab mechanics conduct`, such as `["--codes"]`.

    Returns
    -------
    ConductResult
        Numbers, and fields of elements.

    Raises
    ------
    InputError
        If the world, the case or the materials are unsuitable, or the solution did not converge.
    OutsideError
        If the program cannot be started, or a file cannot be written.
    """
    numbers, values, beside = _solved("conduct", world, case, voxel_mm, arguments)
    return ConductResult(
        numbers,
        values[..., 0],
        values[..., 1],
        values[..., 2],
        tuple(beside["pitch_mm"]),
        tuple(beside["origin_mm"]),
    )


def cell(
    file: str | os.PathLike[str],
    size: str,
    *,
    voxel_mm: float | Sequence[float] | None = None,
    sweep: str | None = None,
    arguments: Sequence[str] = (),
) -> CellResult:
    """Homogenises a cell of a fablet or a world.

    Parameters
    ----------
    file : path
        A `.fl` or a `.fab.json`.
    size : str
        The size of the cell, such as `"8mm"` or `"5mmx5mmx3mm"`.
    voxel_mm : float or 3 floats, optional
        Side of an element in mm, or its three sides. Default: a 64th of the shortest side.
    sweep : str, optional
        A uniform and its values, such as `"wall=0.8:2:3"`, with a cell for each.
    arguments : sequence of str, optional
        Other options of `openfab mechanics cell`, such as `["--codes", "--dither", "blue_noise"]`.

    Returns
    -------
    CellResult
        Numbers, and the stiffness.

    Raises
    ------
    InputError
        If the file, the size or the materials are unsuitable, or the solution did not converge.
    OutsideError
        If the program cannot be started, or a file cannot be written.
    """
    given = [] if sweep is None else ["--sweep", sweep]
    numbers = _json("cell", file, voxel_mm, ["--cell", size, *given, *arguments])
    tensors = [row["stiffness_MPa"] for row in numbers["rows"]] if "rows" in numbers else numbers["stiffness_MPa"]
    return CellResult(numbers, numpy.array(tensors, dtype=numpy.float64))


def stand(
    world: str | os.PathLike[str], *, voxel_mm: float | Sequence[float] | None = None, arguments: Sequence[str] = ()
) -> StandResult:
    """Checks a world without loads: whether it stands, its own weight, thinnest walls, softest modes and worst pushes.

    Parameters
    ----------
    world : path
        A `.fab.json`.
    voxel_mm : float or 3 floats, optional
        Side of an element in mm, or its three sides. Default: a 96th of the longest side.
    arguments : sequence of str, optional
        Other options of `openfab mechanics stand`, such as `["--while-printing", "8"]`.

    Returns
    -------
    StandResult
        Numbers, and whether it stands.

    Raises
    ------
    InputError
        If the world or the materials are unsuitable, or a solution did not converge.
    OutsideError
        If the program cannot be started, or a file cannot be written.
    """
    numbers = _json("stand", world, voxel_mm, list(arguments))
    return StandResult(numbers, numbers["stands"], numbers["margin_deg"])


def strengthen(
    world: str | os.PathLike[str],
    field: str,
    output: str | os.PathLike[str],
    *,
    safety: float = 1.5,
    case: str | None = None,
    voxel_mm: float | Sequence[float] | None = None,
    arguments: Sequence[str] = (),
) -> StrengthenResult:
    """Raises a field that the fablet reads until the part is strong enough.

    Parameters
    ----------
    world : path
        A `.fab.json` with `cases`.
    field : str
        The texture of the world to raise, starting at 0.
    output : path
        The file for the new world, `NAME.fab.json`; `NAME.FIELD.npy` is written next to it.
    safety : float, optional
        The safety factor to reach.
    case : str, optional
        Its name. Default: the only case of the world.
    voxel_mm : float or 3 floats, optional
        Side of an element in mm, or its three sides. Default: a 96th of the longest side.
    arguments : sequence of str, optional
        Other options of `openfab mechanics strengthen`, such as `["--limit", "2", "--reach", "4mm"]`.

    Returns
    -------
    StrengthenResult
        The world, and the field.

    Raises
    ------
    InputError
        If the safety factor is not reached (the message names the weakest place), or the world, the case or the
        materials are unsuitable.
    OutsideError
        If the program cannot be started, or a file cannot be written.
    """
    made = Path(output)
    given = [] if case is None else ["--case", case]
    _run(
        "strengthen",
        world,
        voxel_mm,
        ["--field", field, "--safety", f"{safety:.9g}", "-o", str(made), *given, *arguments],
    )
    return StrengthenResult(made, numpy.load(made.with_name(f"{made.name.removesuffix('.fab.json')}.{field}.npy")))


def _json(
    command: str, file: str | os.PathLike[str], voxel_mm: float | Sequence[float] | None, arguments: list[str]
) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="openfab-") as folder:
        numbers = Path(folder) / "numbers.json"
        try:
            _run(command, file, voxel_mm, [*arguments, "-o", str(numbers)])
        except InputError:
            # What does not stand ends with an error, after its numbers.
            if command != "stand" or not numbers.exists():
                raise
        read: dict[str, Any] = json.loads(numbers.read_text())
        return read


def _solved(
    command: str,
    world: str | os.PathLike[str],
    case: str | None,
    voxel_mm: float | Sequence[float] | None,
    arguments: Sequence[str],
) -> tuple[dict[str, Any], NDArray[numpy.float32], dict[str, Any]]:
    """Returns the numbers of a case, its array of elements, and the JSON file next to the array."""
    given = [] if case is None else ["--case", case]
    with tempfile.TemporaryDirectory(prefix="openfab-") as folder:
        array, numbers = Path(folder) / "part.npy", Path(folder) / "part.json"
        _run(command, world, voxel_mm, [*given, "-o", str(array), "-o", str(numbers), *arguments])
        beside = json.loads(Path(f"{array}.json").read_text())
        return json.loads(numbers.read_text()), numpy.load(array), beside


def _program() -> tuple[list[str], dict[str, str]]:
    """Returns the words that start the program, and its environment."""
    own = Path(__file__).with_name("bin") / "openfab-mechanics"
    named = os.environ.get("OPENFAB_PROGRAM") or (None if own.exists() else shutil.which("openfab"))
    if named is None and not own.exists():
        raise OutsideError(
            f"{own} is missing, and no `openfab` is on the PATH; install the package again, or name a program in the "
            f"variable OPENFAB_PROGRAM"
        )
    words = [str(own)] if named is None else [named, "mechanics"]
    return words, {**os.environ, "OPENFAB_PYTHON": sys.executable}


def _run(
    command: str, file: str | os.PathLike[str], voxel_mm: float | Sequence[float] | None, arguments: list[str]
) -> None:
    program, environment = _program()
    sides = [] if voxel_mm is None else list(voxel_mm) if isinstance(voxel_mm, Sequence) else [voxel_mm]
    voxel = ["--voxel", "x".join(f"{side:.9g}" for side in sides) + "mm"] if sides else []
    try:
        done = subprocess.run(
            [*program, command, os.fspath(file), *voxel, "--quiet", *arguments],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    except OSError as error:
        raise OutsideError(f"cannot start `{program[0]}`: {error.strerror}") from error
    if done.returncode == 0:
        return
    kinds = {1: InputError, 2: InputError, 4: InternalError}
    raise kinds.get(done.returncode, OutsideError)(done.stderr.strip())
