// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab specimens`: writes trays of test pieces, and makes data of what a testing machine measured.

#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

struct SpecimenTrayArguments {
    std::string printer, folder, piece = "d638-iv", thickness, along, gap = "5mm", fablet, sweep;
    std::vector<std::string> materials, mixtures, settings;
    int copies = 5, steps = 5;
};

struct SpecimenReadArguments {
    std::string folder, curves, source, temperature, rate, strain, stress, length,
        range = "0.0005:0.0025";
    std::vector<std::string> poisson;
};

Result<void> make_specimens(const SpecimenTrayArguments& arguments);
Result<void> read_specimens(const SpecimenReadArguments& arguments);

}  // namespace openfab::tools
