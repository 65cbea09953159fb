# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Fablets: OpenFL sources, their uniforms and stages, and their kernels in this process."""

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
        Its name and type in the source.
    kind : str
        `value`, `texture2d`, `texture3d`, `material` or `object`.
    components : int
        The number of components of an element: 3 for a `float3`.
    array_length : int
        The number of elements; 1 if it is not an array.
    default : tuple of float or None
        All elements in order; None if a world has to bind it.
    annotations : mapping of str to str
        The texts of annotations such as `@min`, `@max` and `@help`.
    choices : tuple of tuple of str, str and int
        Name, label and value of each choice of an enum, or of a `bool` with labels. Any of the three may be given.
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
    """An input or output of a stage.

    Attributes
    ----------
    name, type : str
        Its name and type in the source.
    source : str or None
        The attribute that it copies, if any.
    """

    name: str
    type: str
    source: str | None = None


class Fablet:
    """A checked fablet, from a file or a text. Its kernels are compiled by `compile`, or else by the first print.

    Parameters
    ----------
    file : str or path, optional
        The source file. Give either this or `text`.
    name : str, optional
        The name of the fablet, if the source has several.
    text : str, optional
        The source text.
    label : str, optional
        The name of the text in messages; no file of that name is read or written.

    Attributes
    ----------
    uniforms : mapping of str to Uniform
        The uniforms, which a world sets.
    has_surface, has_shape, has_grow, uses_void : bool
        Whether it has a surface, shape or grow stage, and whether it uses VOID.
    shape_outputs, surface_inputs, surface_outputs, nearest : tuple of Varying
        The inputs and outputs of its stages.

    Raises
    ------
    CompileError
        If the source is wrong.
    InputError
        If the file cannot be read, has several fablets and no name is given, or has none with that name.

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
        """Returns the source file; a text is written to a temporary one.

        Returns
        -------
        pathlib.Path
            The file; for a text, a temporary file of this process.
        """
        if self.file is not None:
            return self.file
        assert self.text is not None
        # Equal texts with one label share a file, so that their kernels are found again. The label is the file's name, since
        # messages show it, but not its folder.
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
            The number of kernels that were not cached.

        Raises
        ------
        CompileError
            If the source has been changed since, and is wrong.
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
    """Makes a fablet and compiles its kernels for this machine.

    Parameters
    ----------
    file, name, text, label
        Arguments of `Fablet`.

    Returns
    -------
    Fablet
        A fablet whose prints compile nothing.

    Raises
    ------
    CompileError
        If the source is wrong.
    InputError
        If the source cannot be read.
    """
    fablet = Fablet(file, name, text=text, label=label)
    fablet.compile()
    return fablet


class Programs:
    """Compiled programs that prints share. A changed file is compiled again; a changed uniform compiles nothing."""

    MOST = 32

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[Any, ...], _core.Program] = OrderedDict()

    def find(
        self, sources: Iterable[Path], enable_printf: bool = False, rule: tuple[str, str] | None = None,
        derivatives: tuple[str, ...] = (),
    ) -> tuple[_core.Program, bool]:
        """Returns the program for some sources, and whether it had to be compiled.

        `rule` is the dither rule for fablets without their own: a file and a function in it. `derivatives`
        names uniforms by which fractions are differentiated.
        """
        files = tuple(str(source) for source in sources)
        key = (files, enable_printf, rule, derivatives, _stamps((*files, rule[0]) if rule else files))
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key], False
        program, said = _core.compile(list(files), enable_printf, rule, list(derivatives))
        check_diagnostics(said)
        assert program is not None
        with self._lock:
            self._kept[key] = program
            while len(self._kept) > self.MOST:
                self._kept.popitem(last=False)
        return program, True


def _stamps(files: tuple[str, ...]) -> tuple[Any, ...]:
    """Returns a key that changes if the sources, or any module that they may import, change."""
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
