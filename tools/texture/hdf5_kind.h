// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tells HDF5 files apart without the library, which not every machine has.

#include "base/input_file.h"

namespace openfab::tools {

/// Returns whether a file is HDF5: its signature stands at its beginning or behind 512, 1024, ... bytes of another
/// program.
bool is_hdf5(const InputFile& file);

/// Returns whether it is HDF5 that holds a grid of VTK: its group is named in the first of its tables of names.
bool is_vtk_hdf(const InputFile& file);

}  // namespace openfab::tools
