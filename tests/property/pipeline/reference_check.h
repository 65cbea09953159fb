// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiles fablets for a test, and compares prints of them with the plain reference bit for bit.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/code/jit.h"
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
/// Also fails if less than a twentieth of the voxels is solid: little would be compared.
void expect_reference(const std::vector<part::Part>& parts,
                      const std::vector<const ir::Fablet*>& sources, const Vec3d& pitch_mm,
                      uint64_t seed);

/// Prints the parts with each of some dithers; their mixtures, as a FractionSink takes them, must be the
/// same, and where `same_voxels` their voxels too.
void expect_same_dithers(const std::vector<part::Part>& parts, const Vec3d& pitch_mm, uint64_t seed,
                         const std::vector<std::string>& dithers, bool same_voxels);

/// Same for a print with support: its parts must equal the reference's, and at least the voxels
/// that a plain scan of the reference's columns requires must be support. Any excess support must
/// be within `reach_mm` of voxels of the reference along x and y, and at most that much below.
void expect_reference_and_support(const std::vector<part::Part>& parts,
                                  const std::vector<const ir::Fablet*>& sources,
                                  const Vec3d& pitch_mm, uint64_t seed, double reach_mm);

/// Prints slabs of the parts, is interrupted, and prints them once more, as a search does that ends with
/// a last comparison: the slabs must have the bits that a print without an interrupt gives them.
void expect_slabs_outlive_an_interrupt(const std::vector<part::Part>& parts, const Vec3d& pitch_mm);

/// Prints each slab of the parts a few times: after the first time, which fills caches, each must look up as
/// many patches as any other, so that their times can be compared.
void expect_repeated_slabs_are_equal_work(const std::vector<part::Part>& parts,
                                          const Vec3d& pitch_mm);

}  // namespace openfab::testing
