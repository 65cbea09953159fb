# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Generators: functions that make beams, meshes and placements where a print comes near.

A decorated function answers for a box: what it yields lies in there, or says in which smaller boxes there is more. It
stands for a mesh in `World.add`, and its `serve` answers a print of a `.fab.json` that names its file as a `program`.
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
from pathlib import Path
from typing import Any, NamedTuple, TextIO, overload

import numpy as np
from numpy.typing import ArrayLike

from ._given import floats, integers, number, positive, short
from .errors import InputError

ROOT = "root"
"""The key of the first question."""

_TYPES = {"float": 1, "float2": 2, "float3": 3, "float4": 4, "int": 1}
_LONGEST_KEY = 63


class Bound(NamedTuple):
    """What a generator is asked for.

    Attributes
    ----------
    key : str
        What `more` called it; `procedural.ROOT` at first.
    low, high : float, three
        Two corners of the box that holds it, in mm: the world's at first, then that of `more`.
    """

    key: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


class Lines(NamedTuple):
    """What a generator yields: `beam`, `beams`, `mesh`, `place` and `more` make it.

    Attributes
    ----------
    word : str
        The first word of its lines.
    numbers : numpy.ndarray
        Floats of each line.
    values : mapping of str to Any
        Its attributes.
    more_lines : str
        Lines that follow.
    name : str
        A word after the first.
    """

    word: str
    numbers: Any
    values: Mapping[str, Any]
    more_lines: str = ""
    name: str = ""


def _three(value: Any, what: str) -> Any:
    found = floats(value, what, np.float64)
    if found.shape != (3,):
        raise InputError(f"{what} has the shape {found.shape}; it should be three numbers")
    return found


def beam(start: ArrayLike, end: ArrayLike, radius: Any, *, flat: bool = False, **values: Any) -> Lines:
    """Makes a beam: a round cone with balls at its ends, or one that is cut across.

    Parameters
    ----------
    start, end : array_like of float, shape (3,)
        Its ends, in mm.
    radius : float or two floats
        Its radius, or one for each end, in mm.
    flat : bool, optional
        Whether it is cut across at its ends, without balls.
    **values
        Attributes: a value, or for floats a pair of those at both ends.

    Returns
    -------
    Lines
        To be yielded.

    Raises
    ------
    InputError
        Where a number is none.
    """
    radii = np.broadcast_to(floats(radius, "`radius`", np.float64), (2,))
    numbers = np.concatenate([_three(start, "`start`"), _three(end, "`end`"), radii])
    return Lines("flat" if flat else "beam", numbers[None], {name: [value] for name, value in values.items()})


def beams(starts: ArrayLike, ends: ArrayLike, radii: ArrayLike, *, flat: bool = False, **values: Any) -> Lines:
    """Makes many beams of arrays, which is quicker than one by one.

    Parameters
    ----------
    starts, ends : array_like of float, shape (n, 3)
        Their ends, in mm.
    radii : array_like of float, shape (), (n,) or (n, 2)
        Radii in mm; of both ends of each where there are two.
    flat : bool, optional
        Whether they are cut across at their ends.
    **values
        Attributes: arrays of shape (n,), (n, components), or for floats of both ends (n, 2) and (n, 2, components).

    Returns
    -------
    Lines
        To be yielded.

    Raises
    ------
    InputError
        Where shapes do not go together, or a number is none.
    """
    first, second = floats(starts, "`starts`", np.float64), floats(ends, "`ends`", np.float64)
    if first.ndim != 2 or first.shape[1] != 3 or first.shape != second.shape:
        raise InputError(f"`starts` and `ends` have the shapes {first.shape} and {second.shape}; both should be (n, 3)")
    both = floats(radii, "`radii`", np.float64)
    if both.ndim == 1:
        both = both[:, None]
    try:
        both = np.broadcast_to(both, (len(first), 2))
    except ValueError as error:
        raise InputError(f"`radii` has the shape {both.shape}; it should be ({len(first)},) or ({len(first)}, 2)") from error
    return Lines("flat" if flat else "beam", np.concatenate([first, second, both], axis=1), values)


def mesh(vertices: ArrayLike, triangles: ArrayLike, **values: Any) -> Lines:
    """Makes a mesh: closed, its triangles counter-clockwise from outside.

    Parameters
    ----------
    vertices : array_like of float, shape (n, 3)
        In mm.
    triangles : array_like of int, shape (m, 3)
        Vertices, from 0.
    **values
        Attributes, of all of it.

    Returns
    -------
    Lines
        To be yielded.

    Raises
    ------
    InputError
        Where an array has another shape, or a number is none.
    """
    points, corners = floats(vertices, "`vertices`", np.float64), integers(triangles, "`triangles`")
    for found, what in ((points, "`vertices`"), (corners, "`triangles`")):
        if found.ndim != 2 or found.shape[1] != 3:
            raise InputError(f"{what} has the shape {found.shape}; it should be (n, 3)")
    text = "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points.tolist())
    text += "".join(f"{a} {b} {c}\n" for a, b, c in corners.tolist())
    counts = np.array([[len(points), len(corners)]])
    return Lines("mesh", counts, {name: [value] for name, value in values.items()}, text)


def place(name: str, at: ArrayLike, axes: ArrayLike | None = None, *, scale: float = 1, **values: Any) -> Lines:
    """Makes a copy of an object stand somewhere.

    Parameters
    ----------
    name : str
        What the world calls the object; the generator lists it in `places`.
    at : array_like of float, shape (3,)
        Where its origin is, in mm.
    axes : array_like of float, shape (3, 3), optional
        Rows: where its x, y and z point; at right angles, of one length, which scales it.
    scale : float, optional
        A factor.
    **values
        Attributes, of all of it.

    Returns
    -------
    Lines
        To be yielded.

    Raises
    ------
    InputError
        Where a number is none.
    """
    if not isinstance(name, str) or not name or any(c.isspace() or c == "," for c in name):
        raise InputError(f"{short(name)} is no word; an object that is placed by a program has a name without blanks")
    rows = np.eye(3) if axes is None else floats(axes, "`axes`", np.float64)
    if rows.shape != (3, 3):
        raise InputError(f"`axes` has the shape {rows.shape}; it should be (3, 3), a row for each axis")
    numbers = np.concatenate([_three(at, "`at`"), (rows * positive(scale, "`scale`")).ravel()])
    return Lines("place", numbers[None], {key: [value] for key, value in values.items()}, name=name)


def more(key: Any, low: ArrayLike, high: ArrayLike) -> Lines:
    """Says that there is more in a box: the generator is asked for it where a print comes near.

    Parameters
    ----------
    key : str or int
        A word of up to 63 bytes, without blanks: what the generator is asked with.
    low, high : array_like of float, shape (3,)
        Two corners of a box that holds all of it, in mm.

    Returns
    -------
    Lines
        To be yielded.

    Raises
    ------
    InputError
        Where the key is no word, or a number none.
    """
    word = str(key)
    if not word or len(word.encode()) > _LONGEST_KEY or any(c.isspace() or c in ",\0" for c in word):
        raise InputError(f"the key {short(word)} is no word of up to {_LONGEST_KEY} bytes, without blanks and commas")
    numbers = np.concatenate([_three(low, "`low`"), _three(high, "`high`")])
    return Lines("more", numbers[None], {}, name=word)


Function = Callable[[Bound], Iterable[Lines]]


class Generator:
    """A function that makes geometry where it is asked to. `generator` makes one.

    Parameters
    ----------
    function : callable
        It takes a Bound and yields what the functions of this module make.
    attributes : mapping of str to str, optional
        Names and types, `float` to `float4` and `int`, of what a fablet reads as `@nearest`.
    places : sequence of str, optional
        Names of objects of the world that it may place.
    version : str, optional
        Another one where what the function reads has changed, so that a print is not resumed with it.
    answer_s, answer_mb : float, optional
        Limits of an answer, instead of 60 and 64.

    Raises
    ------
    InputError
        Where a type is none.
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
        """Returns a solid that stands for a mesh in `World.add`.

        Parameters
        ----------
        box : array_like of float, shape (2, 3)
            Two corners of a box that holds all of it, in mm, the lower first.

        Returns
        -------
        Generated
            What the function makes, in the box.

        Raises
        ------
        InputError
            Where the box is none.
        """
        return Generated(self, box)

    def serve(self, questions: TextIO | None = None, answers: TextIO | None = None) -> None:
        """Answers a print until it has no more questions; it does not return where the function fails.

        Parameters
        ----------
        questions, answers : text file, optional
            The standard input and output. What the function prints goes to the standard error.
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
        """Returns the lines that answer a question of a print.

        Parameters
        ----------
        question : str
            `grow KEY X Y Z X Y Z`.

        Returns
        -------
        iterator of str
            Lines, without the last one, `done`.

        Raises
        ------
        InputError
            Where the function yields something else, or the question is none.
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
        """Returns the values of a float attribute at each end, (count, components)."""
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
        """Of what it does, as far as can be seen."""
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
    """What a generator makes, in a box; `Generator.within` makes it.

    Parameters
    ----------
    generator : Generator
        Who makes it.
    box : array_like of float, shape (2, 3)
        Two corners of a box that holds all of it, in mm, the lower first.

    Raises
    ------
    InputError
        Where the box is none.
    """

    def __init__(self, generator: Generator, box: ArrayLike) -> None:
        corners = floats(box, "`box`", np.float64)
        if corners.shape != (2, 3):
            raise InputError(f"`box` has the shape {corners.shape}; it should be (2, 3), two corners")
        if not (corners[0] < corners[1]).all():
            raise InputError("`box` is empty; its lower corner comes first")
        self.generator = generator
        self.box = corners

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
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
    """Makes a line to a generator, and a thread that answers there; returns its descriptor, or -1."""
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
    """Makes a generator of a function, as a decorator.

    Parameters
    ----------
    function : callable
        It takes a Bound and yields `beam`, `beams`, `mesh`, `place` and `more`. What it yields follows from the Bound alone.
    **given
        As of Generator: `attributes`, `places`, `version`, `answer_s`, `answer_mb`.

    Returns
    -------
    Generator
        For `World.add`, by its `within`, and for a file that a `.fab.json` names as a `program`, by its `serve`.

    Raises
    ------
    InputError
        Where a type of an attribute is none.

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
