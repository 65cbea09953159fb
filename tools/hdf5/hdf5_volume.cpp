// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/hdf5/hdf5_volume.h"

#include "texture/xdmf_grid.h"
#include "tools/hdf5/data_set.h"
#include "tools/hdf5/vtk_hdf.h"
#include "tools/texture/write_volume.h"
#include "tools/texture/xdmf_reader.h"

namespace openfab::tools {

Result<void> make_hdf5_volume_file(const std::filesystem::path& source,
                                   const std::filesystem::path& out,
                                   const texture::VolumeOptions& options,
                                   const texture::ReadLimits& limits) {
    return write_volume(source, out, options, limits, [&] {
        return texture::is_xdmf(source) ? open_xdmf(source, options, limits, open_data_set)
                                        : open_vtk_hdf(source, options, limits);
    });
}

}  // namespace openfab::tools
