// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the curves of a list's specimens say, piece by piece and kind by kind.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/specimens/curve.h"
#include "tools/specimens/list.h"

namespace openfab::specimens {

struct MeasuredOptions {
    CurveOptions curve;  ///< without areas; `length_mm` 0: the piece's free length between grips
};

struct Measured {
    Specimen specimen;
    Properties properties;
};

/// A mean, and the standard deviation of `count` specimens, 0 for one.
struct Scatter {
    double mean = 0, deviation = 0;
    int count = 0;
};

struct Kind {
    std::vector<std::string> values;  ///< of List::columns
    Scatter modulus_MPa, strength_MPa, strain_at_break;
};

struct Measurements {
    std::vector<Measured> specimens;
    std::vector<Kind> kinds;             ///< in the list's order
    std::vector<int> missing;            ///< labels without a curve
    std::vector<std::string> unmatched;  ///< files without a label
    bool extensions = false;             ///< strains of some are extensions by the free length
};

/// Reads LABEL.csv, .txt, .tsv or .dat of each specimen in a folder; zeros may lead.
Result<Measurements> measure(const List& list, const std::filesystem::path& curves,
                             const MeasuredOptions& options);

/// A row a specimen.
std::string measured_text(const List& list, const Measurements& measured);

}  // namespace openfab::specimens
