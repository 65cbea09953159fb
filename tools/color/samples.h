// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables of patches: what a chart asks for, and what was measured of its print. As files they are
// CGATS.17 text, which programs for instruments write (`.ti3`, `.txt`), or a CSV with the same names
// of columns, or CxF (cxf.h):
//
//   SAMPLE_ID                         any word, optional
//   CMYK_C CMYK_M CMYK_Y CMYK_K       amounts of ink in percent of the voxels; white is the rest
//   LAB_L LAB_A LAB_B                 measured, D50; or
//   XYZ_X XYZ_Y XYZ_Z                 measured, D50, Y = 100 for a perfect white; or
//   SPEC_380 … or other names         measured reflectances (spectra.h), from which colours are computed
//                                     whatever else there is; or
//   RGB_R RGB_G RGB_B                 0..255 of sRGB: measured, by a camera, where there are amounts
//                                     and nothing better; else the colours that a chart asks for

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "tools/color/lab.h"
#include "tools/color/spectra.h"

namespace openfab::color {

/// Amounts of cyan, magenta, yellow and black ink, 0..1 of the voxels each.
using Inks = std::array<double, 4>;

struct Sample {
    std::string id;
    Inks inks{};
    Rgb rgb{};  ///< sRGB, 0..1
    Lab lab;    ///< measured
};

struct SampleTable {
    bool has_inks = false;
    bool has_rgb = false;
    bool has_lab = false;
    bool is_chart = false;  ///< the file says so: colours in it are expected, not measured
    /// Where the table is of a chart: patches in a row, of which the first row is at the top.
    int columns = 0;
    std::string note;  ///< what was chosen of several measurements
    std::vector<Sample> samples;
};

/// What of several measurements counts.
struct Measure {
    Light light = Light::kD50;  ///< spectra are seen under
    std::string condition;  ///< of several in a CxF: `M0` to `M3`; empty: the first of M1, M0, M2
};

/// Parses a table, or CxF (cxf.h); errors have a line or an object but not the file's name.
Result<SampleTable> parse_samples(std::string_view text, const Measure& measure = {});
/// Reads a file; errors name it.
Result<SampleTable> read_samples(const std::filesystem::path& file, const Measure& measure = {});

/// Clamps amounts to 0..1 and their sum, rounded to 8 bits, to 1; complains of larger sums.
Complaint settle_inks(Inks* inks);

/// Formats a table as CGATS.17. `description` is one line.
std::string format_samples(const SampleTable& table, const std::string& description);

}  // namespace openfab::color
