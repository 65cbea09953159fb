// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from XDMF (texture/xdmf_grid.h). HDF5 files, in which its numbers may be, are read by a library
// that not every machine has (tools/hdf5).

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/array_numbers.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens the data set at this path of an HDF5 file, or a slab of it. Fails where its numbers
/// are not those of an array of `sizes` in their order. Must not outlive the file.
using OpenDataSet = std::function<Result<std::unique_ptr<ArrayNumbers>>(
    const InputFile& file, const std::string& set, const std::vector<int64_t>& sizes,
    const std::optional<texture::XdmfSlab>& slab)>;

/// Opens an XDMF file: its one grid, of the options' time where it has several steps, else of the first; of
/// tetrahedra, hexahedra and wedges (cell_field.h), rectilinear, curvilinear or regular. Numbers stand in it, or in data files beside it; those of
/// HDF5 files are refused without `open_set`.
MadeReader open_xdmf(const std::filesystem::path& file, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits, const OpenDataSet& open_set = {});

}  // namespace openfab::tools
