// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print's top is made of, for proofs: its inks as the dither laid them, in windows as an eye
// takes the mean of them.

#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"
#include "tools/color/samples.h"

namespace openfab::color {

/// Number of cyan, magenta, yellow and black for each code; -1 for void and every other material. Fails
/// where one of them is missing: inks are the materials whose names contain these words, in any case.
Result<std::vector<int>> inks_of_codes(const pipeline::PrintInfo& info, const std::string& file);

/// The top of a print, as it is seen from above.
struct PrintTop {
    int width = 0, height = 0;
    /// Of each window from the top left, shares of cyan, magenta, yellow and black of its skin.
    std::vector<Inks> windows;
    std::vector<bool> is_there;  ///< false where nothing was printed
};

/// Reads the uppermost `skin_mm` of each column of voxels of an .ofr file, and takes the mean of it over
/// windows of about `window_mm`. Support is washed off, and materials with `clear` in their names, such as a
/// coat over the skin, are looked through. Fails where windows are smaller than voxels, or
/// the print's area takes more than `memory_bytes`.
Result<PrintTop> read_print_top(const std::string& file, double window_mm, double skin_mm,
                                int64_t memory_bytes);

}  // namespace openfab::color
