// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print is written to, which `openfab export`, `merge` and `receive` write as well.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "backends/preview/preview_spec.h"

namespace openfab::program {

/// A file or folder that a command writes, with the option that named it: "`-o`".
struct NamedOutput {
    std::string option;
    std::filesystem::path path;
};

struct OutputOptions {
    std::string output;      ///< empty: none; `-` standard output; or an address (stream/address.h)
    std::string format;      ///< empty: from the output's extension, else the printer's own
    std::string token_file;  ///< of a receiver that wants a token
    std::string tls_ca;      ///< certificates to trust; empty: the system's
    bool resume = false;     ///< continues an interrupted print in the output
    bool png_indexed = false;   ///< with a palette instead of RGBA
    std::string grey_material;  ///< that grey pictures are of; empty: the first
    bool flip_x = false;
    std::vector<preview::PreviewSpec> previews;  ///< without a file those that the host draws
    std::string stats_file;
    std::string extents_file;    ///< for our own tools: no print, but how far placements reach
    std::string fractions_file;  ///< takes mixtures before the dither; empty: none
    /// Parts of a voxel's side that they are the means of; empty: as `sample_centres` says.
    std::optional<int32_t> fractions_supersample;
    bool sample_centres = false;      ///< --sampling centre: fractions are those at voxels' centres
    std::vector<std::string> inputs;  ///< files besides the world's that outputs must not overwrite
    std::vector<NamedOutput> more_outputs;  ///< files that the host writes at its end
};

}  // namespace openfab::program
