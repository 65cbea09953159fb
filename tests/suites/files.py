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
import io
import json
import re
import subprocess
import sys
import tempfile
import time
import warnings
import zipfile
from pathlib import Path
from typing import Callable, Iterator, NamedTuple

import numpy as np
import trimesh
from outcome import Refused, Unread, Wrong, outcome_of
from PIL import Image, ImageCms

NEAR = 1e-4  # of the size; text formats round
# Boxes by hand, in mm, of files that the other reader takes for something else: the same number of an object in two parts of a package.
BY_HAND = {"production_components.3mf": [[0, 0, 0], [25, 10, 10]]}
MESHES = {".3mf", ".stl", ".ply", ".obj", ".glb", ".gltf", ".off", ".amf"}


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
        raise Wrong("no end within a minute") from slow
    if done.returncode == 0:
        return done.stdout
    said = done.stderr.strip().splitlines()
    if done.returncode != 1 or not any("error" in line for line in said):
        raise Wrong(f"code {done.returncode}: {' '.join(said)[:300]}")
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
            raise Wrong(f"from {lo} to {hi}, not {corners[0]} to {corners[1]}")
        count = sum(b["triangles"] for b in parts)
        if count > triangles:  # fewer: those without area are left out, with a warning
            raise Wrong(f"{count} triangles, not {triangles}")
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
            raise Wrong(f"{ours.shape[1::-1]} pixels, not {theirs.shape[1::-1]}")
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
            raise Wrong(f"light differs by up to {far:.3g}, {ours.shape[2]} channels")

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
            raise Wrong(f"{ours.shape[1::-1]} pixels, not {size}")
        theirs = np.full((*size[::-1], len(names)), 1.0 if "A" in channels else 0.0)
        left, top = max(x, lo[0]), max(y, lo[1])
        right, bottom = min(right, hi[0]), min(bottom, hi[1])
        if left <= right and top <= bottom:
            seen = np.stack(parts, axis=2)[top - y : bottom - y + 1, left - x : right - x + 1]
            theirs[top - lo[1] : bottom - lo[1] + 1, left - lo[0] : right - lo[0] + 1] = seen
        far = np.abs(ours[..., : len(names)] - theirs) / np.maximum(1, np.abs(theirs))
        if float(np.max(far)) > 1e-3:  # floats of 16 bits
            raise Wrong(f"light differs by up to {float(np.max(far)):.3g}")


    def functions(self, file: Path) -> None:
        """Level sets by an evaluator of their functions, other models as meshes."""
        import functions

        if has_level_sets(file):
            functions.compare(run, str(self.bin / "openfab"), file)
        else:
            self.mesh(file)

    def profile(self, file: Path) -> None:
        """Colours of a picture that carries the profile, against Little CMS."""
        profile = file.read_bytes()
        mode = {b"RGB ": "RGB", b"GRAY": "L", b"CMYK": "CMYK"}.get(profile[16:20])
        if mode is None:
            raise Unread(f"of {profile[16:20]!r}")
        steps = np.array([0, 10, 64, 128, 200, 255], np.uint8)
        channels = {"RGB": 3, "L": 1, "CMYK": 4}[mode]
        pixels = np.stack(np.meshgrid(*[steps] * channels), axis=-1).reshape(len(steps), -1, channels)
        picture = Image.fromarray(pixels[..., 0] if mode == "L" else pixels, mode=mode)
        with tempfile.TemporaryDirectory() as folder:
            picture.save(Path(folder) / "a.tif", icc_profile=profile)
            ours = self.texture(Path(folder) / "a.tif")
        try:
            into = ImageCms.createProfile("sRGB")
            shown = ImageCms.profileToProfile(picture, ImageCms.ImageCmsProfile(io.BytesIO(profile)), into, renderingIntent=1, outputMode="RGB", flags=ImageCms.Flags.NOOPTIMIZE)
        except ImageCms.PyCMSError as problem:
            raise Unread(f"Little CMS: {problem}") from problem
        # Of 8 bits, and of what sRGB has.
        got = np.clip(np.repeat(ours[..., :1], 3, axis=2) if ours.shape[2] < 3 else ours[..., :3], 0, 1)
        coded = 255 * np.where(got <= 0.0031308, got * 12.92, 1.055 * got ** (1 / 2.4) - 0.055)
        far = float(np.max(np.abs(coded - np.asarray(shown, float))))
        if far > 1.5:
            raise Wrong(f"colours differ by up to {far:.3g} of 255")

    def step(self, file: Path) -> None:
        """Solids, by their number in the text; its vertices, which lie on the meshes of a file without an assembly."""
        text = file.read_text(errors="replace")
        solids = len(re.findall(r"=\s*(?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS|FACETED_BREP)\s*\(", text))
        with tempfile.TemporaryDirectory() as folder:
            run([str(self.bin / "openfab"), "import", str(file), "-o", f"{folder}/w"])
            said = json.loads(run([str(self.bin / "openfab"), "info", "--json", str(next(Path(folder).glob("w/*.3mf")))]))
        bodies = [b for b in said["bodies"] if b["role"] == "part"]
        placed = len(re.findall(r"=\s*NEXT_ASSEMBLY_USAGE_OCCURRENCE\s*\(", text))
        if placed:
            if len(bodies) < solids:
                raise Wrong(f"{len(bodies)} solids, not at least {solids}")
            raise Unread(f"an assembly of {placed} parts: {len(bodies)} solids are placed of {solids}")
        if len(bodies) != solids:
            raise Wrong(f"{len(bodies)} solids, not {solids}")
        points = dict(re.findall(r"#(\d+)\s*=\s*CARTESIAN_POINT\s*\([^,]*,\s*\(([^)]*)\)", text))
        corners = np.array([[float(v) for v in points[one].split(",")] for one in re.findall(r"=\s*VERTEX_POINT\s*\([^,]*,\s*#(\d+)\s*\)", text)])
        unit = 25.4 if re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'INCH'", text, re.IGNORECASE) else 1 if ".MILLI.,.METRE." in text.replace(" ", "") else 1000
        lo, hi = corners.min(axis=0) * unit, corners.max(axis=0) * unit
        ours_lo, ours_hi = (np.min([b["from_mm"] for b in bodies], axis=0), np.max([np.add(b["from_mm"], b["size_mm"]) for b in bodies], axis=0))
        slack = 1e-3 * float(np.max(hi - lo))
        if np.any(ours_lo > lo + slack) or np.any(ours_hi < hi - slack):
            raise Wrong(f"from {ours_lo} to {ours_hi}, which vertices from {lo} to {hi} are not in")


def has_level_sets(file: Path) -> bool:
    with zipfile.ZipFile(file) as package:
        return any(b"levelset" in package.read(name) for name in package.namelist() if name.endswith(".model"))


SUITES = [
    Suite("3mf-samples", "3mf-samples", frozenset({".3mf"}), "mesh", "trimesh"),
    Suite("lib3mf, test files", "lib3mf", frozenset({".3mf", ".stl"}), "mesh", "trimesh"),
    Suite("glTF-Validator, tests", "glTF-Validator", frozenset({".gltf", ".glb"}), "mesh", "trimesh"),
    Suite("trimesh, models", "trimesh", frozenset(MESHES), "mesh", "trimesh"),
    Suite("Assimp, models", "assimp", frozenset(MESHES), "mesh", "trimesh"),
    Suite("lib3mf_rust, test files", "lib3mf_rust", frozenset({".3mf", ".stl", ".obj"}), "mesh", "trimesh"),
    Suite("Gladius, its models", "gladius", frozenset({".3mf"}), "functions", "`tests/import/implicit.py`"),
    Suite("stepcode, STEP", "stepcode", frozenset({".stp", ".step"}), "step", "the text of the file"),
    Suite("Compact-ICC-Profiles", "Compact-ICC-Profiles", frozenset({".icc"}), "profile", "Little CMS, by Pillow"),
    Suite("iccDEV, `Testing`", "iccDEV", frozenset({".icc"}), "profile", "Little CMS, by Pillow"),
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
    except Exception as problem:  # whatever is neither refused nor unread is wrong
        return outcome_of(problem)
    return outcome_of(None)


def looks_rows(root: Path, bin_folder: Path) -> Iterator[tuple[str, list[tuple[str, str, str]], float]]:
    """Yields the rows of MaterialX' own looks: each document as `openfab import` takes it, each material, and each value."""
    import looks

    began = time.monotonic()
    found = looks.Suite(root, bin_folder).run()
    seconds = time.monotonic() - began
    for kind, name in (("document", "MaterialX, `Materials`, documents"), ("material", "their materials"), ("value", "values of these, and outputs of graphs")):
        kinds = (kind, "output") if kind == "value" else (kind,)
        yield name, [(what, *outcome_of(problem)) for kept, what, problem in found if kept in kinds], seconds if kind == "value" else 0


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

    def add(name: str, folder: Path, found: list[tuple[str, str, str]], seconds: float, other: str) -> None:
        nonlocal any_wrong
        for what, outcome, why in found:
            if outcome != "as expected":
                print(f"{outcome}: {folder.name}/{what}: {why}", flush=True)
        outcomes = collections.Counter(outcome for _, outcome, _ in found)
        any_wrong |= outcomes["wrong"] > 0
        figures = [str(outcomes[o]) for o in ("as expected", "refused", "wrong", "not compared")]
        rows.append(f"| {name} | {version_of(folder)[:8]} | {len(found)} | {' | '.join(figures)} | {seconds:.0f} | {other} |")

    for suite in SUITES:
        folder = options.folder / suite.folder
        if not folder.is_dir() or (options.suites and suite.folder not in options.suites):
            continue
        began = time.monotonic()
        files = sorted(f for f in folder.rglob("*") if f.suffix.lower() in suite.ends and f.is_file())
        found = [(str(file.relative_to(folder)), *try_file(getattr(reader, suite.compare), file)) for file in files]
        add(suite.name, folder, found, time.monotonic() - began, suite.other)
    folder = options.folder / "MaterialX"
    if folder.is_dir() and (not options.suites or "MaterialX" in options.suites):
        for name, found, seconds in looks_rows(folder, options.bin.resolve()):
            add(name, folder, found, seconds, "MaterialX' GLSL, on Mesa")
    print("\n".join(rows))
    return 1 if any_wrong else 0


if __name__ == "__main__":
    sys.exit(main())
