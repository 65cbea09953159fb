# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Uniforms for a wanted print: runs `openfab fit`, and returns what it found.

The package does not have that program, which holds a compiler of its own: one on the PATH is run, or that of the variable
OPENFAB_PROGRAM.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import InputError, InternalError, OutsideError

__all__ = ["Fit", "FitGoal", "fit"]


@dataclass(frozen=True)
class FitGoal:
    """A goal, and three numbers.

    Attributes
    ----------
    name : str
        Its name, such as `share of black`.
    at_least, at_most : float or None
        What is wanted; twice the same: equal.
    mixtures : float
        What the mixtures come to, at the printer's own voxels; of mechanics at half the size of elements.
    printed : float or None
        What the dithered voxels come to that are printed; None where it could not be computed.
    reached : bool
        Whether it is wanted.
    """

    name: str
    at_least: float | None
    at_most: float | None
    mixtures: float
    printed: float | None
    reached: bool


@dataclass(frozen=True)
class Fit:
    """What `fit` found.

    Attributes
    ----------
    reached : bool
        Whether all goals are.
    uniforms : dict of str to Any
        The values, as `print_world(world, uniforms=…)` takes them.
    goals : tuple of FitGoal
        The goals, in their order.
    numbers : dict
        The content of `--json FILE`, with the history.
    """

    reached: bool
    uniforms: dict[str, Any]
    goals: tuple[FitGoal, ...]
    numbers: dict[str, Any]


def fit(
    world: str | os.PathLike[str],
    goals: Mapping[str, Any] | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    arguments: Sequence[str] = (),
) -> Fit:
    """Finds the uniforms for which a print is what is wanted, as `openfab fit` does.

    Parameters
    ----------
    world : path
        A `.fab.json`.
    goals : mapping or path
        The content of a file of goals, or the file: `{"unknowns": {"ball.skin": {"min": 0.1, "max": 5}}, "goals":
        [{"share": "black", "equal": 0.3}]}`.
    output : path, optional
        A world to write with what was found.
    arguments : sequence of str, optional
        Other options of `openfab fit`, such as `["--draft", "2"]`.

    Returns
    -------
    Fit
        The best that was found, whether or not it reaches all goals.

    Raises
    ------
    InputError
        If the world or the goals are wrong.
    OutsideError
        If there is no program, or a file cannot be written.

    Examples
    --------
    >>> found = openfab.fit("ball.fab.json", "goals.json")            # doctest: +SKIP
    >>> openfab.print_world(openfab.load("ball.fab.json"), "ball.ofr", uniforms=found.uniforms)   # doctest: +SKIP
    """
    program = os.environ.get("OPENFAB_PROGRAM") or shutil.which("openfab")
    if program is None:
        raise OutsideError(
            "there is no `openfab` on the PATH: the package has no program that fits; install OpenFab, or name its "
            "`openfab` in the variable OPENFAB_PROGRAM"
        )
    with tempfile.TemporaryDirectory(prefix="openfab-") as folder:
        if isinstance(goals, Mapping):
            file = Path(folder) / "goals.json"
            file.write_text(json.dumps({"openfab_fit": 1, **goals}, indent=4))
        else:
            file = Path(goals)
        numbers = Path(folder) / "fit.json"
        out = [] if output is None else ["-o", os.fspath(output)]
        try:
            done = subprocess.run(
                [program, "fit", os.fspath(world), os.fspath(file), "--json", str(numbers), *out, *arguments],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
        except OSError as error:
            raise OutsideError(f"cannot start `{program}`: {error.strerror}") from error
        # What is not reached ends with an error, after its numbers.
        if done.returncode != 0 and not (done.returncode == 1 and numbers.exists()):
            kinds = {1: InputError, 2: InputError, 4: InternalError}
            raise kinds.get(done.returncode, OutsideError)(done.stderr.strip())
        found: dict[str, Any] = json.loads(numbers.read_text())
    return Fit(
        reached=found["reached"],
        uniforms={name: json.loads(value) for name, value in (one.split("=", 1) for one in found["settings"])},
        goals=tuple(
            FitGoal(
                one["name"], one.get("at_least"), one.get("at_most"), one["mixtures"], one["printed"], one["reached"]
            )
            for one in found["goals"]
        ),
        numbers=found,
    )
