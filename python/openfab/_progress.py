# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Shows the progress of a print."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any

Progress = bool | Callable[[int, int], None]

class Bar:
    """A progress bar: tqdm's if it is installed, else a line of text; or calls of a function."""

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
                make = Line
            self._bar = make(total=total, unit="slice", leave=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class Line:
    """A substitute for tqdm on one line of stderr."""

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
