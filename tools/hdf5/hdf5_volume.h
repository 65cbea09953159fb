// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from HDF5 files: by XDMF, whose numbers they hold, and VTKHDF.

#include <filesystem>

#include "base/result.h"
#include "texture/volume.h"

namespace openfab::tools {

/// Same as make_volume_file (tools/texture/convert_volume.h), for an XDMF file (xdmf_reader.h) or VTKHDF.
Result<void> make_hdf5_volume_file(const std::filesystem::path& source,
                                   const std::filesystem::path& out,
                                   const texture::VolumeOptions& options,
                                   const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
