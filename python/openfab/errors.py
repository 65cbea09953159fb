# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What can be wrong, as exceptions. Their text is what the programs show, with place and remedy."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from . import _core


class Error(Exception):
    """Something that OpenFab reports.

    Parameters
    ----------
    text : str
        All of it, as the programs show it.
    message : str, optional
        What was found, without place and remedy; the text where it is not given.
    help : str, optional
        A way out.
    file : str, optional
        Where it was found; empty where there is no place.
    line, column : int, optional
        The place in the file, counted from 1; 0 where there is none.
    """

    def __init__(
        self, text: str, *, message: str = "", help: str = "", file: str = "", line: int = 0, column: int = 0
    ) -> None:
        super().__init__(text if message or not help else f"{text}; {help}")
        self.message = message or text
        self.help = help
        self.file = file
        self.line = line
        self.column = column


class InputError(Error, ValueError):
    """An input or an argument is wrong."""


class OutsideError(Error):
    """The outside world failed: a disk, a network, memory, a missing program."""


class InternalError(Error):
    """A bug of OpenFab's."""


class CompilerWarning(UserWarning):
    """The compiler warns of a fablet."""


class PrintWarning(UserWarning):
    """A print warns of its world."""


@dataclass(frozen=True)
class Place:
    """A stretch of source text.

    Attributes
    ----------
    file : str
        The source.
    line, column : int
        Its first character, counted from 1.
    end_line, end_column : int
        Just past its last character.
    """

    file: str
    line: int
    column: int
    end_line: int = 0
    end_column: int = 0


@dataclass(frozen=True)
class Note:
    """A place that has to do with a diagnostic.

    Attributes
    ----------
    message : str
        What it has to do with it.
    place : Place
        Where it is.
    """

    message: str
    place: Place


@dataclass(frozen=True)
class Edit:
    """Text in place of a stretch of source.

    Attributes
    ----------
    place : Place
        What is replaced.
    text : str
        What takes its place.
    """

    place: Place
    text: str


@dataclass(frozen=True)
class Diagnostic:
    """One message of the compiler.

    Attributes
    ----------
    id : str
        Its kind, such as `unknown-name`.
    severity : str
        `error` or `warning`.
    message : str
        What was found.
    place : Place
        Where.
    notes : tuple of Note
        Other places that have to do with it.
    help : tuple of str
        Ways out.
    fix : tuple of Edit
        Edits that mend it, applied together; there are none in doubt.
    """

    id: str
    severity: str
    message: str
    place: Place
    notes: tuple[Note, ...] = ()
    help: tuple[str, ...] = ()
    fix: tuple[Edit, ...] = field(default=())


class CompileError(InputError):
    """A fablet does not compile.

    Parameters
    ----------
    text : str
        The messages as `openflc` shows them, with carets.
    diagnostics : tuple of Diagnostic, optional
        The messages that the text renders.
    """

    def __init__(self, text: str, diagnostics: tuple[Diagnostic, ...] = ()) -> None:
        first = next((d for d in diagnostics if d.severity == "error"), None)
        if first is None:
            super().__init__(text)
        else:
            place = first.place
            super().__init__(
                text, message=first.message, help="; ".join(first.help), file=place.file, line=place.line,
                column=place.column,
            )
        self.diagnostics = diagnostics


def _place(data: dict[str, object]) -> Place:
    keys = ("line", "column", "end_line", "end_column")
    return Place(str(data["file"]), *(int(data.get(key, 0)) for key in keys))  # type: ignore[call-overload]


def _diagnostics(text: str) -> tuple[Diagnostic, ...]:
    if not text:
        return ()
    return tuple(
        Diagnostic(
            d["id"],
            d["severity"],
            d["message"],
            _place(d),
            tuple(Note(n["message"], _place(n)) for n in d["notes"]),
            tuple(d["help"]),
            tuple(Edit(_place(e), e["text"]) for e in d["fix"]),
        )
        for d in json.loads(text)["diagnostics"]
    )


def check_diagnostics(said: _core.Diagnostics) -> None:
    """Raises what the compiler found, or warns of it."""
    if said.code == 0:
        if said.rendered:
            warnings.warn(said.rendered.rstrip(), CompilerWarning, stacklevel=4)
        return
    text = (said.rendered + said.fault).rstrip()
    if said.code == 1:
        raise CompileError(text, _diagnostics(said.json))
    raise (OutsideError if said.code == 3 else InternalError)(text)


def raise_error(error: _core.Error, names: Mapping[str, str] | None = None) -> NoReturn:
    """Raises the exception of an error of the runtime's; `names` are those that the user knows, for what it says."""
    if error.code == 130:
        raise KeyboardInterrupt
    kind = {1: InputError, 2: InputError, 3: OutsideError}.get(error.code, InternalError)
    said = kind(
        error.rendered.rstrip().removeprefix("error: "),
        message=error.message,
        help=error.help,
        file=error.file,
        line=error.line,
        column=error.column,
    )
    raise renamed(said, names or {})


# Arguments that are called otherwise than the options of `openfab print`, and those that are called the same.
_ARGUMENTS = {
    "-o": "out", "--set": "uniforms",
    **{
        f"--{name.replace('_', '-')}": name
        for name in (
            "allow", "allow_programs", "bleed", "crop", "dither", "dpi", "draft", "format", "layer", "memory", "mesh_pitch",
            "nozzles", "preview", "printer", "process", "sampling", "seed", "slices", "support", "threads", "tls_ca",
            "token_file", "voxel", "z",
        )
    },
}


def worded(text: str) -> str:
    """Returns a message with arguments of Python in the place of options: `draft=4` for `--draft 4`."""
    return re.sub(r"`(--?[a-z][^`]*)`", _argument, text)


def _argument(option: re.Match[str]) -> str:
    parts = re.split(r" (?=--?[a-z])", option[1])
    said = []
    for part in parts:
        name, space, value = part.partition(" ")
        if name not in _ARGUMENTS:
            return option[0]
        argument = _ARGUMENTS[name]
        said.append(f"{argument}={_value(argument, value)}" if space else argument)
    return f"`{', '.join(said)}`"


def _value(argument: str, text: str) -> str:
    if argument in ("slices", "z"):
        return f"({', '.join(_value('', one) for one in text.split(':'))})"
    if argument == "uniforms":
        target, _, value = text.partition("=")
        return f'{{"{target}": {value or "…"}}}'
    return text if re.fullmatch(r"-?[0-9.]+", text) else json.dumps(text, ensure_ascii=False)


def renamed(error: Error, names: Mapping[str, str]) -> Error:
    """Returns the error with other texts in the place of some, and arguments in that of options."""
    for key, value in vars(error).items():
        if isinstance(value, str):
            setattr(error, key, worded(replaced(value, names)))
    error.args = tuple(worded(replaced(one, names)) if isinstance(one, str) else one for one in error.args)
    return error


def replaced(text: str, names: Mapping[str, str]) -> str:
    """Returns a text with others in the place of some."""
    for name, known in names.items():
        text = text.replace(name, known)
    return text
