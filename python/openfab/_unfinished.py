# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Outputs that appear only once they are complete."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from ._files import outside_errors

class Unfinished:
    """A temporary file or folder next to an output, which replaces the output once it is complete.

    `name` is empty if none is needed: for the standard output, addresses, pipes and devices; for a store of Zarr, for an existing folder,
    whose slices are replaced one by one; and for outputs that the print refuses. A link is followed.
    """

    def __init__(self, output: str) -> None:
        self._output = output
        self._folder: Path | None = None
        self.name = ""

    @property
    def names(self) -> dict[str, str]:
        """The name for messages, by the temporary name."""
        return {self.name: self._output} if self.name else {}

    def __enter__(self) -> Unfinished:
        if self._output in ("", "-") or self._output.startswith(("tcp://", "tls://", "unix:")):
            return self
        place = Path(os.path.realpath(self._output))
        if place.suffix == ".zarr":  # others may fill the same store, which is whole shard by shard
            return self
        slash = os.sep if self._output.endswith(os.sep) else ""  # which says that it is a folder
        if not place.parent.is_dir() or (place.exists() and (slash or not place.is_file())):
            return self
        with outside_errors(f"`{self._output}` cannot be written"):
            self._folder = Path(tempfile.mkdtemp(prefix=f".{place.name[:40]}.tmp-", dir=place.parent))
        self.name = str(self._folder / Path(self._output).name) + slash
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._folder is None:
            return
        try:
            if kind is None:
                with outside_errors(f"`{self._output}` cannot be written"):
                    for made in self._folder.iterdir():
                        shutil.move(made, os.path.realpath(Path(self._output).parent / made.name))
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)
