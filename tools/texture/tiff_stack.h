// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes whose slices are pages of TIFFs: one file or several, each of one page or more.

#include <filesystem>
#include <vector>

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Returns whether all files begin as TIFFs.
bool are_tiffs(const std::vector<std::filesystem::path>& files);

/// Opens the pages of the files, in their order, as slices; which pages are slices is what their first one
/// says (tiff_series.h), and of several channels the options' field is read. Numbers are those of the
/// file: unsigned ones of up to 16 bits become 0 to 1, others stay, colours of 8 bits are decoded from
/// sRGB. Returns no reader where the samples are colours of another kind, which open_stack reads.
MadeReader open_tiff_stack(const std::vector<std::filesystem::path>& files,
                           const texture::VolumeOptions& options,
                           const texture::ReadLimits& limits);

}  // namespace openfab::tools
