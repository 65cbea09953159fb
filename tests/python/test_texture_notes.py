# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What converters tell of a texture's file is a warning of each print, also where the texture comes from the cache."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Callable

import numpy as np
import pytest
import pyvista
from conftest import BY_VOLUME

import openfab

NRRD = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\naxis mins: 5 6 7\n\n\x80\x80"


def element(group: int, item: int, kind: str, value: bytes) -> bytes:
    value += (b"\0" if kind in ("UI", "OB", "OW") else b" ") * (len(value) % 2)
    length = struct.pack("<HI", 0, len(value)) if kind in ("OB", "OW") else struct.pack("<H", len(value))
    return struct.pack("<HH", group, item) + kind.encode() + length + value


def inverted_dicom(file: Path) -> None:
    """A slice of 2 x 1 pixels, of which the lower number is shown in white."""
    kind = b"1.2.840.10008.5.1.4.1.1.2"
    meta = element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", kind) + element(2, 3, "UI", b"1.2.3.4")
    meta += element(2, 0x10, "UI", b"1.2.840.10008.1.2.1")
    meta = element(2, 0, "UL", struct.pack("<I", len(meta))) + meta
    data = element(8, 0x16, "UI", kind) + element(0x20, 0xE, "UI", b"1.2.3")
    data += element(0x20, 0x32, "DS", b"0\\0\\0") + element(0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0")
    data += element(0x28, 2, "US", b"\1\0") + element(0x28, 4, "CS", b"MONOCHROME1")
    data += element(0x28, 0x10, "US", b"\1\0") + element(0x28, 0x11, "US", b"\2\0") + element(0x28, 0x30, "DS", b"1\\1")
    for item, value in ((0x100, 16), (0x101, 16), (0x102, 15), (0x103, 0)):
        data += element(0x28, item, "US", struct.pack("<H", value))
    file.write_bytes(bytes(128) + b"DICM" + meta + data + element(0x7FE0, 0x10, "OW", struct.pack("<HH", 1, 0)))


def long_vtkhdf(file: Path) -> None:
    """Integers of which a float does not hold one."""
    from vtkmodules.vtkIOHDF import vtkHDFWriter

    image = pyvista.ImageData(dimensions=(2, 2, 2))
    image.point_data["f"] = np.array([(1 << 24) + 1, 0, 1, 0, 1, 0, 1, 0], np.int64)
    writer = vtkHDFWriter()
    writer.SetFileName(str(file))
    writer.SetInputData(image)
    writer.Write()


CASES: list[tuple[str, str, Callable[[Path], object], str]] = [
    ("mins.nrrd", "", lambda file: file.write_bytes(NRRD), "mins.nrrd: its `axis mins` are left out"),
    ("scan.dcm", "dicom", inverted_dicom, "values are as stored in scan.dcm, which is shown with the lowest in white"),
    ("long.vtkhdf", "hdf5", long_vtkhdf, "its field: some of its integers are rounded"),
]


@pytest.mark.parametrize(("name", "part", "write", "note"), CASES, ids=[case[0] for case in CASES])
def test_notes_of_converters_are_warnings(
    name: str, part: str, write: Callable[[Path], object], note: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENFAB_CACHE", str(tmp_path / "cache"))
    write(tmp_path / name)
    world = openfab.World(printer="generic")
    one, other = openfab.Material("one", "#ffffff"), openfab.Material("other", "#000000")
    field = openfab.Texture.volume(tmp_path / name, wrap="clamp")
    text = BY_VOLUME.replace("field.Sample1(attr.voxelCenter, 0, 0)", "clamp(field.Sample1(attr.voxelCenter, 0, 0), 0, 1)")
    world.add(openfab.box(2, 2, 2), openfab.Fablet(text=text), {"field": field, "one": one, "other": other})
    reader = Path(openfab.__file__).parent / "bin" / f"openfab-texture-{part}"
    if part and not reader.exists():  # a package built without it
        with pytest.raises(openfab.OutsideError, match=f"scripts/setup --{part}"):
            openfab.sample(world, ((-1, -1, 0), (1, 1, 2)), voxel=0.5)
        return
    for _ in range(2):
        with pytest.warns(openfab.PrintWarning, match=note):
            openfab.sample(world, ((-1, -1, 0), (1, 1, 2)), voxel=0.5)
