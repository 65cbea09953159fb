// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of one data set of an HDF5 file.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/array_numbers.h"

namespace openfab::tools {

/// Opens the data set at the path `set`, of integers or floats of any size and byte order, chunked and
/// compressed by what the library itself has, or not, or a slab of one. Fails where it has not the
/// numbers of an array of `sizes`, its sides are not those but for the way they are taken together, or the slab's
/// array has not its sides, or where it, or what leads to it, lies in another file: such names
/// were not checked against what may be read.
Result<std::unique_ptr<ArrayNumbers>> open_data_set(const InputFile& file, const std::string& set,
                                                    const std::vector<int64_t>& sizes,
                                                    const std::optional<texture::XdmfSlab>& slab);

}  // namespace openfab::tools
