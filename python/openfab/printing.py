# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints: slices as they come, files, samples and pictures."""

from __future__ import annotations

import atexit
import importlib
import json
import os
import shutil
import sys
import tempfile
import warnings
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._files import outside_errors
from ._given import Real, Whole, number, several, short, vector
from ._options import words_of
from .errors import InputError, PrintWarning, raise_error, replaced
from .world import AnyWorld, snapshot

Progress = bool | Callable[[int, int], None]

# How long a wait may hold up Ctrl-C, which is acted on between two of them.
_STEP_SECONDS = 0.05


class Slice(NamedTuple):
    """One slice of a print.

    Attributes
    ----------
    z : int
        Its number, from 0 at the lowest of the whole print.
    codes : ndarray of uint8, shape (y, x)
        0 is void, 1 the first material; row 0 is at the lowest y. Of a print it is read-only.
    fractions : ndarray of float32, shape (y, x, material), or None
        The mixture before the dither, where it was asked for; what it lacks to 1 is void.
    """

    z: int
    codes: NDArray[np.uint8]
    fractions: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class PrintMaterial:
    """A material of a print; its code is one more than its place in the list.

    Attributes
    ----------
    name : str
        What the world calls it.
    key, preview : tuple of 4 int
        Its colours in slices and in pictures, RGBA of 0 to 255.
    density_g_cm3 : float
        In g/cm³.
    channel : str
        The printer's name for it.
    """

    name: str
    key: tuple[int, int, int, int]
    preview: tuple[int, int, int, int]
    density_g_cm3: float
    channel: str


@dataclass(frozen=True)
class PrintInfo:
    """What is known of a print before its first slice.

    Attributes
    ----------
    size : tuple of 3 int
        Voxels of the whole grid along x, y and z.
    pitch_mm : tuple of 3 floats
        The size of a voxel along x, y and z, in mm.
    origin_mm : tuple of 3 floats
        The lowest corner of voxel (0, 0, 0) along x, y and z, in mm.
    slices : tuple of 2 int
        The first slice that is printed, and one past the last.
    materials : tuple of PrintMaterial
        Code c is the c-th.
    support_code : int
        That of support material; 0 where there is none.
    printer, title : str
        What they are called.
    memory_bytes : int
        What the print is expected to take, in bytes.
    """

    size: tuple[int, int, int]
    pitch_mm: tuple[float, float, float]
    origin_mm: tuple[float, float, float]
    slices: tuple[int, int]
    materials: tuple[PrintMaterial, ...]
    support_code: int
    printer: str
    title: str
    memory_bytes: int


_running: weakref.WeakSet[Print] = weakref.WeakSet()


class Print:
    """A print that runs while its slices are taken; `print_world` makes it.

    Iterating over it gives slices, each as soon as it is ready; the print waits where they are not taken. Each slice is
    given once: a print is iterated over once, or taken as one `array`. It ends by itself, or by `close`, which a `with`
    block and a loop that is left do, too.

    Attributes
    ----------
    thumbnails : list of (int, ndarray of uint8, shape (y, x))
        Some slices, made smaller: what a notebook shows.
    """

    def __init__(
        self, world: AnyWorld, words: list[str], target: _core.Target, *, fractions: bool = False, output: str = "",
        uniforms: Mapping[str, Any] | None = None, window: tuple[float, ...] | None = None,
        enable_printf: bool = False, progress: Progress = False, names: Mapping[str, str] | None = None,
    ) -> None:
        claim_threads()
        self._world = world
        self._snapshot = snapshot(world, uniforms)  # whose files it reads
        self._names = {**self._snapshot.names, **(names or {})}
        program = self._snapshot.program(enable_printf)
        self._core = _core.Print(program, self._snapshot.words + words, target, fractions, output, window)
        self._progress = _Bar(progress)
        self._info: PrintInfo | None = None
        self._closed = False
        self._is_of_the_parent = False
        self._taken = target != _core.Target.SLICES
        self._statistics: dict[str, Any] | None = None
        self.thumbnails: list[tuple[int, NDArray[np.uint8]]] = []
        """Some slices, made smaller: what a notebook shows."""
        _running.add(self)

    @property
    def info(self) -> PrintInfo:
        """Grid and materials; waits for the set-up."""
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
        """What `--stats` writes; of the slices so far where the print was closed early."""
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
                one = Slice(*item)
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
            Their codes: 0 is void, c the c-th material.

        Raises
        ------
        InputError
            Where slices were taken before, or the print was closed.
        Error
            What went wrong with the print.
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
        """Ends the print and its threads. What it has written is removed, unless it was complete."""
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

    def _repr_html_(self) -> str:
        from .display import print_html

        return print_html(self)

    def _repr_png_(self) -> bytes:
        return self._world._repr_png_()

    def __repr__(self) -> str:
        state = "closed" if self._closed else str(self._core.state).rsplit(".", 1)[-1].lower().replace("_", " ")
        return f"Print({self._world!r}, {state})"

    def _wait(self, state: _core.State) -> None:
        """Waits for another state; a signal's exception ends the print."""
        try:
            while self._core.wait_while(state, _STEP_SECONDS) == state:
                self._tell()
                self._progress.show(*self._core.progress)
        except BaseException:
            self.close()
            raise

    def _next(self) -> tuple[int, NDArray[np.uint8], NDArray[np.float32] | None] | None:
        while not self._closed:
            item = self._core.next(_STEP_SECONDS)
            self._tell()
            if item is not None:
                return item
            if self._core.state == _core.State.ENDED:
                return self._core.next(0)
        return None

    def _end(self) -> None:
        """Waits for the end and raises what went wrong."""
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
            warnings.warn(replaced(warning, self._names), PrintWarning, stacklevel=4)


_MOST_THUMBNAILS = 48
_THUMBNAIL_SIDE = 320


def smaller(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Leaves out rows and columns of a slice, for a notebook."""
    step = max(1, -(-max(codes.shape) // _THUMBNAIL_SIDE))
    return np.ascontiguousarray(codes[step // 2 :: step, step // 2 :: step])


@atexit.register
def _close_all() -> None:
    for one in list(_running):
        one.close()


_has_threads = False
_lacks_threads = False


def claim_threads() -> None:
    """Says that this process prints; raises where it cannot."""
    global _has_threads
    if _lacks_threads:
        raise InputError(
            "this process was forked from one that had printed, whose threads it lacks",
            help="start it by multiprocessing's `spawn` or `forkserver`, or before the first print",
        )
    _has_threads = True


def _leave_to_the_parent() -> None:
    """A forked child has none of the threads of prints, which it could not even wait for."""
    global _lacks_threads
    _lacks_threads = _has_threads
    for one in list(_running):
        one._closed = one._is_of_the_parent = True
        one._core.abandon()
    _running.clear()


os.register_at_fork(after_in_child=_leave_to_the_parent)


class _Bar:
    """Progress: tqdm's where there is one, else a line of text; or a function's own."""

    def __init__(self, progress: Progress) -> None:
        self._wanted = progress
        self._bar: Any = None
        self._last = -1

    def show(self, done: int, total: int) -> None:
        if self._wanted is False or done == self._last or total == 0:
            return
        self._last = done
        if callable(self._wanted):
            self._wanted(done, total)
            return
        if self._bar is None:
            try:
                make: Any = importlib.import_module("tqdm.auto").tqdm
            except ImportError:
                make = _Line
            self._bar = make(total=total, unit="slice", leave=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class _Line:
    """What tqdm does, on one line of stderr."""

    def __init__(self, total: int, unit: str, leave: bool) -> None:
        self.n = 0
        self._total = total
        self._unit = unit

    def update(self, more: int) -> None:
        self.n += more
        sys.stderr.write(f"\r{self._unit} {self.n} of {self._total}")
        sys.stderr.flush()

    def close(self) -> None:
        sys.stderr.write("\n")


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
    """Prints a world: hands out its slices, or writes them.

    Lengths are millimetres, or texts with a unit. What is not described here is as of `openfab print`.

    Parameters
    ----------
    world : World or FileWorld
        What is printed, as it is at the call.
    out : str or path, optional
        A file (.ofr, .npy, .3mf, .stl), a folder or a receiver's address, which get the bytes of `openfab print`; the call
        returns when it is complete, and a print that ends early leaves no file. `-` is the standard output. Without it the
        slices are taken by iterating over the result.
    printer : str or path, optional
        Instead of the world's.
    process : str or path, optional
        A file of what the machine does to a print, whose items replace those of the printer's profile.
    nozzles : str or path, optional
        A file of dead nozzles; a change of it counts from the next slices on.
    bleed : {"undo", "show", "both", "off"}, optional
        What becomes of the `bleed` of the process: it is undone unless told.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm; one, or of x, y and z. Else that of the printer.
    dpi : float, str or sequence of 2 floats, optional
        The same along x and y, in dots an inch.
    layer : float or str, optional
        The height of a slice in mm.
    mesh_pitch : float or str, optional
        The size of the voxels of meshes that are written, in mm.
    draft : int, optional
        How many times as large voxels are as the printer's, 1 at least.
    slices : sequence of 2 int, optional
        The first slice that is printed, and one past the last.
    z : sequence of 2 floats or str, optional
        The same as heights, in mm.
    uniforms : mapping of str to Any, optional
        Other values, as `{"ball.skin": 1.5}`; nothing is compiled for them.
    support : bool or str, optional
        Whether there is support material, or which.
    dither : str, optional
        How mixtures become materials.
    seed : int, optional
        Of the dither.
    crop : {"parts", "tray"}, optional
        What the slices show.
    format : str, optional
        Of the output, where its name does not tell.
    memory : int or str, optional
        The budget, in bytes.
    threads : int, optional
        1 at least; else as many as there are processors.
    token_file, tls_ca : str or path, optional
        For a receiver.
    fractions : bool, optional
        Whether slices have the mixtures before the dither, too: those at the voxels' centres; `sample` gives means.
    enable_printf : bool, optional
        Whether `printf` and `assert` of fablets do something.
    progress : bool or callable, optional
        True for a bar, or a function of slices done and of all.

    Returns
    -------
    Print
        Which gives `Slice`, codes of shape (y, x); with `out`, one that is complete.

    Raises
    ------
    InputError
        Where an argument or the world is wrong; what takes a set-up to see is raised by the first slice, or by `info`.
    CompileError
        Where a fablet does not compile.
    OutsideError
        Where a disk or a network failed.

    Examples
    --------
    >>> for one in print_world(world, draft=2):         # doctest: +SKIP
    ...     print(one.z, (one.codes == 1).sum())
    """
    words = words_of(
        printer=printer, process=process, nozzles=nozzles, bleed=bleed, voxel=voxel, dpi=dpi, layer=layer,
        mesh_pitch=mesh_pitch, draft=draft, slices=slices, z=z, dither=dither, seed=seed, crop=crop, format=format,
        memory=memory, threads=threads, token_file=token_file, tls_ca=tls_ca, support=support,
    )
    if out is None:
        # A slice's codes are made of the mixtures at centres, so that these belong to them.
        words += ["--sampling=centre"] if fractions else []
        return Print(
            world, words, _core.Target.SLICES, fractions=fractions, uniforms=uniforms, enable_printf=enable_printf,
            progress=progress,
        )
    if fractions:
        raise InputError("`fractions` are handed out with slices; leave `out` away")
    output = os.fsdecode(out)
    if output == "-":
        sys.stdout.flush()  # slices come behind what was said
    with Unfinished(output) as unfinished:
        done = Print(
            world, [*words, f"--output={output}"], _core.Target.OUTPUT, output=unfinished.name,
            uniforms=uniforms, enable_printf=enable_printf, progress=progress, names=unfinished.names,
        )
        with done:
            done._end()
    return done


class Unfinished:
    """A name beside an output, in a folder of its own, which takes the output's place once it is complete.

    `name` is empty where there is none: for the standard output, addresses, pipes and devices; for a folder that is
    there, whose slices are replaced one by one; and for what the print refuses. A link is written through.
    """

    def __init__(self, output: str) -> None:
        self._output = output
        self._folder: Path | None = None
        self.name = ""

    @property
    def names(self) -> dict[str, str]:
        """What messages call it."""
        return {self.name: self._output} if self.name else {}

    def __enter__(self) -> Unfinished:
        if self._output in ("", "-") or self._output.startswith(("tcp://", "tls://", "unix:")):
            return self
        place = Path(os.path.realpath(self._output))
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


@dataclass(frozen=True)
class Samples:
    """Mixtures in a box of voxels; `sample` makes it.

    The centre of voxel (i, j, k) is at `origin_mm` + (i + 0.5, j + 0.5, k + 0.5) `pitch_mm`.

    Attributes
    ----------
    fractions : ndarray of float32, shape (z, y, x, material)
        What they lack to 1 is void.
    origin_mm : tuple of 3 floats
        The lowest corner of the box along x, y and z, in mm.
    pitch_mm : tuple of 3 floats
        The size of a voxel along x, y and z, in mm.
    materials : tuple of PrintMaterial
        Those of the last axis.
    """

    fractions: NDArray[np.float32]
    origin_mm: tuple[float, float, float]
    pitch_mm: tuple[float, float, float]
    materials: tuple[PrintMaterial, ...]

    def at(self, points: ArrayLike) -> NDArray[np.float32]:
        """Looks points up.

        Parameters
        ----------
        points : array_like of float, shape (..., 3)
            In mm.

        Returns
        -------
        ndarray of float32, shape (..., material)
            The mixtures of the voxels that hold them; zeros outside of the box.

        Raises
        ------
        InputError
            Where the points have another shape.
        """
        if np.shape(points)[-1:] != (3,):
            raise InputError(f"`points` has the shape {np.shape(points)}; it should be (..., 3)")
        places = (np.asarray(points, float) - self.origin_mm) / self.pitch_mm
        index = np.floor(places).astype(np.int64)
        size = np.array(self.fractions.shape[2::-1])
        inside = np.all((index >= 0) & (index < size), axis=-1)
        i, j, k = np.moveaxis(np.clip(index, 0, size - 1), -1, 0)
        return np.where(inside[..., None], self.fractions[k, j, i], np.float32(0))

    def mean(self, values: Mapping[str, float], void: float = 0.0) -> NDArray[np.float64]:
        """Averages a property of materials, weighted by their amounts.

        Parameters
        ----------
        values : mapping of str to float
            That of each material, by name.
        void : float, optional
            That of nothing.

        Returns
        -------
        ndarray of float64, shape (z, y, x)
            In the unit of the values.

        Raises
        ------
        InputError
            Where a material has no value, or a name is none.
        """
        names = [material.name for material in self.materials]
        unknown = set(values) - set(names)
        if unknown:
            raise InputError(f"no material is called {', '.join(sorted(unknown))}; there are {', '.join(names)}")
        missing = [name for name in names[: self.fractions.shape[-1]] if name not in values]
        if missing:
            raise InputError(f"there is no value for {', '.join(missing)}; give one for each of {', '.join(names)}")
        weights = np.array([number(values[name], f"`{name}`") for name in names[: self.fractions.shape[-1]]])
        means: NDArray[np.float64] = self.fractions @ weights + void * (1 - self.fractions.sum(axis=-1))
        return means


def sample(
    world: AnyWorld,
    box: tuple[Sequence[Real], Sequence[Real]] | None = None,
    *,
    voxel: Real | str | Sequence[Real],
    sampling: Literal["volume", "centre"] = "volume",
    uniforms: Mapping[str, Any] | None = None,
    memory: Whole | str | None = None,
    threads: Whole | None = None,
    progress: Progress = False,
) -> Samples:
    """Evaluates a world in a box of voxels of any size.

    Only what is in the box is evaluated: it may be a small part of a large world. Voxels that are larger than the
    printer's get the mean mixture of the printer's voxels in them, void among them.

    Parameters
    ----------
    world : World or FileWorld
        What is evaluated, as it is at the call.
    box : sequence of 2 sequences of 3 floats, optional
        Its lowest and its highest corner, in mm; else that of all parts. It is rounded out to whole voxels, whose corners
        are at multiples of the pitch.
    voxel : float, str or sequence of 3 floats
        The size of a voxel in mm; one, or of x, y and z.
    sampling : {"volume", "centre"}, optional
        Whether a voxel that is larger than the printer's gets means over its volume, which takes as long as a print, or
        the mixture at its centre, which misses what is finer than the voxel.
    uniforms : mapping of str to Any, optional
        Other values, as `{"ball.skin": 1.5}`.
    memory : int or str, optional
        The budget, in bytes.
    threads : int, optional
        1 at least; else as many as there are processors.
    progress : bool or callable, optional
        True for a bar, or a function of slices done and of all.

    Returns
    -------
    Samples
        The mixtures before the dither, of shape (z, y, x, material).

    Raises
    ------
    InputError
        Where an argument or the world is wrong.
    CompileError
        Where a fablet does not compile.
    """
    words = words_of(voxel=voxel, memory=memory, threads=threads, support=False, sampling=sampling)
    window: tuple[float, ...] | None = None
    if box is not None:
        corners = several(box, "`box`", (2,), "its lowest and its highest corner")
        low, high = (vector(corner, "`box`") for corner in corners)
        if not all(a < b for a, b in zip(low, high)):
            raise InputError(f"the box {short(box)} is none; give its lowest and its highest corner")
        window = (*low, *high)
    with Print(
        world, words, _core.Target.SLICES, fractions=True, uniforms=uniforms, window=window, progress=progress
    ) as running:
        info = running.info
        out: NDArray[np.float32] | None = None
        for one in running:
            assert one.fractions is not None
            if out is None:
                out = np.empty((info.size[2], *one.fractions.shape), np.float32)
            out[one.z] = one.fractions
    assert out is not None
    return Samples(out, info.origin_mm, info.pitch_mm, info.materials[: out.shape[-1]])


def preview(
    world: AnyWorld, *views: str, uniforms: Mapping[str, Any] | None = None,
    voxel: Real | str | Sequence[Real] | None = None, draft: Whole | None = None,
    printer: str | os.PathLike[str] | None = None, memory: Whole | str | None = None, threads: Whole | None = None,
    progress: Progress = False,
) -> list[NDArray[np.uint8]]:
    """Draws pictures of a print.

    Parameters
    ----------
    world : World or FileWorld
        What is drawn, as it is at the call.
    *views : str
        As of `--preview`: `front`, `back`, `section`, `slice:N`, `model:TURN:TILT` in degrees, with `,light=transmitted` or
        `,cut=x|y|xy` behind it. The default is `model:30:30`.
    uniforms : mapping of str to Any, optional
        Other values, as `{"ball.skin": 1.5}`.
    voxel : float, str or sequence of 3 floats, optional
        The size of a voxel in mm; one, or of x, y and z. Else that of the printer.
    draft : int, optional
        How many times as large voxels are as the printer's.
    printer : str or path, optional
        Instead of the world's.
    memory : int or str, optional
        The budget, in bytes.
    threads : int, optional
        1 at least; else as many as there are processors.
    progress : bool or callable, optional
        True for a bar, or a function of slices done and of all.

    Returns
    -------
    list of ndarray of uint8, shape (row, column, 4)
        RGBA in sRGB, a picture for each view.

    Raises
    ------
    InputError
        Where an argument, a view or the world is wrong.
    CompileError
        Where a fablet does not compile.
    """
    words = words_of(voxel=voxel, draft=draft, printer=printer, memory=memory, threads=threads)
    # The options want names of files; none is written.
    views = views or ("model:30:30",)
    words += [f"--preview=.openfab-picture-{number}.png,view={view}" for number, view in enumerate(views)]
    with Print(world, words, _core.Target.PICTURES, uniforms=uniforms, progress=progress) as running:
        running._end()
        return running._core.pictures
