# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints, to slices or to files."""

from __future__ import annotations

import atexit
import json
import os
import sys
import warnings
import weakref
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._given import Real, Whole
from ._options import fields_of, options_of
from ._progress import Bar, Progress
from ._unfinished import Unfinished
from .errors import InputError, PrintWarning, raise_error, replaced, worded
from .slices import PrintInfo, PrintMaterial, Slice, smaller
from .world import AnyWorld, snapshot

# How long a wait may delay Ctrl-C, which is handled between two waits.
_STEP_SECONDS = 0.05
_MOST_THUMBNAILS = 48

_running: weakref.WeakSet[Print] = weakref.WeakSet()


class Print:
    """A print that runs while its slices are taken; `print_world` makes it.

    Iteration yields each slice as soon as it is ready, and the print waits until its slices are taken. Each slice is
    yielded once: iterate over a print once, or take it as one `array`. A print ends with its last slice, or with `close`,
    which a `with` block and leaving the loop call, too.

    Attributes
    ----------
    thumbnails : list of (int, ndarray of uint8, shape (y, x))
        Some slices at a reduced size, for notebooks.
    """

    def __init__(
        self, world: AnyWorld, fields: Mapping[str, Any], target: _core.Target, *, fractions: bool = False, output: str = "",
        uniforms: Mapping[str, Any] | None = None, window: tuple[float, ...] | None = None,
        enable_printf: bool = False, progress: Progress = False, names: Mapping[str, str] | None = None,
        derivatives: Sequence[str] = (),
    ) -> None:
        claim_threads()
        self._world = world
        self._snapshot = snapshot(world, uniforms)  # whose files it reads
        self._names = {**self._snapshot.names, **(names or {})}
        options = options_of(self._snapshot.fields, fields)
        uniform_names = tuple(dict.fromkeys(name.rsplit(".", 1)[-1] for name in derivatives))
        program = self._snapshot.program(enable_printf, uniform_names)
        self._core = _core.Print(program, options, target, fractions, output, window, list(derivatives))
        self._progress = Bar(progress)
        self._info: PrintInfo | None = None
        self._closed = False
        self._is_of_the_parent = False
        self._taken = target != _core.Target.SLICES
        self._statistics: dict[str, Any] | None = None
        self._rates: NDArray[np.float32] | None = None  # derivatives (y, x, column, material) of the last slice
        self.thumbnails: list[tuple[int, NDArray[np.uint8]]] = []
        """Some slices at a reduced size, for notebooks."""
        _running.add(self)

    @property
    def info(self) -> PrintInfo:
        """The grid and the materials; waits for the set-up."""
        if self._info is None:
            if self._is_of_the_parent:
                raise InputError("the print is of the process that this one was forked from; print the world again")
            self._wait(_core.State.SETTING_UP)
            self._tell()
            if self._core.state == _core.State.ENDED and self._core.error is not None and not self._closed:
                self._end()
            data = self._core.info
            if 0 in data["size"]:
                raise InputError("the print was closed before its set-up was complete, so that its grid is not known")
            data["materials"] = tuple(PrintMaterial(**one) for one in data["materials"])
            self._info = PrintInfo(**data)
        return self._info

    @property
    def statistics(self) -> dict[str, Any]:
        """The statistics, as written by `--stats`; if the print was closed early, those of the finished slices."""
        if self._statistics is None:
            raise InputError("the print has not ended; take all of its slices, or close it")
        return self._statistics

    def __iter__(self) -> Iterator[Slice]:
        if self._taken or self._closed:
            how = "were taken already" if self._taken else "are gone, since it was closed"
            raise InputError(f"the slices of the print {how}; print_world prints the world again")
        self._taken = True
        return self._slices()

    def _slices(self) -> Iterator[Slice]:
        try:
            info = self.info
            first, end = info.slices
            step = max(1, -(-(end - first) // _MOST_THUMBNAILS))
            while (item := self._next()) is not None:
                one = Slice(*item[:3])
                self._rates = item[3]
                if (one.z - first) % step == 0:
                    self.thumbnails.append((one.z, smaller(one.codes)))
                self._progress.show(one.z + 1 - first, end - first)
                yield one
            self._end()
        finally:
            self.close()

    def array(self) -> NDArray[np.uint8]:
        """Takes all slices.

        Returns
        -------
        ndarray of uint8, shape (z, y, x)
            The codes: 0 is void, c is the c-th material.

        Raises
        ------
        InputError
            If slices were taken before, or the print was closed.
        Error
            If the print failed.
        """
        slices = iter(self)
        first, end = self.info.slices
        out = np.empty((end - first, self.info.size[1], self.info.size[0]), np.uint8)
        done = first
        for one in slices:
            out[one.z - first] = one.codes
            done = one.z + 1
        if done != end:
            raise InputError(f"the print was closed after {done - first} of {end - first} slices")
        return out

    def close(self) -> None:
        """Ends the print and its threads, and removes output that is not complete."""
        if self._closed:
            return
        self._closed = True
        self._core.cancel()
        self._core.join()
        self._progress.close()
        if self._core.statistics:
            self._statistics = json.loads(self._core.statistics)
        _running.discard(self)

    def __enter__(self) -> Print:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else str(self._core.state).rsplit(".", 1)[-1].lower().replace("_", " ")
        return f"Print({self._world!r}, {state})"

    def _wait(self, state: _core.State) -> None:
        """Waits for the end of a state; a signal's exception ends the print."""
        try:
            while self._core.wait_while(state, _STEP_SECONDS) == state:
                self._tell()
                self._progress.show(*self._core.progress)
        except BaseException:
            self.close()
            raise

    def _next(
        self,
    ) -> tuple[int, NDArray[np.uint8], NDArray[np.float32] | None, NDArray[np.float32] | None] | None:
        while not self._closed:
            item = self._core.next(_STEP_SECONDS)
            self._tell()
            if item is not None:
                return item
            if self._core.state == _core.State.ENDED:
                return self._core.next(0)
        return None

    def _end(self) -> None:
        """Waits for the end and raises the error, if any."""
        for state in (_core.State.SETTING_UP, _core.State.PRINTING):
            self._wait(state)
        self._progress.show(*self._core.progress)
        error = self._core.error
        was_closed = self._closed
        self.close()
        self._tell()
        if error is not None and not was_closed:
            raise_error(error, self._names)

    def _tell(self) -> None:
        for line in self._core.take_lines():
            print(line)
        for warning in self._core.take_warnings():
            warnings.warn(worded(replaced(warning, self._names)), PrintWarning, stacklevel=4)


@atexit.register
def _close_all() -> None:
    for one in list(_running):
        one.close()


_has_threads = False
_lacks_threads = False


def claim_threads() -> None:
    """Notes that this process prints; raises if it cannot."""
    global _has_threads
    if _lacks_threads:
        raise InputError(
            "this process was forked from one that had printed, whose threads it lacks",
            help="start it by multiprocessing's `spawn` or `forkserver`, or before the first print",
        )
    _has_threads = True


def _leave_to_the_parent() -> None:
    """Abandons prints in a forked child, which lacks their threads and could not even wait for them."""
    global _lacks_threads
    _lacks_threads = _has_threads
    for one in list(_running):
        one._closed = one._is_of_the_parent = True
        one._core.abandon()
    _running.clear()


os.register_at_fork(after_in_child=_leave_to_the_parent)


def print_world(
    world: AnyWorld,
    out: str | os.PathLike[str] | None = None,
    *,
    printer: str | os.PathLike[str] | None = None,
    process: str | os.PathLike[str] | None = None,
    nozzles: str | os.PathLike[str] | None = None,
    bleed: Literal["undo", "show", "both", "off"] | None = None,
    voxel: Real | str | Sequence[Real] | None = None,
    dpi: Real | str | Sequence[Real] | None = None,
    layer: Real | str | None = None,
    mesh_pitch: Real | str | None = None,
    draft: Whole | None = None,
    slices: Sequence[Whole] | None = None,
    z: Sequence[Real | str] | None = None,
    uniforms: Mapping[str, Any] | None = None,
    support: bool | str | None = None,
    dither: str | None = None,
    seed: Whole | None = None,
    crop: Literal["parts", "tray"] | None = None,
    format: str | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
    token_file: str | os.PathLike[str] | None = None,
    tls_ca: str | os.PathLike[str] | None = None,
    fractions: bool = False,
    enable_printf: bool = False,
    progress: Progress = False,
) -> Print:
    """Prints a world: yields its slices, or writes them.

    Lengths are numbers in millimetres, or strings with a unit. All else works as in `openfab print`.

    Parameters
    ----------
    world : World or FileWorld
        What to print, in its state at the call.
    out : str or path, optional
        A file (.ofr, .npy, .3mf, .stl), a folder or a receiver's address, with the same bytes as `openfab print`. The call
        returns when the output is complete; a print that ends early leaves no file. `-` is the standard output. Without
        `out`, iterate over the result to take the slices.
    printer : str or path, optional
        The printer to use instead of the world's.
    process : str or path, optional
        A file that describes the machine's effects on a print; its items replace those of the printer's profile.
    nozzles : str or path, optional
        A file of dead nozzles; a change takes effect from the next slices on.
    bleed : {"undo", "show", "both", "off"}, optional
        How to treat the `bleed` of the process. Default: undo.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm: one, or three for x, y and z. Default: that of the printer.
    dpi : float, str or sequence of 2 floats, optional
        The resolution along x and y, in dots per inch.
    layer : float or str, optional
        The height of a slice in mm.
    mesh_pitch : float or str, optional
        The voxel size for written meshes, in mm.
    draft : int, optional
        How many times larger than the printer's the voxels are; at least 1.
    slices : sequence of 2 int, optional
        The first slice to print, and one past the last.
    z : sequence of 2 floats or str, optional
        The range of slices as heights, in mm.
    uniforms : mapping of str to Any, optional
        Values to use instead, such as `{"ball.skin": 1.5}`; nothing is recompiled for them.
    support : bool or str, optional
        Whether to print support material, or the name of the material.
    dither : str, optional
        The rule that turns mixtures into materials.
    seed : int, optional
        The seed of the dither.
    crop : {"parts", "tray"}, optional
        The area that slices show: the parts, or the whole tray.
    format : str, optional
        The format of the output, if its name does not imply one.
    memory : int or str, optional
        The memory budget, in bytes.
    threads : int, optional
        At least 1. Default: one per processor.
    token_file, tls_ca : str or path, optional
        The token and the certificate authority for a receiver.
    fractions : bool, optional
        Whether slices also have the mixtures before the dither, at the voxels' centres; `sample` computes means.
    enable_printf : bool, optional
        Whether `printf` and `assert` in fablets are active.
    progress : bool or callable, optional
        True for a progress bar, or a function that takes the number of finished slices and of all slices.

    Returns
    -------
    Print
        A print that yields `Slice` objects with codes of shape (y, x); with `out`, a complete print.

    Raises
    ------
    InputError
        If an argument or the world is wrong. Errors found during set-up are raised by the first slice or by `info`.
    CompileError
        If a fablet does not compile.
    OutsideError
        If a disk or a network failed.

    Examples
    --------
    >>> for one in print_world(world, draft=2):         # doctest: +SKIP
    ...     print(one.z, (one.codes == 1).sum())
    """
    fields = fields_of(
        printer=printer, process=process, nozzles=nozzles, bleed=bleed, voxel=voxel, dpi=dpi, layer=layer,
        mesh_pitch=mesh_pitch, draft=draft, slices=slices, z=z, dither=dither, seed=seed, crop=crop, format=format,
        memory=memory, threads=threads, token_file=token_file, tls_ca=tls_ca, support=support,
    )
    if out is None:
        # A slice's codes come from the mixtures at centres, so these are the matching ones.
        fields["sample_centres"] = fractions
        return Print(
            world, fields, _core.Target.SLICES, fractions=fractions, uniforms=uniforms, enable_printf=enable_printf,
            progress=progress,
        )
    if fractions:
        raise InputError("`fractions` are handed out with slices; leave `out` away")
    output = os.fsdecode(out)
    if output == "-":
        sys.stdout.flush()  # slices come behind what was said
    with Unfinished(output) as unfinished:
        done = Print(
            world, {**fields, "output": output}, _core.Target.OUTPUT, output=unfinished.name,
            uniforms=uniforms, enable_printf=enable_printf, progress=progress, names=unfinished.names,
        )
        with done:
            done._end()
    return done
