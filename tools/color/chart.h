// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Charts: patches to print and to measure, as a world with its fablet, and what comes back from
// them, as a photograph or as the slices of the print itself.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/picture.h"
#include "tools/color/samples.h"

namespace openfab::color {

/// Amounts of inks: white, wedges of each ink and of pairs, and mixtures of all of them that are
/// spread evenly, more of them where inks are few.
SampleTable ink_chart();
/// Colours of sRGB: a cube of them and a wedge of grey.
SampleTable color_chart();

/// Writes a folder: `chart.fab.json`, its fablet, `patches.nrrd`, and the table as `chart.txt`. A
/// chart of colours is printed through `ink_table`, a file that is copied.
Result<void> write_chart(const std::filesystem::path& folder, const SampleTable& chart,
                         const std::filesystem::path& ink_table);

/// How a photograph is read.
struct PhotographOptions {
    /// Of the chart in pixels of the upright picture, x and y from the top left: top left, top right, bottom
    /// right, bottom left of the chart; empty: those of the picture.
    std::vector<double> corners;
    /// What the white of the picture's profile counts as; without one, as itself.
    std::optional<Xyz> white;
};

/// Adds the means of a photograph's patches to a chart of inks.
Result<SampleTable> read_photograph(const Picture& picture, const SampleTable& chart,
                                    const PhotographOptions& options);

/// What came out of a print of a chart: for each patch the shares of cyan, magenta, yellow and
/// black in the middle of its skin.
struct PrintedChart {
    std::vector<Inks> patches;
    int64_t voxels = 0;  ///< of the smallest patch that were counted
};

/// Counts the materials of a chart's print, an .ofr file. Inks are the materials whose names
/// contain `cyan`, `magenta`, `yellow` and `black`, in any case.
Result<PrintedChart> read_print(const std::string& file, const SampleTable& chart, double skin_mm);

}  // namespace openfab::color
