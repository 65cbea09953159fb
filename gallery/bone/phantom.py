#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the scan of an invented bone: the upper end of a long bone in flesh, in Hounsfield units.

  phantom.py phantom.nrrd     as an NRRD volume, for the world next to it
  phantom.py scan             as a folder of DICOM slices, like a scanner's
"""
import gzip
import math
import struct
import sys
from pathlib import Path

SIDE, SLICES, PITCH_MM = 44, 60, 1.0
AIR, FLESH, MARROW, BONE = -1000, 45, -60, 1250


def smooth(distance):
    """Returns the share of a voxel that lies inside a surface at this distance in mm."""
    return min(max(0.5 - distance / PITCH_MM, 0), 1)


def hounsfield(x, y, z):
    """Returns the value at a point in mm; the axis is x = y = 0, and z goes up from the cut."""
    r = math.hypot(x, y)
    # A shaft that widens into a ball, and the spongy bone in it, whose plates are a third of a cell thick.
    shaft = r - (9 + 0.003 * max(z - 15, 0) ** 2)
    ball = math.hypot(r, 1.1 * (z - 44)) - 14.5
    outside = max(min(shaft, ball) if z < 44 else ball, -30)
    wall = 3.2 - 2 * min(max((z - 12) / 25, 0), 1)
    gyroid = sum(math.sin(a / 1.1) * math.cos(b / 1.1) for a, b in ((x, y), (y, z), (z, x)))
    spongy = 150 + 500 * min(max(0.5 - gyroid, 0), 1)
    inner = MARROW + (spongy - MARROW) * min(max((z - 16) / 14, 0), 1)
    bone = inner + (BONE - inner) * smooth(-outside - wall)
    flesh = AIR + (FLESH - AIR) * smooth(r - 24)
    return round(flesh + (bone - flesh) * smooth(outside))


def volume():
    centre = (SIDE - 1) / 2
    return [[[hounsfield((i - centre) * PITCH_MM, (j - centre) * PITCH_MM, (k + 0.5) * PITCH_MM)
              for i in range(SIDE)] for j in range(SIDE)] for k in range(SLICES)]


def first_mm():
    return (-(SIDE - 1) / 2 * PITCH_MM, -(SIDE - 1) / 2 * PITCH_MM, PITCH_MM / 2)


def write_nrrd(path, slices):
    head = (f"NRRD0005\ntype: int16\ndimension: 3\nsizes: {SIDE} {SIDE} {SLICES}\nendian: little\nencoding: gzip\n"
            f"space directions: ({PITCH_MM},0,0) (0,{PITCH_MM},0) (0,0,{PITCH_MM})\n"
            f"space origin: ({','.join(map(str, first_mm()))})\n\n")
    numbers = b"".join(struct.pack(f"<{SIDE}h", *row) for plane in slices for row in plane)
    path.write_bytes(head.encode() + gzip.compress(numbers, 9, mtime=0))


def element(group, item, kind, value):
    """Returns one element of a DICOM file, explicit and little-endian (PS3.5, 7.1.2)."""
    data = value.encode() if isinstance(value, str) else value
    if len(data) % 2:
        data += b"\0" if kind in ("UI", "OB") else b" "
    head = struct.pack("<HH", group, item) + kind.encode()
    if kind in ("OB", "OW"):
        return head + struct.pack("<HI", 0, len(data)) + data
    return head + struct.pack("<H", len(data)) + data


def write_dicom(folder, slices):
    folder.mkdir(parents=True, exist_ok=True)
    ct, root = "1.2.840.10008.5.1.4.1.1.2", "2.25.1"
    x, y, z = first_mm()
    for k, plane in enumerate(slices):
        instance = f"{root}.{k + 1}"
        meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", ct) + element(2, 3, "UI", instance) +
                element(2, 0x10, "UI", "1.2.840.10008.1.2.1"))
        short = [element(0x28, item, "US", struct.pack("<H", value)) for item, value in
                 ((0x10, SIDE), (0x11, SIDE), (0x100, 16), (0x101, 16), (0x102, 15), (0x103, 0))]
        data = (element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", instance) + element(8, 0x60, "CS", "CT") +
                element(0x10, 0x10, "PN", "PHANTOM") + element(0x18, 0x50, "DS", str(PITCH_MM)) +
                element(0x20, 0x0E, "UI", root) + element(0x20, 0x11, "IS", "1") +
                element(0x20, 0x32, "DS", f"{x}\\{y}\\{z + k * PITCH_MM}") +
                element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + element(0x28, 2, "US", struct.pack("<H", 1)) +
                element(0x28, 4, "CS", "MONOCHROME2") + short[0] + short[1] +
                element(0x28, 0x30, "DS", f"{PITCH_MM}\\{PITCH_MM}") + b"".join(short[2:]) +
                element(0x28, 0x1052, "DS", "-1024") + element(0x28, 0x1053, "DS", "1") +
                element(0x7FE0, 0x10, "OW", b"".join(struct.pack("<H", v + 1024) for row in plane for v in row)))
        length = element(2, 0, "UL", struct.pack("<I", len(meta)))
        (folder / f"slice_{k + 1:03}.dcm").write_bytes(bytes(128) + b"DICM" + length + meta + data)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    target = Path(sys.argv[1])
    (write_nrrd if target.suffix == ".nrrd" else write_dicom)(target, volume())
