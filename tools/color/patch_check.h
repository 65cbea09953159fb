// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds measurements that do not go with the others: an instrument put down beside its patch, a row of a
// table in another's place.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/color/printer_model.h"

namespace openfab::color {

struct PatchCheck {
    /// Those that are out of line, the worst first; what is predicted for them is by the others that are in
    /// line.
    std::vector<LeftOut> out_of_line;
    /// Of these, pairs that fit each other's place, in the order of the table.
    std::vector<std::pair<LeftOut, LeftOut>> exchanged;
    /// Of the white that does not look like one in light of D50.
    std::optional<Lab> tinted_white;
    bool disordered = false;  ///< so many that the table is of another chart, or in another order
};

PatchCheck check_patches(const SampleTable& table, const PrinterModel& model);

/// Returns a check as warnings; none where all is in line.
std::vector<std::string> format_patches(const PatchCheck& check, size_t patches);

}  // namespace openfab::color
