# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Files from the formats' own writers, imported and printed, with a check of known voxels."""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOL = Path(os.environ.get("OPENFAB_TOOL", ROOT / "build" / "release" / "bin" / "openfab"))
VOXEL = 0.5  # mm

# Colours that inks over white can make without reaching a limit, so that the skin's formula can be inverted.
RED, GREEN, BLUE, YELLOW = (220, 160, 160), (160, 220, 160), (160, 160, 220), (220, 220, 160)
WHITE, GREY = (255, 255, 255), (188, 188, 188)


def linear(srgb: float) -> float:
    """Converts sRGB values of 0 ... 255 to linear light (IEC 61966-2-1)."""
    x = srgb / 255
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def srgb(x: float) -> float:
    return 255 * (x * 12.92 if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


def box(side: float = 4, at: Sequence[float] = (0, 0, 0)) -> tuple[np.ndarray, np.ndarray]:
    """Returns the corners of a cube, x fastest, and its triangles."""
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], dtype=np.float64)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return corners * side + np.asarray(at, dtype=np.float64), np.array(faces)


TOP = (2, 3)  # the triangles of a box at its highest z


def quad_picture(texels: int = 8) -> np.ndarray:
    """Returns a picture of four squares: RED and GREEN above BLUE and YELLOW."""
    picture = np.zeros((texels, texels, 3), dtype=np.uint8)
    half = texels // 2
    picture[:half, :half], picture[:half, half:] = RED, GREEN
    picture[half:, :half], picture[half:, half:] = BLUE, YELLOW
    return picture


class Print:
    """A printed world: `codes` and `fractions` of its voxels, by z, y and x."""

    def __init__(self, folder: Path, world: Path, told: str):
        self.told = told
        self.world = json.loads(world.read_text())
        out, fractions = folder / "print.npy", folder / "fractions.npy"
        run("print", world, "-o", out, "--fractions", fractions, "--voxel", f"{VOXEL}mm", "--support", "off",
            "--sampling", "centre")
        self.codes = np.load(out)
        self.fractions = np.load(fractions)
        self.about = json.loads(out.with_name(out.name + ".json").read_text())
        self.names = [material["name"] for material in self.about["materials"]]

    def counts(self) -> dict[str, int]:
        """Returns the number of voxels of each material."""
        return {n: int((self.codes == i + 1).sum()) for i, n in enumerate(self.names) if (self.codes == i + 1).any()}

    def key(self, name: str) -> tuple[int, ...]:
        text = self.world["materials"][name]["key"]
        return tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))

    def keys(self) -> dict[tuple[int, ...], int]:
        """Returns the number of voxels of each material, by its colour."""
        return {self.key(name): count for name, count in self.counts().items()}

    def mix(self, x: float, y: float, z: float) -> dict[str, float]:
        """Returns the materials at a point, in mm from the lowest corner of the print."""
        at = self.fractions[int(z / VOXEL), int(y / VOXEL), int(x / VOXEL)]
        return {name: float(f) for name, f in zip(self.names, at) if f > 0.002}

    def look(self, x: float, y: float, z: float) -> tuple[int, ...] | None:
        """Returns the sRGB colour of a voxel, from inks that filter white or from its materials; None if it is empty."""
        mix = self.mix(x, y, z)
        if not mix:
            return None
        inks = [mix.get(name, 0) for name in ("cyan", "magenta", "yellow", "black")]
        if "cyan" in self.world["materials"] and mix.keys() <= {"cyan", "magenta", "yellow", "black", "white"}:
            return tuple(round(srgb(10 ** (-1.2 * (inks[c] + inks[3])))) for c in range(3))
        return tuple(round(srgb(sum(f * linear(self.key(n)[c]) for n, f in mix.items()))) for c in range(3))


def run(*arguments: object) -> str:
    done = subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, f"openfab {' '.join(map(str, arguments))}\n{done.stderr}"
    return done.stderr


def like(seen: tuple[int, ...] | None, expected: Sequence[float], within: float = 2) -> bool:
    """Returns whether two colours of 0 ... 255 are the same up to rounding."""
    return seen is not None and all(abs(a - b) <= within for a, b in zip(seen, expected, strict=True))


def close(mix: dict[str, float], expected: dict[str, float], within: float = 0.004) -> bool:
    return all(math.isclose(mix.get(n, 0), expected.get(n, 0), abs_tol=within) for n in {*mix, *expected})


@pytest.fixture
def imported(tmp_path: Path) -> Callable[..., Print]:
    """Imports a file and prints it."""

    def do(file: Path, *options: Any) -> Print:
        world = tmp_path / f"world of {file.name}"
        told = run("import", file, "-o", world, *options)
        return Print(tmp_path, world / f"{file.stem}.fab.json", told)

    return do
