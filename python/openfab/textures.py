# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Textures: pictures and volumes, from files and from arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _files
from ._given import Real, array, choice, floats, is_sequence, number, plain, positive, several, vector
from .errors import InputError


class Texture:
    """A picture for a fablet's texture; `Texture.volume` makes a texture from a volume.

    Parameters
    ----------
    picture : str, path or array_like, shape (rows, columns) or (rows, columns, 1 to 4)
        A file, or an array with the top row first, which is copied. 8-bit values are sRGB unless `space` says otherwise;
        16-bit values and floats are linear light. With two or four integers per pixel, the last is alpha.
    wrap : str or sequence of 2 str, optional
        `clamp`, `repeat`, `mirror` or `black`: one mode, or one along u and one along v.
    filter : str, optional
        `trilinear`, `anisotropic` or `nearest`.
    space : str, optional
        The meaning of its numbers: `srgb`, `linear` or `data`; `auto` follows the file.
    channels : str, optional
        `all`, `luminance` or `opaque`.

    Attributes
    ----------
    file : pathlib.Path or None
        The file; None for an array.

    Raises
    ------
    InputError
        If an array has the wrong shape, a value is not finite, or a word is none of these.
    """

    def __init__(
        self, picture: str | os.PathLike[str] | ArrayLike, *, wrap: str | Sequence[str] = "repeat",
        filter: str = "anisotropic", space: str = "auto", channels: str = "all",
    ) -> None:
        keys = {"wrap": wrap, "filter": filter, "space": space, "channels": channels}
        self._keys: dict[str, Any] = plain(keys, "a texture")
        _check_choices(self._keys)
        self._array: NDArray[Any] | None = None
        if isinstance(picture, (str, os.PathLike)):
            self._own_file(Path(os.fsdecode(picture)).absolute(), "")
            return
        found = _texels(picture, "a picture")
        pixels = found[:, :, None] if found.ndim == 2 else found
        if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4 or not pixels.size:
            raise InputError(f"a picture has the shape {found.shape}; it should be (rows, columns[, 1 to 4])")
        self._array = pixels
        self._own_file(None, ".tif" if pixels.dtype.kind == "f" else ".png")

    def _own_file(self, file: Path | None, suffix: str) -> None:
        self.file = file
        self._suffix = suffix
        self._file: _files.OwnedFile | None = None
        if (texels := self._array) is not None:
            stem, keys = "volume" if suffix == ".npy" else "picture", self._keys
            self._file = _files.OwnedFile(self, stem, suffix, lambda path: _write_texels(path, texels, keys))

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key != "_file"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._own_file(self.file, self._suffix)

    @classmethod
    def volume(
        cls, volume: str | os.PathLike[str] | ArrayLike, *, origin_mm: Sequence[Real] | None = None,
        spacing_mm: Real | Sequence[Real] | None = None, field: str | None = None, unit: str | None = None,
        pitch_mm: Real | None = None, outside: Real | None = None, wrap: str = "clamp", filter: str = "trilinear",
        time: Real | None = None, segment: str | int | None = None, echo: Real | None = None,
        detector: Real | None = None, energy_window: Real | None = None, phase: Real | None = None,
    ) -> Texture:
        """Makes a texture from a volume.

        Parameters
        ----------
        volume : str, path or array_like, shape (z, y, x) or (z, y, x, 1 to 4)
            A file, or an array with its first value at the lowest corner, which is copied. Unsigned integers of 8 and 16
            bits are scaled to 0 to 1.
        origin_mm : sequence of 3 floats, optional
            The lowest corner in part space, in mm. Default: as given in the file, or 0.
        spacing_mm : float or sequence of 3 floats, optional
            The size of a texel along x, y and z, in mm. Default: as given in the file, or 1.
        field : str, optional
            The name of the field to read, if the file has several.
        unit : str, optional
            The unit of the file's lengths: mm, cm, m, um or in.
        pitch_mm : float, optional
            The distance of samples in a file of cells, in mm.
        outside : float, optional
            The value where a file has no data, or an array has NaN.
        wrap : str, optional
            `clamp`, `repeat`, `mirror` or `black`.
        filter : str, optional
            `trilinear` or `nearest`.
        time : float, optional
            Which step of an XDMF file, or which time of DICOM frames.
        segment : str or int, optional
            Which segment of a DICOM segmentation, by its label or number.
        echo, detector, energy_window, phase : float, optional
            Which of several kinds of frames of DICOM.

        Returns
        -------
        Texture
            A texture for uniforms of type `ImageTexture3D`.

        Raises
        ------
        InputError
            If an array has the wrong shape, a value is not finite and `outside` is not given, or a word is none of these.
        """
        frames = {"time": time, "echo": echo, "detector": detector, "energy_window": energy_window, "phase": phase}
        if isinstance(volume, (str, os.PathLike)):
            self = cls(volume, wrap=wrap, filter=filter)
        else:
            given = {"field": field, "unit": unit, "pitch_mm": pitch_mm, "segment": segment, **frames}
            wrong = [f"`{key}`" for key, value in given.items() if value is not None]
            if wrong:
                raise InputError(f"{', '.join(wrong)} of a volume: an array has none; files that hold fields do")
            self = cls.__new__(cls)
            self._keys = plain({"wrap": wrap, "filter": filter}, "a texture")
            _check_choices(self._keys)
            texels = _texels(volume, "a volume", None if outside is None else number(outside, "`outside`"))
            outside = None  # which is in the array by now
            if texels.ndim not in (3, 4) or not texels.size or texels.shape[3:] not in ((), (1,), (2,), (3,), (4,)):
                raise InputError(f"a volume has the shape {texels.shape}; it should be (z, y, x[, 1 to 4])")
            self._array = texels
            self._own_file(None, ".npy")
        if origin_mm is not None:
            self._keys["origin_mm"] = vector(origin_mm, "`origin_mm`")
        if spacing_mm is not None:
            one = [spacing_mm] * 3 if not is_sequence(spacing_mm) else spacing_mm
            self._keys["spacing_mm"] = [positive(one, "`spacing_mm`") for one in vector(one, "`spacing_mm`")]
        if pitch_mm is not None:
            self._keys["pitch_mm"] = positive(pitch_mm, "`pitch_mm`")
        if outside is not None:
            self._keys["outside"] = number(outside, "`outside`")
        self._keys.update({key: number(value, f"`{key}`") for key, value in frames.items() if value is not None})
        texts = {"field": field, "unit": unit, "segment": None if segment is None else str(segment)}
        self._keys.update({key: plain(value, f"`{key}`") for key, value in texts.items() if value is not None})
        return self

    def _spec(self) -> dict[str, Any]:
        path = self._file.path() if self._file is not None else self.file
        assert path is not None
        return {"file": str(path), **self._keys}


_CHOICES = {
    "wrap": ("clamp", "repeat", "mirror", "black"),
    "filter": ("trilinear", "anisotropic", "nearest"),
    "space": ("auto", "srgb", "linear", "data"),
    "channels": ("all", "luminance", "opaque"),
}


def _check_choices(keys: Mapping[str, Any]) -> None:
    for key, value in keys.items():
        every = several(value, f"`{key}`", (1, 2), "one along u and one along v") if isinstance(value, list) else [value]
        for one in every:
            choice(one, f"`{key}` of a texture", _CHOICES[key])


def _texels(values: ArrayLike, what: str, outside: float | None = None) -> NDArray[Any]:
    """Returns texels of 8 or 16 bits, or finite floats, with NaN replaced by `outside` if that is given."""
    given = array(values, what)
    if given.dtype in (np.uint8, np.uint16):
        return given
    if given.dtype.kind == "f" and np.isnan(given).any():
        if outside is None and what == "a volume":
            place = ", ".join(str(int(one)) for one in np.argwhere(np.isnan(given))[0])
            raise InputError(
                f"{what} has nan at [{place}]; its values should be finite, or `outside` says what they are where they are none"
            )
        given = np.where(np.isnan(given), np.nan if outside is None else outside, given)
    return floats(given, what)


def _write_texels(path: Path, texels: NDArray[Any], keys: Mapping[str, Any]) -> None:
    """Writes an array as a file for a world, and the converted file that the first print would make."""
    if path.suffix == ".npy":
        np.save(path, texels)
        _core.keep_volume(path, np.ascontiguousarray(texels), keys.get("origin_mm"), keys.get("spacing_mm"))
        return
    linear = texels.dtype.itemsize == 2
    data = _files.tiff(texels) if path.suffix == ".tif" else _files.png(texels, level=1, linear=linear)
    path.write_bytes(data)
    # One with alpha needs the converter.
    if texels.shape[2] in (1, 3) and keys["channels"] != "opaque":
        _core.keep_picture(path, np.ascontiguousarray(texels), keys["space"], keys["channels"] == "luminance")
