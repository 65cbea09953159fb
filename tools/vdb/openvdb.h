// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// OpenVDB's headers. The static members of its templates, such as the registry of grids, are those of the
// library: in programs that hide their symbols they would be others, which nothing initialises.
#pragma GCC visibility push(default)
#include <openvdb/openvdb.h>
#pragma GCC visibility pop
