# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Exceptions. Their text is the message of the programs, with the location and a remedy."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NoReturn

from . import _core


class Error(Exception):
    """An error reported by OpenFab.

    Parameters
    ----------
    text : str
        The whole message, as the programs show it.
    message : str, optional
        The finding, without location and remedy. Default: the text.
    help : str, optional
        A remedy.
    file : str, optional
        The file with the error; empty without a location.
    line, column : int, optional
        The location in the file, counted from 1; 0 without a location.
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
    """A bug in OpenFab."""


class CompilerWarning(UserWarning):
    """A warning of the compiler about a fablet."""


class PrintWarning(UserWarning):
    """A warning of a print about its world."""


@dataclass(frozen=True)
class Place:
    """A stretch of source text.

    Attributes
    ----------
    file : str
        The source.
    line, column : int
        The first character, counted from 1.
    end_line, end_column : int
        The position just past the last character.
    """

    file: str
    line: int
    column: int
    end_line: int = 0
    end_column: int = 0


@dataclass(frozen=True)
class Note:
    """A location related to a diagnostic.

    Attributes
    ----------
    message : str
        How it is related.
    place : Place
        The location.
    """

    message: str
    place: Place


@dataclass(frozen=True)
class Edit:
    """A replacement of a stretch of source text.

    Attributes
    ----------
    place : Place
        The text to replace.
    text : str
        The replacement.
    """

    place: Place
    text: str


@dataclass(frozen=True)
class Diagnostic:
    """One message from the compiler.

    Attributes
    ----------
    id : str
        Its kind, such as `unknown-name`.
    severity : str
        `error` or `warning`.
    message : str
        The finding.
    place : Place
        Its location.
    notes : tuple of Note
        Related locations.
    help : tuple of str
        Remedies.
    fix : tuple of Edit
        Edits that fix it when applied together; empty if no fix is certain.
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
        The messages in the text.
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
    """Raises the errors that the compiler found, or issues its warnings."""
    if said.code == 0:
        if said.rendered:
            warnings.warn(said.rendered.rstrip(), CompilerWarning, stacklevel=4)
        return
    text = (said.rendered + said.fault).rstrip()
    if said.code == 1:
        raise CompileError(text, _diagnostics(said.json))
    raise (OutsideError if said.code == 3 else InternalError)(text)


def raise_error(error: _core.Error, names: Mapping[str, str] | None = None) -> NoReturn:
    """Raises the exception for an error of the runtime; `names` maps names in its text to those that the user knows."""
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


# Arguments whose names differ from the options of `openfab print`, and those with the same names.
_ARGUMENTS = {
    "-o": "out", "--set": "uniforms",
    **{
        f"--{name.replace('_', '-')}": name
        for name in (
            "allow", "allow_programs", "crop", "dither", "dpi", "draft", "format", "layer", "memory", "mesh_pitch",
            "preview", "printer", "process", "sampling", "seed", "slices", "support", "threads", "tls_ca",
            "token_file", "voxel", "z",
        )
    },
    **{option: option.removeprefix("--") for option in _core.effect_options()},
}


def worded(text: str) -> str:
    """Returns a message with Python arguments in place of options: `draft=4` for `--draft 4`."""
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
    """Returns the error with names replaced, and with Python arguments in place of options."""
    for key, value in vars(error).items():
        if isinstance(value, str):
            setattr(error, key, worded(replaced(value, names)))
    error.args = tuple(worded(replaced(one, names)) if isinstance(one, str) else one for one in error.args)
    return error


def replaced(text: str, names: Mapping[str, str]) -> str:
    """Returns a text with names replaced."""
    for name, known in names.items():
        text = text.replace(name, known)
    return text
