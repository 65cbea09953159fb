# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Files that objects of Python are written to, so that one reader serves worlds from everywhere."""

from __future__ import annotations

import os
import struct
import tempfile
import weakref
import zlib
from pathlib import Path
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

_folders: dict[int, tempfile.TemporaryDirectory[str]] = {}
_counts: dict[str, int] = {}
WORLD = ".fab.json"


def folder() -> Path:
    """The process's own temporary folder, removed when it ends; a forked child gets its own."""
    if os.getpid() not in _folders:
        _folders[os.getpid()] = tempfile.TemporaryDirectory(prefix="openfab-")
    return Path(_folders[os.getpid()].name)


def unique(stem: str, suffix: str) -> Path:
    """A name in that folder that nobody has; a world, whose name is its title, is in a folder of its own."""
    _counts[suffix] = _counts.get(suffix, 0) + 1
    if suffix != WORLD:
        return folder() / f"{stem}-{_counts[suffix]}{suffix}"
    own = folder() / f"world-{_counts[suffix]}"
    own.mkdir()
    return own / (stem.replace("/", "_") + suffix)


class OwnedFile:
    """A file that an object is written to when it is first asked for, and that goes with the object."""

    def __init__(self, owner: object, stem: str, suffix: str, write: Callable[[Path], None]) -> None:
        self._name = (stem, suffix)
        self._owner = weakref.ref(owner)
        self._write = write
        self._path: Path | None = None
        self._process = 0

    def path(self) -> Path:
        if self._path is None or self._process != os.getpid():
            path = unique(*self._name)
            self._write(path)
            self._path, self._process = path, os.getpid()
            owner = self._owner()
            assert owner is not None
            weakref.finalize(owner, _remove, path, os.getpid())
        return self._path


def _remove(path: Path, process: int) -> None:
    if process == os.getpid():
        path.unlink(missing_ok=True)
        if path.name.endswith(WORLD) and path.parent.is_dir():
            path.parent.rmdir()


def png(pixels: NDArray[Any], palette: NDArray[np.uint8] | None = None, level: int = 6) -> bytes:
    """Encodes [row][column] or [row][column][1…4] of 8 or 16 bits, top row first, as PNG.

    With a palette of [code][4] the pixels are 8-bit codes.
    """
    pixels = pixels.reshape(*pixels.shape, 1) if pixels.ndim == 2 else pixels
    height, width, channels = pixels.shape
    bits = pixels.dtype.itemsize * 8
    color = 3 if palette is not None else {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = np.ascontiguousarray(pixels.astype(pixels.dtype.newbyteorder(">"))).view(np.uint8).reshape(height, -1)
    lines = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    out = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0))
    if palette is not None:
        out += chunk(b"PLTE", palette[:, :3].tobytes()) + chunk(b"tRNS", palette[:, 3].tobytes())
    return out + chunk(b"IDAT", zlib.compress(lines.tobytes(), level)) + chunk(b"IEND", b"")


def tiff(pixels: NDArray[np.float32]) -> bytes:
    """Encodes [row][column][channel] of floats, top row first, as an uncompressed TIFF."""
    height, width, channels = pixels.shape
    data = np.ascontiguousarray(pixels, "<f4").tobytes()
    short, long = 3, 4
    color = 2 if channels >= 3 else 1  # RGB, or black is zero
    extra = channels - (3 if channels >= 3 else 1)
    per_channel: dict[int, list[int]] = {258: [32] * channels, 339: [3] * channels}  # bits; IEEE floats
    if extra:
        per_channel[338] = [0] * extra
    tags: dict[int, tuple[int, list[int]]] = {
        256: (long, [width]),
        257: (long, [height]),
        259: (short, [1]),
        262: (short, [color]),
        273: (long, [8]),
        277: (short, [channels]),
        278: (long, [height]),
        279: (long, [len(data)]),
        284: (short, [1]),
        **{tag: (short, values) for tag, values in per_channel.items()},
    }
    data += b"\0" * (len(data) % 2)
    at = 8 + len(data)
    entries, more = b"", b""
    behind = at + 2 + 12 * len(tags) + 4
    for tag in sorted(tags):
        kind, values = tags[tag]
        packed = struct.pack(f"<{len(values)}{'H' if kind == short else 'I'}", *values)
        if len(packed) <= 4:
            value = packed.ljust(4, b"\0")
        else:
            value = struct.pack("<I", behind + len(more))
            more += packed + b"\0" * (len(packed) % 2)
        entries += struct.pack("<HHI", tag, kind, len(values)) + value
    return b"II*\0" + struct.pack("<I", at) + data + struct.pack("<H", len(tags)) + entries + b"\0\0\0\0" + more
