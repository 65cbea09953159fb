// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The effects that a print may have.

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/process/kind.h"
#include "world/process.h"

namespace openfab::process {

/// All kinds: effects on neighbours, and those on single voxels after them, change voxels in this order.
std::span<const Kind* const> kinds();

/// What is asked of effects, by the name of the option.
using Asked = std::map<std::string, std::string>;

/// Returns the kind with this option; null: none.
const Kind* find_option(std::string_view name);
/// Returns what is asked of a kind, its usual where `asked` has nothing.
std::string asked_of(const Kind& kind, const Asked& asked, bool as_built);

/// Reads the effects of a process, one for each kind.
Result<std::vector<std::unique_ptr<const Described>>> read_effects(const world::Process& process);
/// Returns the effects of a print.
Result<std::vector<std::unique_ptr<Effect>>> open_effects(const Print& print, const Asked& asked,
                                                          const Told& told);

}  // namespace openfab::process
