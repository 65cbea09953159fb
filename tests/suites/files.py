#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Files of public suites that lie in a folder, each read by OpenFab and by another program: scripts/suites FOLDER.

Each suite is a folder in FOLDER with the name of its repository. A file is as expected (the other reader's numbers), refused with a
message, or wrong: other numbers, a crash, no end within a minute. Where the other reader has nothing to compare with, it is
not compared. Prints what is not as expected, then rows of docs/conformance.md; fails if any is wrong.
"""

from __future__ import annotations

import argparse
import collections
import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Callable, NamedTuple

import numpy as np
import trimesh
from PIL import Image

NEAR = 1e-4  # of the size; text formats round
# Boxes by hand, in mm, of files that the other reader takes for something else: the same number of an object in two parts of a package.
BY_HAND = {"production_components.3mf": [[0, 0, 0], [25, 10, 10]]}
MESHES = {".3mf", ".stl", ".ply", ".obj", ".glb", ".gltf", ".off", ".amf"}


class Refused(Exception):
    """Our message."""


class Unread(Exception):
    """Why there is nothing to compare with."""


class Suite(NamedTuple):
    name: str
    folder: str
    ends: frozenset[str]
    compare: str
    other: str


def run(words: list[str]) -> str:
    try:
        done = subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=60)
    except subprocess.TimeoutExpired as slow:
        raise AssertionError("no end within a minute") from slow
    if done.returncode == 0:
        return done.stdout
    said = done.stderr.strip().splitlines()
    if done.returncode not in (1, 3) or not any("error" in line for line in said):
        raise AssertionError(f"code {done.returncode}: {' '.join(said)[:300]}")
    raise Refused(next(line for line in said if "error" in line))


class Reader:
    def __init__(self, bin_folder: Path):
        self.bin = bin_folder

    def mesh(self, file: Path) -> None:
        """Box and triangles of the parts, against those of trimesh."""
        said = json.loads(run([str(self.bin / "openfab"), "info", "--json", str(file)]))
        parts = [b for b in said["bodies"] if b["role"] == "part"]
        refusals = [b["refusal"] for b in parts if b.get("refusal")]
        if not parts:
            raise Unread("lattices or level sets alone")
        try:
            theirs = trimesh.load(file, process=False, force="scene")
            corners = np.asarray(theirs.bounds, float)
            triangles = sum(len(theirs.geometry[g].faces) for _, g in map(theirs.graph.get, theirs.graph.nodes_geometry) if hasattr(theirs.geometry[g], "faces"))
            if corners.shape != (2, 3) or triangles == 0:
                raise ValueError("it finds no triangles")
        except Exception as problem:  # whatever it raises: it does not read the file
            if refusals:
                raise Refused(refusals[0]) from problem
            raise Unread(f"trimesh: {type(problem).__name__} {problem}"[:200]) from problem
        if file.suffix == ".gltf" and any(key in file.read_text(errors="replace") for key in ('"targets"', '"skins"')):
            raise Unread("trimesh moves nothing by morph targets or skins")
        if file.name in BY_HAND:
            corners = np.array(BY_HAND[file.name], float)
        lo = np.min([b["from_mm"] for b in parts], axis=0)
        hi = np.max([np.add(b["from_mm"], b["size_mm"]) for b in parts], axis=0)
        unit = said["unit_mm"]
        if file.suffix == ".3mf":
            unit = {"micron": 1e-3, "millimeter": 1, "centimeter": 10, "inch": 25.4, "foot": 304.8, "meter": 1000}.get(theirs.units, 1)
        elif file.suffix in (".glb", ".gltf"):  # y points up there
            corners = np.array([[c[0], -z, c[1]] for c, z in zip(corners, corners[::-1, 2])])
        corners = corners * unit
        scale = float(np.max(np.abs(corners)))
        if np.max(np.abs(np.array([lo, hi]) - corners)) > NEAR * scale:
            if said["left_out"]:  # by name, and the other program has it
                raise Refused("; ".join(f"{one['what']} left out" for one in said["left_out"]))
            raise AssertionError(f"from {lo} to {hi}, not {corners[0]} to {corners[1]}")
        count = sum(b["triangles"] for b in parts)
        if count > triangles:  # fewer: those without area are left out, with a warning
            raise AssertionError(f"{count} triangles, not {triangles}")
        if refusals:
            raise Refused(refusals[0])

    def texture(self, file: Path) -> np.ndarray:
        """Texels of a picture: linear light, the top row first."""
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "a.oftx"
            run([str(self.bin / "openfab"), "texture", str(file), "-o", str(out)])
            data = out.read_bytes()
        channels, width, height = np.frombuffer(data, np.int32, 3, 12)
        begin = int(np.frombuffer(data, np.int64, 1, 40)[0])
        return np.frombuffer(data, np.float32, channels * width * height, begin).reshape(height, width, channels)[::-1]

    def picture(self, file: Path) -> None:
        """Pixels, against Pillow's of 8 bits, by the file's gamma or as sRGB; on white where there is alpha."""
        ours = self.texture(file)
        try:
            with Image.open(file) as picture:
                gamma = picture.info.get("gamma")
                srgb = "srgb" in picture.info or gamma is None
                deep = picture.mode.startswith("I")
                theirs = np.asarray(picture.convert("RGB" if deep else "RGBA"), float) / 255
        except Exception as problem:
            raise Unread(f"Pillow: {problem}") from problem
        if ours.shape[:2] != theirs.shape[:2]:
            raise AssertionError(f"{ours.shape[1::-1]} pixels, not {theirs.shape[1::-1]}")
        if deep:
            raise Unread("Pillow reads 8 bits of 16")
        linear = np.where(theirs <= 0.04045, theirs / 12.92, ((theirs + 0.055) / 1.055) ** 2.4) if srgb else theirs ** (1 / gamma)
        alpha = theirs[..., 3:]
        light = linear[..., :3] * alpha + 1 - alpha
        grey = ours.shape[2] < 3
        got = np.repeat(ours[..., :1], 3, axis=2) if grey else ours[..., :3]
        # Of 16 bits, Pillow has 8.
        far = float(np.max(np.abs(got - light)))
        if far > 2.5 / 255:
            raise AssertionError(f"light differs by up to {far:.3g}, {ours.shape[2]} channels")

    def exr(self, file: Path) -> None:
        """Red, green and blue, against the library's own, in the display window."""
        import OpenEXR

        ours = self.texture(file)
        try:
            read = OpenEXR.File(str(file), separate_channels=True)
            header, channels = read.header(), read.channels()
            lo, hi = header["displayWindow"]
            (x, y), (right, bottom) = header["dataWindow"]
            if "chromaticities" in header:
                raise ValueError("its primaries are converted")
            names = ["R", "G", "B"] if "R" in channels else ["Y"]
            alpha = np.asarray(channels["A"].pixels, float) if "A" in channels else 1.0
            # Colours are multiplied by alpha; they lie on white. Beyond the data is 0, and transparent where there is alpha.
            parts = [np.asarray(channels[c].pixels, float) + 1 - alpha for c in names]
        except Exception as problem:
            raise Unread(f"OpenEXR: {type(problem).__name__} {problem}") from problem
        size = tuple(int(b - a + 1) for a, b in zip(lo, hi))
        if ours.shape[1::-1] != size:
            raise AssertionError(f"{ours.shape[1::-1]} pixels, not {size}")
        theirs = np.full((*size[::-1], len(names)), 1.0 if "A" in channels else 0.0)
        left, top = max(x, lo[0]), max(y, lo[1])
        right, bottom = min(right, hi[0]), min(bottom, hi[1])
        if left <= right and top <= bottom:
            seen = np.stack(parts, axis=2)[top - y : bottom - y + 1, left - x : right - x + 1]
            theirs[top - lo[1] : bottom - lo[1] + 1, left - lo[0] : right - lo[0] + 1] = seen
        far = np.abs(ours[..., : len(names)] - theirs) / np.maximum(1, np.abs(theirs))
        if float(np.max(far)) > 1e-3:  # floats of 16 bits
            raise AssertionError(f"light differs by up to {float(np.max(far)):.3g}")


SUITES = [
    Suite("3mf-samples", "3mf-samples", frozenset({".3mf"}), "mesh", "trimesh"),
    Suite("lib3mf, test files", "lib3mf", frozenset({".3mf", ".stl"}), "mesh", "trimesh"),
    Suite("glTF-Validator, tests", "glTF-Validator", frozenset({".gltf", ".glb"}), "mesh", "trimesh"),
    Suite("trimesh, models", "trimesh", frozenset(MESHES), "mesh", "trimesh"),
    Suite("Assimp, models", "assimp", frozenset(MESHES), "mesh", "trimesh"),
    Suite("PngSuite, of libpng", "libpng", frozenset({".png"}), "picture", "Pillow"),
    Suite("openexr-images", "openexr-images", frozenset({".exr"}), "exr", "OpenEXR"),
]


def version_of(folder: Path) -> str:
    if (folder / "COMMIT").is_file():
        return (folder / "COMMIT").read_text().strip()
    done = subprocess.run(["git", "-C", str(folder), "rev-parse", "HEAD"], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def try_file(compare: Callable[[Path], None], file: Path) -> tuple[str, str]:
    try:
        compare(file)
        return "as expected", ""
    except Refused as refused:
        return "refused", str(refused)
    except Unread as unread:
        return "not compared", str(unread)
    except AssertionError as wrong:
        return "wrong", str(wrong)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("suites", nargs="*", help="names of folders in it; default: all that are known")
    parser.add_argument("--bin", type=Path, default=Path("build/release/bin"))
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = ["| suite | commit | files | as expected | refused | wrong | not compared | seconds | other program |", "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    reader = Reader(options.bin)
    any_wrong = False
    for suite in SUITES:
        folder = options.folder / suite.folder
        if not folder.is_dir() or (options.suites and suite.folder not in options.suites):
            continue
        outcomes: collections.Counter[str] = collections.Counter()
        began = time.monotonic()
        files = sorted(f for f in folder.rglob("*") if f.suffix.lower() in suite.ends and f.is_file())
        for file in files:
            outcome, why = try_file(getattr(reader, suite.compare), file)
            outcomes[outcome] += 1
            if outcome != "as expected":
                print(f"{outcome}: {file.relative_to(options.folder)}: {why}", flush=True)
        any_wrong |= outcomes["wrong"] > 0
        figures = [str(outcomes[o]) for o in ("as expected", "refused", "wrong", "not compared")]
        rows.append(f"| {suite.name} | {version_of(folder)[:8]} | {len(files)} | {' | '.join(figures)} | {time.monotonic() - began:.0f} | {suite.other} |")
    print("\n".join(rows))
    return 1 if any_wrong else 0


if __name__ == "__main__":
    sys.exit(main())
