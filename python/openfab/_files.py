# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Temporary files for Python objects, so that one reader serves worlds of every origin."""

from __future__ import annotations

import os
import shutil
import struct
import tempfile
import threading
import weakref
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import OutsideError

WORLD = ".fab.json"

_folder: Path | None = None
_counts: dict[str, int] = {}
# Held while files are made, and while a world is changed or read; reentrant, since reading a world makes files.
lock = threading.RLock()


def folder() -> Path:
    """Returns the temporary folder of this process, which is removed when it ends; a forked child gets its own."""
    global _folder
    with lock:
        if _folder is None:
            with outside_errors("a temporary folder cannot be made"):
                _folder = Path(tempfile.mkdtemp(prefix="openfab-"))
            # Runs at the end of this process only, including processes of multiprocessing, which atexit does not see.
            Finalize(None, shutil.rmtree, (_folder, True), exitpriority=0)
        return _folder


@contextmanager
def outside_errors(what: str) -> Iterator[None]:
    """Raises failures of the file system as OutsideError."""
    try:
        yield
    except OSError as error:
        raise OutsideError(f"{what}: {error.strerror or error}") from error


def _forget() -> None:
    """Leaves the parent's files to the parent; a thread that no longer exists may have held its lock."""
    global _folder, lock
    _folder, lock = None, threading.RLock()
    _counts.clear()


os.register_at_fork(after_in_child=_forget)


def file_name(text: str) -> str:
    """Returns a valid file name that resembles any text."""
    safe = "".join("_" if one in "/\0" else one for one in text).encode("utf-8", "replace")
    return safe[:_LONGEST_NAME].decode("utf-8", "ignore") if safe not in (b"", b".", b"..") else "unnamed"


# A file system allows 255 bytes; suffixes and counts follow.
_LONGEST_NAME = 180


def unique(stem: str, suffix: str) -> Path:
    """Returns an unused name in that folder. A world, whose file name is its title, gets a folder of its own."""
    with lock:
        _counts[suffix] = _counts.get(suffix, 0) + 1
        if suffix != WORLD:
            return folder() / f"{file_name(stem)}-{_counts[suffix]}{suffix}"
        own = folder() / f"world-{_counts[suffix]}"
        with outside_errors(f"`{own}` cannot be made"):
            own.mkdir()
        return own / (file_name(stem) + suffix)


def remove_with(owner: object, path: Path) -> None:
    """Removes a file when its owner is destroyed."""
    weakref.finalize(owner, _remove, path, folder())


def _remove(path: Path, made_in: Path) -> None:
    if made_in == _folder:
        path.unlink(missing_ok=True)
        if path.name.endswith(WORLD) and path.parent.is_dir():
            path.parent.rmdir()


class OwnedFile:
    """A file with an object's data, written on first use and removed together with the object.

    It is never rewritten, so prints may read it at any time while they hold the object.
    """

    def __init__(self, owner: object, stem: str, suffix: str, write: Callable[[Path], None]) -> None:
        self._name = (stem, suffix)
        self._owner = weakref.ref(owner)
        self._write = write
        self._path: Path | None = None

    def path(self) -> Path:
        with lock:
            if self._path is None or self._path.parent != folder():
                path = unique(*self._name)
                owner = self._owner()
                assert owner is not None
                remove_with(owner, path)
                with outside_errors(f"`{path}` cannot be written"):
                    self._write(path)
                self._path = path
            return self._path


def png(
    pixels: NDArray[Any], palette: NDArray[np.uint8] | None = None, level: int = 6, linear: bool = False
) -> bytes:
    """Encodes [row][column] or [row][column][1…4] of 8 or 16 bits, top row first, as PNG.

    With a palette of [code][4], the pixels are 8-bit codes. `linear` means that values are linear light, not sRGB.
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
    if linear:
        out += chunk(b"gAMA", struct.pack(">I", 100_000))
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
