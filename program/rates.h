// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which derivatives of its fractions a print has: names of uniforms, and the columns of a voxel's derivatives.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "program/job.h"
#include "runtime/pipeline/print_options.h"

namespace openfab::program {

/// The columns of one uniform, one for each of its numbers.
struct RateColumns {
    std::string name;  ///< "ball.skin"
    int32_t first = 0;
    int32_t components = 1, array_length = 1;
    std::string type_name;  ///< "float2x2"
};

/// Returns the directions in which the volume of a fablet has derivatives, as indices among its values.
using DirectionsOf = std::function<std::span<const int32_t>(const openfab_fablet& fablet)>;

/// Finds the uniforms `OBJECT.UNIFORM` of a job, and lays out their columns in `columns`. The error names one that an
/// object has not.
Result<pipeline::Rates> find_rates(const Job& job, const std::vector<std::string>& names,
                                   const DirectionsOf& directions_of,
                                   std::vector<RateColumns>* columns);

}  // namespace openfab::program
