# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Outputs for shares: files, folders, receivers, and remote files through fsspec."""

from __future__ import annotations

import importlib
import json
import os
import shutil
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from .. import _core
from .._options import options_of
from .._unfinished import Unfinished
from ..errors import InputError, OutsideError, raise_error
from .worker import Plan, Shared

_RECEIVERS = ("tcp://", "tls://", "unix:")
_CHUNK_BYTES = 1 << 20


class Output:
    """The output of a print, with a single writer; a previous output stays until the print is complete."""

    def __init__(self, out: str | os.PathLike[str], fields: Mapping[str, Any], printer: str) -> None:
        self._name = os.fsdecode(out)
        self._printer = printer
        self._remote = "://" in self._name and not self._name.startswith(_RECEIVERS)
        name = self._name.rstrip("/").rsplit("/", 1)[-1] if self._remote else self._name
        self._fields = {**fields, "input": "world.fab.json"}
        found = _core.output_format(self._options(name), printer)
        if isinstance(found, _core.Error):
            raise_error(found)
        self.format: str = found
        self._stack = ExitStack()
        self._writer: Any = None
        self._names: dict[str, str] = {}
        self._transfer: _Stream | _Folder | None = None

    def open(self, plan: Plan, inputs: Sequence[Path]) -> None:
        """Opens the output; fails if it would overwrite an input."""
        name, instead = self._name, ""
        if self._remote:
            is_file = self.format == "ofr"
            name = "-" if is_file else "slices"
            self._transfer = (_Stream if is_file else _Folder)(self._name)
            instead = str(self._stack.enter_context(self._transfer))
        else:
            unfinished = self._stack.enter_context(Unfinished(self._name))
            instead, self._names = unfinished.name, unfinished.names
        writer = _core.open_writer(
            self._options(name), instead, self._printer, plan.header, plan.info["support_code"], list(inputs)
        )
        if isinstance(writer, _core.Error):
            raise_error(writer, self._names)
        self._writer = writer

    def _options(self, name: str) -> _core.Options:
        return options_of(self._fields, {"output": name})

    @property
    def next_slice(self) -> int:
        """The first slice that has not been written yet."""
        following: int = self._writer.next_slice
        return following

    def write(self, share: Shared) -> None:
        """Writes the slices of a share, and waits for the output."""
        error = self._writer.write(share.slices, share.lengths, share.totals)
        if self._transfer is not None:
            self._transfer.written(error)
        if error is not None:
            raise_error(error, self._names)

    def finish(self) -> dict[str, Any]:
        """Completes the output; returns its statistics."""
        error = self._writer.finish()
        if self._transfer is not None:
            self._transfer.finished(error)
        if error is not None:
            raise_error(error, self._names)
        statistics: dict[str, Any] = json.loads(self._writer.statistics)
        return statistics

    def __enter__(self) -> Output:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: Any) -> None:
        self._writer = None  # which closes it, unfinished where it is
        self._stack.__exit__(kind, error, trace)


def _file_system(url: str) -> tuple[Any, str]:
    try:
        fsspec: Any = importlib.import_module("fsspec")
        return fsspec.core.url_to_fs(url, skip_instance_cache=True)  # type: ignore[no-any-return]
    except ImportError as error:
        raise InputError(f"`{url}` cannot be written: {error}") from error
    except ValueError as error:
        raise InputError(f"`{url}` is no output: {error}") from error


class _Stream:
    """A pipe to a remote file, which appears once it is complete."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._fs, self._path = _file_system(url)
        self._fault: BaseException | None = None

    def __enter__(self) -> Path:
        try:
            # What is written in a transaction is there, or in the place of what was, at its end.
            self._fs.start_transaction()
            self._open = True
            self._file = self._fs.open(self._path, "wb")
        except OSError as error:
            raise OutsideError(f"`{self._url}` cannot be written: {error}") from error
        self._reader, self._ours = os.pipe()
        self._thread = threading.Thread(target=self._copy, daemon=True)
        self._thread.start()
        return Path(f"/dev/fd/{self._ours}")

    def _copy(self) -> None:
        try:
            while data := os.read(self._reader, _CHUNK_BYTES):
                self._file.write(data)
            self._file.close()
        except BaseException as fault:
            self._fault = fault
        finally:
            os.close(self._reader)  # the writer hears of it

    def written(self, error: _core.Error | None) -> None:
        if error is not None and self._fault is not None:
            raise OutsideError(f"`{self._url}` cannot be written: {self._fault}") from self._fault

    def finished(self, error: _core.Error | None) -> None:
        self._close()
        if self._fault is not None:
            raise OutsideError(f"`{self._url}` cannot be written: {self._fault}") from self._fault
        if error is None:
            self._complete(commit=True)

    def _close(self) -> None:
        if self._ours >= 0:
            os.close(self._ours)
            self._ours = -1
        self._thread.join()

    def __exit__(self, *_: object) -> None:
        self._close()
        if self._open:
            self._complete(commit=False)

    def _complete(self, commit: bool) -> None:
        self._open = False
        try:
            self._fs.transaction.complete(commit)
        except OSError as error:
            raise OutsideError(f"`{self._url}` cannot be written: {error}") from error


class _Folder:
    """A local folder whose files are moved to a remote one as they are made."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._fs, self._path = _file_system(url)

    def __enter__(self) -> Path:
        try:
            # Without its parents: a bucket whose name is mistyped would be made, too.
            if not self._fs.isdir(self._path):
                self._fs.mkdir(self._path, create_parents=False)
        except OSError as error:
            raise OutsideError(f"`{self._url}` cannot be written: {error}") from error
        self._made = Path(tempfile.mkdtemp(prefix="openfab-"))
        return self._made / "slices"

    def written(self, error: _core.Error | None) -> None:
        try:
            for file in sorted((self._made / "slices").iterdir()):
                if file.suffix == ".part":  # what a print here would go on from
                    continue
                self._fs.put_file(str(file), f"{self._path}/{file.name}")
                if file.name.startswith("slice_"):
                    file.unlink()
        except OSError as fault:
            raise OutsideError(f"`{self._url}` cannot be written: {fault}") from fault

    finished = written

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self._made, ignore_errors=True)
