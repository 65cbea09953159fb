// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the Funcs of a scheduled kernel could be computed instead: what a search of schedules
// chooses from.

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/lower/schedule/kernel_request.h"

namespace openfab::lower {

struct FuncSites {
    std::string func;
    bool is_result = false;
    /// Directives that place it, the one that stores most first: `compute_root()`,
    /// `compute_at(slab, batch)`. None of a result.
    std::vector<std::string> sites;
    std::optional<size_t> current;  ///< of those, where it is; none where it is inline
    /// Its serial loops that are no reduction's, first the innermost.
    std::vector<std::string> serial_loops;
};

/// Returns the Funcs that a schedule may name, consumers first, as the request's schedule has them.
std::variant<std::vector<FuncSites>, schedule::Fault> list_sites(const KernelRequest& request);

}  // namespace openfab::lower
