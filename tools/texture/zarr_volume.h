// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reader of volumes in stores of Zarr.

#include <filesystem>

#include "texture/zarr_store.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens an array of a store, which `file` describes. Numbers are as in open_npy, but those of labels stay as they are stored.
/// Chunks are decoded a layer at a time; a chunk that is not there has the fill value.
MadeReader open_zarr(const std::filesystem::path& file, texture::ZarrVolume volume,
                     const texture::ReadLimits& limits);

}  // namespace openfab::tools
