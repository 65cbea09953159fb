// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets compiled for a test, and prints of them compared with the plain reference to the bit.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/jit.h"
#include "runtime/part/part.h"

namespace openfab::testing {

/// Fablets of one source text, as IR and compiled.
struct Compiled {
    ir::Module module;
    std::unique_ptr<lower::LoadedProgram> program;

    size_t find(const std::string& name) const;
    const openfab_fablet& table(const std::string& name) const {
        return *program->fablets().fablets[find(name)];
    }
    const ir::Fablet& source(const std::string& name) const { return module.fablets[find(name)]; }
};

/// Fails the test where it does not compile.
Compiled compile(const std::filesystem::path& file);

/// Prints the parts with four materials, and compares every voxel with tests/support/reference.
/// Fails also where less than a twentieth of the voxels is solid: nothing would be compared.
void expect_reference(const std::vector<part::Part>& parts,
                      const std::vector<const ir::Fablet*>& sources, const Vec3d& pitch_mm,
                      uint64_t seed);

/// The same of a print with support, whose parts must be the reference's; of the other voxels at
/// least those are support that a plain scan of the reference's columns calls for. What is more
/// has voxels of the reference not farther away than `reach_mm` along x and y, and at most that
/// much below.
void expect_reference_and_support(const std::vector<part::Part>& parts,
                                  const std::vector<const ir::Fablet*>& sources,
                                  const Vec3d& pitch_mm, uint64_t seed, double reach_mm);

}  // namespace openfab::testing
