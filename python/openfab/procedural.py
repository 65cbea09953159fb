# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Generators: functions that make beams, meshes and placements as a print comes near.

A decorated function answers for a box: it yields geometry inside the box, and smaller boxes that contain more. It can be
used as a mesh in `World.add`. Its `serve` answers a print of a `.fab.json` that names its file as a `program`.
"""

from __future__ import annotations

import hashlib
import socket
import sys
import threading
import traceback
import types
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TextIO, overload

import numpy as np
from numpy.typing import ArrayLike

from ._given import floats, integers, positive, short
from ._lines import ROOT, Bound, Lines, beam, beams, mesh, more, place
from .errors import InputError

__all__ = ["ROOT", "Bound", "Generated", "Generator", "Lines", "beam", "beams", "generator", "mesh", "more", "place"]

_TYPES = {"float": 1, "float2": 2, "float3": 3, "float4": 4, "int": 1}

Function = Callable[[Bound], Iterable[Lines]]


class Generator:
    """A function that makes geometry on demand. `generator` makes one.

    Parameters
    ----------
    function : callable
        A function that takes a Bound and yields results of this module's functions.
    attributes : mapping of str to str, optional
        Names and types (`float` to `float4`, `int`) of the attributes that a fablet reads with `@nearest`.
    places : sequence of str, optional
        Names of objects in the world that it may place.
    version : str, optional
        Any text; change it when data that the function reads have changed, so that an old print is not resumed.
    answer_s, answer_mb : float, optional
        Limits of an answer, in seconds and megabytes, instead of 60 and 64.

    Raises
    ------
    InputError
        If a type is unknown.
    """

    def __init__(
        self, function: Function, attributes: Mapping[str, str] | None = None, places: Sequence[str] = (),
        version: str | None = None, answer_s: float | None = None, answer_mb: float | None = None,
    ) -> None:
        if not callable(function):
            raise InputError(f"{short(function)} is no function of a Bound")
        for name, kind in (attributes or {}).items():
            if kind not in _TYPES:
                raise InputError(f"attribute `{name}` cannot be {short(kind)}; it is one of {', '.join(_TYPES)}")
        if isinstance(places, str):
            raise InputError(f"`places` cannot be {short(places)}; it is a list of names")
        self.function = function
        self.attributes = dict(attributes or {})
        self.places = list(places)
        self.version = version
        self.answer_s = None if answer_s is None else positive(answer_s, "`answer_s`")
        self.answer_mb = None if answer_mb is None else positive(answer_mb, "`answer_mb`")
        self.__doc__ = function.__doc__
        self.__name__ = getattr(function, "__name__", "generator")

    def __call__(self, bound: Bound) -> Iterable[Lines]:
        return self.function(bound)

    def within(self, box: ArrayLike) -> Generated:
        """Returns a solid that can be used as a mesh in `World.add`.

        Parameters
        ----------
        box : array_like of float, shape (2, 3)
            Two corners of a box that contains all of it, in mm, the lower corner first.

        Returns
        -------
        Generated
            The geometry of the function in the box.

        Raises
        ------
        InputError
            If the box is invalid.
        """
        return Generated(self, box)

    def serve(self, questions: TextIO | None = None, answers: TextIO | None = None) -> None:
        """Answers the questions of a print until there are no more; it does not return if the function fails.

        Parameters
        ----------
        questions, answers : text file, optional
            Default: the standard input and output. Output of the function's own then goes to the standard error.
        """
        questions = questions or sys.stdin
        mine = answers is None
        answers = answers or sys.stdout
        if mine:
            sys.stdout = sys.stderr  # what the function prints is no answer
        for line in questions:
            try:
                for text in self.answer(line):
                    answers.write(text)
                answers.write("done\n")
            except Exception as error:  # whatever it raises is told
                traceback.print_exc()
                told = " ".join(f"{type(error).__name__}: {error}".split())
                answers.write(f"error {told}\ndone\n")
                answers.flush()
                if mine:
                    raise SystemExit(1) from error
                return
            answers.flush()

    def answer(self, question: str) -> Iterator[str]:
        """Yields the lines that answer a question of a print.

        Parameters
        ----------
        question : str
            `grow KEY X Y Z X Y Z`.

        Returns
        -------
        iterator of str
            The lines, without the final `done`.

        Raises
        ------
        InputError
            If the function yields something else, or the question is malformed.
        """
        words = question.split()
        if len(words) != 8 or words[0] != "grow":
            raise InputError(f"asked {short(question)}, which is not `grow KEY X Y Z X Y Z`")
        low, high = (tuple(float(word) for word in words[i : i + 3]) for i in (2, 5))
        for one in self.function(Bound(words[1], low, high)) or ():  # type: ignore[arg-type]
            if not isinstance(one, Lines):
                raise InputError(f"`{self.__name__}` yields {short(one)}; yield `beam`, `beams`, `mesh`, `place`, `more`")
            yield self._text(one)

    def _text(self, one: Lines) -> str:
        head = f"{one.word} {one.name} " if one.name else f"{one.word} "
        if one.word == "more":
            return head + " ".join(f"{x:.9g}" for x in one.numbers[0]) + "\n"
        ends = 2 if one.word in ("beam", "flat") else 1
        columns, wholes = [one.numbers], []
        for name in one.values:
            if name not in self.attributes:
                known = ", ".join(f"`{known}`" for known in self.attributes) or "none"
                raise InputError(f"`{self.__name__}` gives `{name}`, which is not among its attributes: {known}")
        of_ends: list[list[Any]] = [[], []]
        for name, kind in self.attributes.items():
            if name not in one.values:
                raise InputError(f"`{self.__name__}` makes a {one.word} without `{name}`, an attribute of it")
            if kind == "int":
                found = integers(one.values[name], f"`{name}`")
                if found.shape != (len(one.numbers),):
                    raise InputError(f"`{name}` has the shape {found.shape}; it should be one number for each")
                wholes.append(found)
                continue
            for end, values in enumerate(self._ends(name, kind, one.values[name], len(one.numbers), ends)):
                of_ends[end].append(values)
        columns += of_ends[0] + of_ends[1]
        rows = np.concatenate(columns, axis=1)
        form = head + " ".join(["%.9g"] * rows.shape[1] + ["%d"] * len(wholes)) + "\n"
        lists = [rows[:, k].tolist() for k in range(rows.shape[1])] + [found.tolist() for found in wholes]
        return "".join(form % row for row in zip(*lists)) + one.more_lines

    def _ends(self, name: str, kind: str, given: Any, count: int, ends: int) -> list[Any]:
        """Returns the values of a float attribute at each end, of shape (count, components)."""
        size = _TYPES[kind]
        found = floats(given, f"`{name}`", np.float64)
        whole = (count, size) if size > 1 else (count,)
        if found.shape == whole:
            return [found.reshape(count, size)] * ends
        if ends == 2 and found.shape == (count, 2, *whole[1:]):
            return [found[:, end].reshape(count, size) for end in range(2)]
        both = f", or {(count, 2, *whole[1:])} at both ends" if ends == 2 else ""
        raise InputError(f"`{name}`, a {kind} of {count}, has the shape {found.shape}; it should be {whole}{both}")

    def _hash(self) -> str:
        """Returns a hash of the function's code."""
        hasher = hashlib.sha256()

        def add(code: types.CodeType) -> None:
            hasher.update(code.co_code)
            hasher.update(repr(code.co_names).encode())
            for constant in code.co_consts:
                if isinstance(constant, types.CodeType):
                    add(constant)
                else:
                    hasher.update(repr(constant).encode())

        code = getattr(self.function, "__code__", None)
        if code is not None:
            add(code)
        return hasher.hexdigest()[:16]


class Generated:
    """The geometry of a generator in a box; `Generator.within` makes it.

    Parameters
    ----------
    generator : Generator
        The generator.
    box : array_like of float, shape (2, 3)
        Two corners of a box that contains all of it, in mm, the lower corner first.

    Raises
    ------
    InputError
        If the box is invalid.
    """

    def __init__(self, generator: Generator, box: ArrayLike) -> None:
        corners = floats(box, "`box`", np.float64)
        if corners.shape != (2, 3):
            raise InputError(f"`box` has the shape {corners.shape}; it should be (2, 3), two corners")
        if not (corners[0] < corners[1]).all():
            raise InputError("`box` is empty; its lower corner comes first")
        self.generator = generator
        self.box = corners

    def _spec(self) -> dict[str, Any]:
        one = self.generator
        token = f"{id(one):x}"
        _served[token] = one
        spec = {
            "program": ["(this process)", token], "box_mm": self.box.tolist(), "attributes": one.attributes,
            "places": one.places, "version": f"{one.version or ''} {one._hash()}",
            "answer_s": one.answer_s, "answer_mb": one.answer_mb,
        }
        return {key: value for key, value in spec.items() if value is not None}

    def __repr__(self) -> str:
        return f"Generated({self.generator.__name__}, {self.box.tolist()})"


_served: weakref.WeakValueDictionary[str, Generator] = weakref.WeakValueDictionary()


def _open(token: str) -> int:
    """Opens a connection to a generator, which a thread answers; returns its descriptor, or -1."""
    found = _served.get(token)
    if found is None:
        return -1
    theirs, ours = socket.socketpair()

    def answer() -> None:
        with ours, ours.makefile("r", encoding="utf-8") as questions, ours.makefile("w", encoding="utf-8") as answers:
            try:
                found.serve(questions, answers)
            except OSError:
                pass  # the print has ended

    threading.Thread(target=answer, name="openfab generator", daemon=True).start()
    return theirs.detach()


@overload
def generator(function: Function) -> Generator: ...


@overload
def generator(
    *, attributes: Mapping[str, str] | None = None, places: Sequence[str] = (), version: str | None = None,
    answer_s: float | None = None, answer_mb: float | None = None,
) -> Callable[[Function], Generator]: ...


def generator(function: Function | None = None, **given: Any) -> Any:
    """Turns a function into a generator, as a decorator.

    Parameters
    ----------
    function : callable
        A function that takes a Bound and yields `beam`, `beams`, `mesh`, `place` and `more`, and depends on the Bound alone.
    **given
        The arguments of Generator: `attributes`, `places`, `version`, `answer_s`, `answer_mb`.

    Returns
    -------
    Generator
        Use its `within` for `World.add`, and its `serve` in a file that a `.fab.json` names as a `program`.

    Raises
    ------
    InputError
        If the type of an attribute is unknown.

    Examples
    --------
    >>> from openfab.procedural import beam, generator
    >>> @generator
    ... def fence(bound):
    ...     for i in range(10):
    ...         yield beam((4 * i, 0, 0), (4 * i, 0, 20), 1)
    """
    if function is None:
        return lambda made: Generator(made, **given)
    return Generator(function, **given)
