# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The input files of a print as bytes, for workers without a shared file system."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core, _files
from .._options import options_of
from .._snapshot import Snapshot, dither_rule
from ..errors import check_diagnostics, raise_error

Blob = NDArray[np.uint8]

# Marks the folder below which sources may import others, as in a project of the user's.
_PROJECT = "openfab.project"


@dataclass(frozen=True)
class Inputs:
    """The files of a print, by their paths below the folder in which a worker unpacks them.

    The world is separate from its files, so that another world with the same meshes sends only itself.
    """

    world: str
    description: bytes
    files: dict[str, Blob]
    sources: tuple[str, ...]
    digest: str
    """Of the files, places and contents."""
    paths: tuple[Path, ...]
    """Where they are here."""
    names: dict[str, str]
    """What messages call them."""

    @property
    def bytes(self) -> int:
        """The amount of data sent to each worker."""
        return len(self.description) + sum(blob.nbytes for blob in self.files.values())


def gather(world: Snapshot, fields: Mapping[str, Any]) -> Inputs:
    """Reads all files of a print; raises their errors.

    `fields` are fields of Options, which may name a printer's file.
    """
    file, sources = world.path, world.sources
    options = options_of(world.fields, fields)
    names = _core.world_files(options)
    if isinstance(names, _core.Error):
        raise_error(names, world.names)
    read: dict[str, Path] = {}
    rule = dither_rule(options)
    for path in [*names[1:], *_imported([*sources, *([Path(rule[0])] if rule else [])])]:
        read.setdefault(place(path), Path(path))
    files = {name: np.fromfile(read[name], np.uint8) for name in sorted(read)}
    digest = hashlib.sha256()
    for name, blob in files.items():
        digest.update(f"{name}\0{blob.nbytes}\0".encode())
        digest.update(blob.data)
    home = place(file)
    if home.startswith("made"):
        home = f"made/world/{file.name}"  # each print has a file of its own, but workers keep what they set up
    described = _relative(world.description, os.path.dirname(home), set(files))
    return Inputs(
        home, json.dumps(described).encode(), files, tuple(place(source) for source in sources), digest.hexdigest(),
        (Path(file), *read.values()), {f"{_files.folder()}/world/{file.name}": str(file), **world.names},
    )


def _imported(sources: Iterable[Path]) -> list[Path]:
    """Returns fablets, dither rules and the modules that they import; modules of the standard library have no files."""
    found: list[Path] = []
    for source in sources:
        interface = _core.read_file_interface(source)
        check_diagnostics(interface.diagnostics)
        found += [path for path in interface.files if path.is_file()]
    return found


def place(path: str | os.PathLike[str]) -> str:
    """Returns the path of a file below a worker's folder: the same as here, except for temporary files of this process."""
    absolute = os.path.abspath(path)
    made = str(_files.folder())
    return "made" + absolute[len(made) :] if absolute.startswith(made + os.sep) else "files" + absolute


def _relative(value: Any, home: str, files: set[str]) -> Any:
    """Returns a world with absolute file names made relative to it."""
    if isinstance(value, dict):
        return {key: _relative(one, home, files) for key, one in value.items()}
    if isinstance(value, list):
        return [_relative(one, home, files) for one in value]
    if isinstance(value, str) and os.path.isabs(value):
        there = place(value)
        # A series of slices is named by its folder, or by a pattern of names in it.
        folders = (there + os.sep, os.path.dirname(there) + os.sep)
        if there in files or any(name.startswith(folders) for name in files):
            return os.path.relpath(there, home)
    return value


def of_workers(world: Snapshot, fields: Mapping[str, Any]) -> dict[str, Any]:
    """Returns fields of Options for a worker, with a printer's file at its path there, and programs if they may run."""
    printer = fields.get("printer", "")
    return {
        **fields, "printer": place(printer) if printer.endswith(".json") else printer,
        "allow": [word for word in world.allowed if word == _core.PROGRAMS_WORD],
    }


def unpack(folder: Path, files: dict[str, Blob], world: str, description: bytes) -> Path:
    """Writes the files below a folder, except those that exist; returns the world."""
    if not folder.is_dir():
        begun = folder.with_suffix(".part")
        for name, blob in files.items():
            path = begun / name
            path.parent.mkdir(parents=True, exist_ok=True)
            blob.tofile(path)
        begun.mkdir(parents=True, exist_ok=True)
        (begun / _PROJECT).touch()
        begun.rename(folder)
    path = folder / world
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(description)
    return path
