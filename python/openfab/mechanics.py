# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Whether what is printed holds, with numpy results, by the program `openfab mechanics`.

The wheel does not carry that program: it comes with the `.deb`, or with a build. It is looked for as `openfab` on the
PATH, or where the variable OPENFAB_PROGRAM says.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import InputError, InternalError, OutsideError

if TYPE_CHECKING:
    import numpy

__all__ = ["CellResult", "PartResult", "StandResult", "cell", "part", "stand"]


@dataclass(frozen=True)
class PartResult:
    """A loaded part: numbers, and fields of elements of shape (z, y, x)."""

    numbers: dict[str, Any]
    """All that `-o FILE.json` has: most_moved_mm, safety, weakest, ..."""
    displacement_mm: numpy.ndarray
    """(z, y, x, 3)"""
    von_mises_MPa: numpy.ndarray
    tension_MPa: numpy.ndarray
    compression_MPa: numpy.ndarray
    safety: numpy.ndarray
    """0 where it is not known, and in void."""
    solid: numpy.ndarray
    """The share of material in each element."""
    pitch_mm: tuple[float, float, float]
    origin_mm: tuple[float, float, float]
    """The lowest corner, in the build."""
    materials: list[str]


@dataclass(frozen=True)
class CellResult:
    """A periodic cell as a material."""

    numbers: dict[str, Any]
    stiffness_MPa: numpy.ndarray
    """(6, 6) of xx yy zz yz xz xy, with engineering shears."""


@dataclass(frozen=True)
class StandResult:
    """A part without loads."""

    numbers: dict[str, Any]
    stands: bool
    margin_deg: float


def part(
    world: str | os.PathLike[str],
    case: str | None = None,
    *,
    voxel_mm: float | None = None,
    arguments: Sequence[str] = (),
) -> PartResult:
    """Solve a case of a world. `arguments` are more of `openfab mechanics part`, as ["--thin"]."""
    import numpy

    given = [] if case is None else ["--case", case]
    with tempfile.TemporaryDirectory(prefix="openfab-") as folder:
        array, numbers = Path(folder) / "part.npy", Path(folder) / "part.json"
        _run("part", world, voxel_mm, [*given, "-o", str(array), "-o", str(numbers), *arguments])
        values = numpy.load(array)
        beside = json.loads(Path(f"{array}.json").read_text())
        return PartResult(
            json.loads(numbers.read_text()),
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


def cell(
    file: str | os.PathLike[str],
    size: str,
    *,
    voxel_mm: float | None = None,
    arguments: Sequence[str] = (),
) -> CellResult:
    """Homogenise a cell of a fablet or a world, of a size as "8mm"."""
    import numpy

    numbers = _json("cell", file, voxel_mm, ["--cell", size, *arguments])
    return CellResult(numbers, numpy.array(numbers["stiffness_MPa"]))


def stand(
    world: str | os.PathLike[str], *, voxel_mm: float | None = None, arguments: Sequence[str] = ()
) -> StandResult:
    """Look whether a world stands, and at its own weight, thinnest walls and softest modes."""
    numbers = _json("stand", world, voxel_mm, list(arguments))
    return StandResult(numbers, numbers["stands"], numbers["margin_deg"])


def _json(
    command: str, file: str | os.PathLike[str], voxel_mm: float | None, arguments: list[str]
) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="openfab-") as folder:
        numbers = Path(folder) / "numbers.json"
        _run(command, file, voxel_mm, [*arguments, "-o", str(numbers)])
        read: dict[str, Any] = json.loads(numbers.read_text())
        return read


def _run(
    command: str, file: str | os.PathLike[str], voxel_mm: float | None, arguments: list[str]
) -> None:
    program = os.environ.get("OPENFAB_PROGRAM") or shutil.which("openfab")
    if program is None:
        raise OutsideError(
            "the program `openfab` is not on the PATH; it comes with the .deb or a build, not "
            "with the wheel"
        )
    voxel = [] if voxel_mm is None else ["--voxel", f"{voxel_mm:.9g}mm"]
    done = subprocess.run(
        [program, "mechanics", command, os.fspath(file), *voxel, "--quiet", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode == 0:
        return
    kinds = {1: InputError, 2: InputError, 4: InternalError}
    raise kinds.get(done.returncode, OutsideError)(done.stderr.strip())
