#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Public collections of scans and fields through `openfab texture --volume`, each file against another reader.

    tests/suites/scans.py FOLDER [SUITE ...] [--program build/optional/bin/openfab-texture]

FOLDER receives a clone of each suite at the commit below, unless it is there; nothing of them is kept in this
repository. Each file is as expected (the numbers of the other reader, in the same place), refused with a message, or
wrong. Prints a line for each file that is not as expected, then a row of docs/conformance.md for each suite; fails if
any is wrong. Needs numpy, pydicom, nibabel, tifffile, imagecodecs, SimpleITK, Pillow, pylibjpeg with
its parts libjpeg and openjpeg, and pyjpegls from PyPI.
"""

from __future__ import annotations

import argparse
import re
import struct
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Callable, NamedTuple

import nibabel
import numpy as np
import pydicom
import SimpleITK
import tifffile
from PIL import Image

SUITES = {
    "pydicom": ("pydicom/pydicom", "fb1f24e4f0418008757766d8e79ec92dc2ab9855"),
    "pydicom-data": ("pydicom/pydicom-data", "b0d40d1e0a42c5696936043bbd8059984259cd33"),
    "dcm_qa": ("neurolabusc/dcm_qa", "4f85d067c8b61d12cec1689f8516cc30cd583d65"),
    "dcm_qa_nih": ("neurolabusc/dcm_qa_nih", "d302d6e241dda747b79ee1724ada3200179755a2"),
    "nibabel": ("nipy/nibabel", "4704d904b1bd50edb4c2429db1ab8cecd3e4ec2a"),
    "libtiff": ("libsdl-org/libtiff", "c09bb267ca6fbc66ae0b18be05fffd5c4d3ebf3b"),
    "teem": ("Slicer/teem", "e4746083c0e1dc0c137124c41eca5d23adf73bfa"),
    "pynrrd": ("mhe/pynrrd", "96bf87b78bde03987c09346ceffe0bb85a8f4214"),
    "vtk-data": ("pyvista/vtk-data", "126ee906165a8b2f984f08259a4a2d32cf3b3409"),
}
FAX = (2, 3, 4)  # compressions of TIFF; white is their lowest number
NEAR = 1e-5  # of the range of the values
TO_PATIENT = np.diag([-1, -1, 1, 1])  # from x to the right and y to the front, as NIfTI has them, to DICOM's


class Refused(Exception):
    """The converter's message."""


class Unread(Exception):
    """The other reader's message: there is nothing to compare with."""


class Volume(NamedTuple):
    values: np.ndarray  # by z, y, x and channel
    origin: np.ndarray  # the lowest corner, mm
    extent: np.ndarray


def convert(program: Path, file: Path, *options: str) -> Volume:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "a.oftx"
        command = [str(program), str(file), "--volume", "-o", str(out), *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        if done.returncode == 1:
            raise Refused(done.stderr.strip().replace("\n", "; "))
        if done.returncode != 0:
            raise RuntimeError(f"code {done.returncode}: {done.stderr}")
        data = out.read_bytes()
    channels, width, height, _, depth = struct.unpack_from("<5i", data, 12)
    texels = struct.unpack_from("<q", data, 40)[0]
    place = np.array(struct.unpack_from("<6f", data, 72))
    values = np.frombuffer(data, np.float32, channels * width * height * depth, texels)
    return Volume(values.reshape(depth, height, width, channels), place[:3], place[3:])


def same(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and np.abs(a - b).max() <= NEAR * max(1e-30, np.abs(b).max())


def same_in_place(volume: Volume, source: np.ndarray, affine: np.ndarray) -> bool:
    """Compares each texel between centres of the source (i, j, k, channel) with the source, linear between them."""
    depth, height, width, channels = volume.values.shape
    if channels != source.shape[3]:
        return False
    step = volume.extent / (width, height, depth)
    sides = np.array(source.shape[:3])
    inverse = np.linalg.inv(affine)
    seen, worst = 0, 0.0
    for k in range(depth):
        y, x = np.mgrid[:height, :width]
        at = np.stack([x, y, np.full_like(x, k)], -1) + 0.5
        index = (volume.origin + at * step) @ inverse[:3, :3].T + inverse[:3, 3]
        near = np.abs(index - np.round(index)) < NEAR * sides  # the place is of floats
        if np.all(near):  # texel by texel, not interpolated
            index = np.round(index)
        inside = np.all((index >= -NEAR * sides) & (index <= sides - 1 + NEAR * sides), -1)
        index = np.clip(index, 0, sides - 1)
        low = np.minimum(np.floor(index[inside]).astype(int), np.maximum(sides - 2, 0))
        part = index[inside] - low
        wanted = np.zeros((len(low), channels))
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, part, 1 - part), -1)[:, None]
            wanted += weight * source[tuple(np.minimum(low + corner, sides - 1).T)]
        if len(low):
            worst = max(worst, np.abs(wanted - volume.values[k][inside]).max())
        seen += len(low)
    return seen > 0 and worst <= NEAR * max(np.ptp(source), np.abs(source).max() * 1e-2, 1e-30)


def tiff(program: Path, file: Path) -> bool:
    volume = convert(program, file, "--space", "linear", "--spacing", "1,1,1")
    if "loop" in file.name:
        raise Unread("tifffile follows its pages in a circle")
    try:
        with tifffile.TiffFile(file) as opened:
            first = opened.pages[0]
            pages = np.stack([p.asarray() for p in opened.pages if p.shape == first.shape and not p.is_reduced])
            if first.axes.startswith("S"):
                pages = np.moveaxis(pages, 1, -1)
            most = (1 << first.bitspersample) - 1
            if first.compression in FAX:  # of which tifffile's codec stops at some rows
                pages = ~np.array(Image.open(file))[None]
    except Exception as error:  # whatever it does not read
        raise Unread(str(error)) from error
    small = pages.dtype.kind == "u" and pages.dtype.itemsize <= 2
    pages = pages / most if small else pages.astype(float)
    return same(volume.values, pages.reshape(volume.values.shape) if pages.size == volume.values.size else pages)


def dicom(program: Path, file: Path) -> bool:
    volume = convert(program, file, "--outside", "0")
    data = pydicom.dcmread(file, force=True)
    try:
        stored = data.pixel_array.astype(float)
    except Exception as error:  # whatever it does not decode
        raise Unread(str(error)) from error
    for groups in data.get("SharedFunctionalGroupsSequence", []), data.get("PerFrameFunctionalGroupsSequence", [])[:1]:
        for group in (g for item in groups for s in item if s.VR == "SQ" for g in s.value):  # of the first frame
            for element in group:
                data.add(element)
    slope = data.get("DoseGridScaling", data.get("RescaleSlope", 1))
    pixels = stored * float(slope) + float(data.get("RescaleIntercept", 0))
    pixels = pixels.reshape(-1, *pixels.shape[-2:])[..., None]
    if "ImagePositionPatient" not in data:
        return same(volume.values, pixels)
    across, down = np.array(data.ImageOrientationPatient, float).reshape(2, 3)
    places = [g.PlanePositionSequence[0].ImagePositionPatient for g in data.get("PerFrameFunctionalGroupsSequence", [])]
    normal = np.cross(across, down)
    along = [np.dot(np.subtract(place, places[0]).astype(float), normal) for place in places]
    offsets = np.array(along or data.get("GridFrameOffsetVector", [0]), float)[: len(pixels)]
    order = np.argsort(offsets)
    thick = offsets[order[1]] - offsets[order[0]] if len(offsets) > 1 else float(data.get("SliceThickness", 1) or 1)
    affine = np.eye(4)
    affine[:3, 0], affine[:3, 1] = across * data.PixelSpacing[1], down * data.PixelSpacing[0]
    affine[:3, 2] = np.cross(across, down) * thick
    affine[:3, 3] = np.array(data.ImagePositionPatient, float) + np.cross(across, down) * offsets[order[0]]
    if len(pixels) == 1 and np.abs(np.cross(across, down)).max() < 1 - 1e-4:
        raise Unread("one slice that is turned: no texel lies in its plane")
    return same_in_place(volume, np.transpose(pixels[order], (2, 1, 0, 3)), affine)


def nifti(program: Path, file: Path) -> bool:
    image = nibabel.load(file)
    several = image.ndim > 3 and image.shape[3] > 1
    volume = convert(program, file, *(["--field", "0"] if several else []), "--outside", "0")
    values = image.get_fdata()
    values = values[..., 0] if several else values.reshape(values.shape[:3])
    if image.header["sform_code"] == 0 and image.header["qform_code"] == 0:
        return same(volume.values, np.transpose(values)[..., None])  # it does not say where it lies
    return same_in_place(volume, np.nan_to_num(values)[..., None], image.affine)


def nrrd(program: Path, file: Path) -> bool:
    volume = convert(program, file)
    head = file.read_bytes()[:2000] if file.suffix == ".mhd" else b""
    stated = re.search(rb"CompressedDataSize *= *(\d+)\s.*ElementDataFile *= *(\S+)", head, re.DOTALL)
    if stated and int(stated[1]) < (file.parent / stated[2].decode()).stat().st_size:
        raise Unread("SimpleITK ends where CompressedDataSize does, before the numbers, and leaves the rest 0")
    try:
        image = SimpleITK.ReadImage(str(file))
    except RuntimeError as error:
        raise Unread(str(error).splitlines()[-1]) from error
    values = SimpleITK.GetArrayFromImage(image)
    bits = 8 * values.dtype.itemsize
    unit = (1 << bits) - 1 if file.suffix in (".nrrd", ".nhdr") and values.dtype.kind == "u" and bits <= 16 else 1
    return same(volume.values, (values.astype(float) / unit).reshape(volume.values.shape))


def series(program: Path, folder: Path) -> bool:
    """Slices, the first of each place, against what dcm2niix made of them."""
    with tempfile.TemporaryDirectory() as kept:
        places, number = set(), 0
        files = [f for f in folder.iterdir() if f.is_file() and f.read_bytes()[128:132] == b"DICM"]
        heads = sorted(((pydicom.dcmread(f, stop_before_pixels=True), f) for f in files), key=lambda h: h[0].get("InstanceNumber", 0))
        for head, file in heads:
            number = head.SeriesNumber
            place = tuple(head.get("ImagePositionPatient", ()))
            if place not in places:
                (Path(kept) / file.name).symlink_to(file.resolve())
            places.add(place)
        volume = convert(program, Path(kept), "--outside", "0")
        root = next(parent for parent in folder.parents if (parent / "Ref").is_dir())
        made = [r for r in root.glob(f"Ref/*_{number}.nii") if len(places) == nibabel.load(r).shape[2]]
        if len(made) != 1:
            raise Unread("there is no reference")
        image = nibabel.load(made[0])
        values = image.get_fdata().reshape(*image.shape[:3], -1)[..., :1]
        return same_in_place(volume, values, TO_PATIENT @ image.affine)


def files_of(suite: str, root: Path) -> list[tuple[Callable[[Path, Path], bool], Path]]:
    kinds = {".dcm": dicom, ".nii": nifti, ".gz": nifti, ".nrrd": nrrd, ".nhdr": nrrd, ".mha": nrrd, ".mhd": nrrd, ".tif": tiff, ".tiff": tiff}
    out = [(kinds[f.suffix], f) for f in sorted(root.rglob("*")) if f.suffix in kinds and f.is_file() and (f.suffix != ".gz" or ".nii" in f.name)]
    if suite.startswith("dcm_qa"):
        folders = sorted({f.parent for f in root.glob("In/**/*") if f.is_file() and f.suffix not in (".txt", ".xlsx")})
        out = [(nifti, f) for f in sorted(root.glob("Ref/*.nii"))] + [(series, folder) for folder in folders]
    return out


def clone(suite: str, root: Path) -> None:
    name, commit = SUITES[suite]
    if root.exists():
        return
    subprocess.run(["git", "init", "-q", str(root)], check=True)
    subprocess.run(["git", "-C", str(root), "fetch", "-q", "--depth", "1", f"https://github.com/{name}", commit], check=True)
    subprocess.run(["git", "-C", str(root), "checkout", "-q", "FETCH_HEAD"], check=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("suites", nargs="*", default=list(SUITES))
    parser.add_argument("--program", type=Path, default=Path("build/optional/bin/openfab-texture"))
    given = parser.parse_args()
    rows, wrong = [], 0
    for suite in given.suites:
        root = given.folder / suite
        clone(suite, root)
        counts = {"as expected": 0, "refused": 0, "wrong": 0, "not compared": 0}
        for compare, file in files_of(suite, root):
            said = ""
            try:
                outcome = "as expected" if compare(given.program, file) else "wrong"
            except Refused as error:
                outcome, said = "refused", str(error)
            except Unread as error:
                outcome, said = "not compared", str(error)
            except Exception as error:  # ours is not one that raises
                outcome, said = "wrong", f"{type(error).__name__}: {error}"
            counts[outcome] += 1
            if outcome != "as expected":
                print(f"{suite}/{file.relative_to(root)}: {outcome}: {said}", flush=True)
        wrong += counts["wrong"]
        rows.append(f"| {suite} | " + " | ".join(str(n) for n in counts.values()) + " |")
    print("\n".join(rows))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
