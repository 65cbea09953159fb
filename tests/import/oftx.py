# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Reads what `openfab texture --volume` makes of a file: core/texture/pyramid_file.h has the layout."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
from conftest import TOOL


class Volume(NamedTuple):
    values: np.ndarray  # by z, y, x and channel
    origin: tuple[float, ...]  # mm
    extent: tuple[float, ...]
    told: str


class Refused(Exception):
    """The converter's error."""


def read(path: Path, told: str = "") -> Volume:
    data = path.read_bytes()
    channels, width, height, _, depth = struct.unpack_from("<5i", data, 12)
    texels = struct.unpack_from("<q", data, 40)[0]
    origin, extent = struct.unpack_from("<3f", data, 72), struct.unpack_from("<3f", data, 84)
    count = channels * width * height * depth
    values = np.frombuffer(data, np.float32, count, texels).reshape(depth, height, width, channels)
    return Volume(values, origin, extent, told)


def volume(file: Path, *options: object) -> Volume:
    """Converts a file. Raises Refused with the message where it is refused, by code 1; any other end fails."""
    out = file.with_name("converted.oftx")
    command = [TOOL.with_name("openfab-texture"), file, "--volume", "-o", out, *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode == 1:
        raise Refused(done.stderr)
    assert done.returncode == 0, done.stderr
    return read(out, done.stderr)
