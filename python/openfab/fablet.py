# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Fablets: OpenFL sources, what they take, and their kernels in this process."""

from __future__ import annotations

import hashlib
import html
import json
import os
import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Iterable, Mapping

from . import _core, _files
from .errors import InputError, check_diagnostics


@dataclass(frozen=True)
class Uniform:
    """A uniform as a fablet declares it.

    Attributes
    ----------
    name, type : str
        As the source says.
    kind : str
        `value`, `texture2d`, `texture3d`, `material` or `object`.
    components : int
        Numbers of one element: 3 of a `float3`.
    array_length : int
        Elements; 1 of what is no array.
    default : tuple of float or None
        All elements in order; None where a world has to bind it.
    annotations : mapping of str to str
        The texts of `@min`, `@max`, `@help` and the like.
    choices : tuple of tuple of str, str and int
        Name, label and value of each of an enum's names, or of a `bool`'s that has labels; a value may be given by any.
    """

    name: str
    type: str
    kind: str
    components: int
    array_length: int
    default: tuple[float, ...] | None
    annotations: Mapping[str, str] = field(default_factory=dict)
    choices: tuple[tuple[str, str, int], ...] = ()


@dataclass(frozen=True)
class Varying:
    """An attribute that a stage takes or gives.

    Attributes
    ----------
    name, type : str
        As the source says.
    source : str or None
        The one that it copies, if any.
    """

    name: str
    type: str
    source: str | None = None


class Fablet:
    """A fablet that compiles, from a file or a text. Its kernels are compiled by `compile`, or else by the first print.

    Parameters
    ----------
    file : str or path, optional
        The source. It, or `text`, is given.
    name : str, optional
        Of a source with several fablets, the one that is meant.
    text : str, optional
        The source itself.
    label : str, optional
        What a text is called in messages; no file of that name is read or written.

    Attributes
    ----------
    uniforms : mapping of str to Uniform
        What it takes from a world.
    has_surface, has_shape, has_grow, uses_void : bool
        Whether it has a surface stage, a shape stage, a grow stage; whether it names VOID.
    shape_outputs, surface_inputs, surface_outputs, nearest : tuple of Varying
        What its stages take and give.

    Raises
    ------
    CompileError
        Where the source is wrong.
    InputError
        Where the file cannot be read, or has several fablets or none of that name.

    Examples
    --------
    >>> Fablet("ball.fl")                                   # doctest: +SKIP
    >>> Fablet(text='''fablet Ball { … }''')                # doctest: +SKIP
    """

    def __init__(
        self, file: str | os.PathLike[str] | None = None, name: str | None = None, *, text: str | None = None,
        label: str = "fablet.fl",
    ) -> None:
        if (file is None) == (text is None):
            raise InputError("a fablet is made from a file or from a text, one of them")
        if text is not None and not label:
            raise InputError("`label` is empty; it is what the text is called in messages")
        self.file = None if file is None else Path(file).absolute()
        self.text = text
        self.label = label if self.file is None else self.file.name
        if self.file is not None:
            interface = _core.read_file_interface(Path(os.fspath(file)))  # type: ignore[arg-type]
        else:
            interface = _core.read_text_interface(label, text or "")
        check_diagnostics(interface.diagnostics)
        fablets = {one["name"]: one for one in json.loads(interface.json)["fablets"]}
        if name is None and len(fablets) > 1:
            raise InputError(f"{self.label} has several fablets: {', '.join(fablets)}; name one")
        if name is not None and name not in fablets:
            raise InputError(f"{self.label} has no fablet `{name}`; it has {', '.join(fablets)}")
        data = fablets[name] if name is not None else next(iter(fablets.values()))
        self.name: str = data["name"]
        self.has_surface: bool = data["has_surface"]
        self.has_shape: bool = data["has_shape"]
        self.has_grow: bool = data["has_grow"]
        self.uses_void: bool = data["uses_void"]
        self.uniforms: Mapping[str, Uniform] = MappingProxyType({u["name"]: _uniform(u) for u in data["uniforms"]})
        self.shape_outputs = tuple(Varying(v["name"], v["type"]) for v in data["shape_outputs"])
        self.surface_inputs = tuple(Varying(v["name"], v["type"]) for v in data["surface_inputs"])
        self.surface_outputs = tuple(Varying(v["name"], v["type"], v["copies"]) for v in data["surface_outputs"])
        self.nearest = tuple(Varying(v["name"], v["type"], v["from"]) for v in data["nearest"])

    def source(self) -> Path:
        """Returns the file of the source; a text is written to one.

        Returns
        -------
        pathlib.Path
            Of a text, a temporary file of this process.
        """
        if self.file is not None:
            return self.file
        assert self.text is not None
        # Equal texts of one label share a file, so that their kernels are found again. The label names the file, since
        # messages show it, but not its place.
        digest = hashlib.sha256(f"{self.label}\0{self.text}".encode()).hexdigest()[:16]
        path = _files.folder() / f"text-{digest}" / _files.file_name(self.label.rsplit("/", 1)[-1])
        with _files.lock, _files.outside_errors(f"`{path}` cannot be written"):
            if not path.exists():
                path.parent.mkdir(exist_ok=True)
                begun = path.with_name("begun")
                begun.write_bytes(self.text.encode())
                begun.rename(path)
        return path

    def compile(self) -> int:
        """Compiles the kernels now.

        Returns
        -------
        int
            How many were in no cache.

        Raises
        ------
        CompileError
            Where the source has changed since, and is wrong.
        """
        program, is_new = programs.find([self.source()])
        return program.compiled if is_new else 0

    def __reduce__(self) -> Any:
        return _made_again, (self.file, self.name, self.text, self.label)

    def __repr__(self) -> str:
        return f"Fablet({self.label!r}, {self.name!r})"

    def _repr_html_(self) -> str:
        def cell(value: Any) -> str:
            return f"<td>{html.escape(str(value))}</td>"

        rows = "".join(
            "<tr>"
            + cell(u.name)
            + cell(u.type + (f"[{u.array_length}]" if u.array_length > 1 else ""))
            + cell("" if u.default is None else ", ".join(str(value) for value in u.default))
            + cell("; ".join(text if key == "help" else f"{key} {text}" for key, text in u.annotations.items()))
            + "</tr>"
            for u in self.uniforms.values()
        )
        head = "".join(f"<th>{word}</th>" for word in ("uniform", "type", "default", ""))
        return f"<b>{html.escape(self.name)}</b><table><tr>{head}</tr>{rows}</table>"


def _made_again(file: Path | None, name: str, text: str | None, label: str) -> Fablet:
    return Fablet(file, name) if text is None else Fablet(name=name, text=text, label=label)


def _uniform(data: dict[str, Any]) -> Uniform:
    default = None if data["default"] is None else tuple(data["default"])
    return Uniform(
        data["name"], data["type"], data["kind"], data["components"], data["array_length"], default,
        MappingProxyType(data["annotations"]),
        tuple((one["name"], one["label"], one["value"]) for one in data.get("choices", ())),
    )


def compile(  # noqa: A001: it is what openflc calls it
    file: str | os.PathLike[str] | None = None, name: str | None = None, *, text: str | None = None,
    label: str = "fablet.fl",
) -> Fablet:
    """Makes a fablet with its kernels compiled, for this machine.

    Parameters
    ----------
    file, name, text, label
        As of Fablet.

    Returns
    -------
    Fablet
        Prints of it compile nothing.

    Raises
    ------
    CompileError
        Where the source is wrong.
    InputError
        Where it cannot be read.
    """
    fablet = Fablet(file, name, text=text, label=label)
    fablet.compile()
    return fablet


class Programs:
    """Compiled programs that prints share; a change of a file compiles it again, a change of a uniform does not."""

    MOST = 32

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[Any, ...], _core.Program] = OrderedDict()

    def find(
        self, sources: Iterable[Path], enable_printf: bool = False, rule: tuple[str, str] | None = None,
    ) -> tuple[_core.Program, bool]:
        """Returns the program of some sources, and whether it was compiled for it.

        `rule` is the dither rule of fablets without one: a file, and its function.
        """
        files = tuple(str(source) for source in sources)
        key = (files, enable_printf, rule, _stamps((*files, rule[0]) if rule else files))
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key], False
        program, said = _core.compile(list(files), enable_printf, rule)
        check_diagnostics(said)
        assert program is not None
        with self._lock:
            self._kept[key] = program
            while len(self._kept) > self.MOST:
                self._kept.popitem(last=False)
        return program, True


def _stamps(files: tuple[str, ...]) -> tuple[Any, ...]:
    """What tells the sources, and all that they may import, from what they were before."""
    modules = sorted({str(m) for f in files for m in [Path(f), *Path(f).parent.glob("*.fl")]})
    out = []
    for module in modules:
        try:
            status = os.stat(module)
        except OSError:
            continue
        out.append((module, status.st_mtime_ns, status.st_size, status.st_ino))
    return tuple(out)


programs = Programs()
