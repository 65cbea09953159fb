// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Why a compilation ended.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "compiler/schedule/schedule.h"

namespace openfab::lower {

/// Why a compilation ended: a fault of the user's schedule, or a bug of ours.
struct Fault {
    std::optional<schedule::Fault> schedule;
    std::string trouble;      ///< without a schedule to blame
    bool is_outside = false;  ///< the trouble is the machine's: memory, descriptors, space, no tool
};

/// Returns what to do where a library or tool says that the system gave no memory, no descriptors or
/// no space; else an empty text. `folder`: where it wrote, if that is none for temporary files.
std::string remedy_of(const std::string& trouble, const std::filesystem::path& folder = {});

/// Makes a fault of what a library or tool says: the machine's where the system gave no memory, no
/// descriptors or no space, with what to do; else one of ours.
Fault fault_of(std::string trouble);

}  // namespace openfab::lower
