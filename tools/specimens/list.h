// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The list of test pieces, `specimens.csv`: what stands on each, what it is made of and how large it is. A lab changes
// widths and thicknesses to those that it measured.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/specimens/pieces.h"

namespace openfab::specimens {

struct Specimen {
    int label = 0, tray = 1;
    double width_mm = 0, thickness_mm = 0;  ///< of a disc its diameter and its height
    std::vector<std::string> values;        ///< of List::columns
};

struct List {
    const Piece* piece = nullptr;
    /// `share of NAME` for each material of mixtures, or names of uniforms.
    std::vector<std::string> columns;
    std::vector<Specimen> specimens;
    bool mixtures = true;
};

/// What the columns of shares begin with.
inline constexpr std::string_view kShareOf = "share of ";

std::string list_text(const List& list);
/// Reads list_text(), also with other columns and in another order. Errors name the line.
Result<List> read_list(const std::filesystem::path& file);

}  // namespace openfab::specimens
