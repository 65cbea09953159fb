// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The stage of a part that a program of the user's makes: in the place of a fablet's @Grow stands a table without
// kernels, whose outputs are the attributes that the world declares.

#include <filesystem>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "world/world.h"

namespace openfab::part {

/// What stages of one program share.
struct ProgramTable {
    std::shared_ptr<const world::ProgramRef> program;
    std::vector<openfab_varying> outputs;
    openfab_shape shape{};
    openfab_fablet fablet{};
};

/// Makes the table. Its hash follows from the command, the files that it names, and what the world says of it.
std::shared_ptr<const ProgramTable> make_program_table(
    std::shared_ptr<const world::ProgramRef> program,
    const std::vector<std::filesystem::path>& roots);

}  // namespace openfab::part
