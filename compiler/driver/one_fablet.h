// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The fablet that a command shows.

#include <optional>
#include <string>

#include "compiler/driver/options.h"
#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

struct OneFablet {
    std::optional<ir::Module> module;  ///< of the whole file
    const ir::Fablet* fablet = nullptr;
};

/// Compiles a file to the IR, and finds the fablet of a name in it, or the only one where `name` is empty. Prints what is
/// wrong, and returns the exit code, 0 where nothing is.
int read_fablet(const std::string& file, const std::string& name, bool enable_printf,
                const CommonOptions& common, source::SourceManager* sources, OneFablet* out);

}  // namespace openfab::driver
