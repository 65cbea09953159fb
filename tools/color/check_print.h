// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Judges a print of a chart by what its voxels are: the mean amounts of each patch, as the dither
// made them, seen through the printer's profile, against what was asked.

#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/chart.h"
#include "tools/color/profile.h"

namespace openfab::color {

/// Differences (CIEDE2000) of some patches.
struct Differences {
    size_t count = 0;
    double mean = 0, worst = 0;
    std::string worst_id;
    void add(double difference, const std::string& id);
};

struct PrintCheck {
    bool of_colours = false;
    /// Between colours asked and colours of the print, of all patches of a chart of colours and of
    /// those that the profile's own conversion brings within 2.
    Differences all, reached;
    /// Between the colours of a patch's amounts as they were asked, or as the profile converts
    /// them, and as they are in the print.
    Differences amounts;
    double most_off = 0;  ///< of an amount, of a patch of a chart of inks
    int64_t voxels = 0;   ///< of the smallest patch that were counted
    SampleTable report;   ///< the patches with their means and the colours of those
};

/// Colours are relative to the print's white, as the relative colorimetric intent asks for.
Result<PrintCheck> check_print(const SampleTable& chart, const PrintedChart& printed,
                               const PrinterProfile& profile);

/// Returns some lines for people.
std::string format_check(const PrintCheck& check);

}  // namespace openfab::color
