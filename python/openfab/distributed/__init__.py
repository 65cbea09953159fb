# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints over many machines, with Dask.

print_world cuts a print into shares, has the workers of a Dask cluster print them, and writes them in order. The bytes
are the same as on one machine.
"""

from __future__ import annotations

try:
    import distributed as _distributed  # noqa: F401
except ImportError as _error:
    raise ImportError(
        "openfab.distributed stands on Dask, which is not installed; `pip install 'openfab[distributed]'` installs it"
    ) from _error

from .costs import ShareCost
from .printing import DistributedPrint, print_world, release
from .worker import ClusterError

__all__ = ["ClusterError", "DistributedPrint", "ShareCost", "print_world", "release"]
