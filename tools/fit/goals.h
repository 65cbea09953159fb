// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is wanted of a print, and which uniforms may move for it: GOALS.json, checked against the world.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "base/vec.h"
#include "program/kept_print.h"
#include "tools/fit/search.h"
#include "world/world.h"

namespace openfab::fit {

/// A uniform of an object, or a component of one, that may move.
struct Unknown {
    std::string name;  ///< as written: `ball.skin`, `ball.tint[1]`
    std::string object, uniform;
    int32_t component = -1;  ///< -1: all of a scalar; of a curve's keys, one value or three each
    std::optional<world::Curve> curve;
    std::string
        element;  ///< what derivatives are asked by (abi/element_name.h), and which of its numbers this is
    int32_t number = 0;
    openfab_scalar_type scalar = OPENFAB_FLOAT;
    double min = 0, max = 0, start = 0;
    std::vector<double> now;  ///< all components, as they are; of a curve the values of its keys
    /// JSON of the values of one that is searched through instead.
    std::vector<std::string> choices;
    SourceLocation location;

    bool is_discrete() const { return !choices.empty(); }
};

/// The first five are amounts, which a print is counted for; the others are solved for by `openfab mechanics`.
enum class Quantity {
    kShare,
    kVolume,
    kWeight,
    kCost,
    kProperty,
    kMoved,
    kDeflection,
    kWork,
    kOhm,
    kKelvinPerWatt,
    kYoung,
    kPoisson,
    kStiffness,
};

struct Goal {
    std::string name;  ///< of tables and messages: its own, or such as `share of black`
    Quantity quantity = Quantity::kShare;
    int32_t material = -1;  ///< index in the world's materials; -1: all
    size_t region = 0;      ///< in Goals::regions
    std::vector<std::string>
        solve;  ///< words of `openfab mechanics` but the world and uniforms; none of an amount
    std::array<int32_t, 2> entry{};  ///< of several numbers under one key
    std::string unit;                ///< of a property's table
    double least = 0, most = 0;      ///< likewise: its values
    Wanted wanted;

    bool is_amount() const { return solve.empty(); }
    SourceLocation location;
};

/// Voxels that goals are about.
struct Region {
    program::SumRegion voxels;
    std::string object;  ///< of this one alone, as if it had no others beside it; empty: of all
};

struct Goals {
    std::vector<Unknown> unknowns;
    std::vector<Goal> goals;
    std::vector<Region> regions;

    bool ask_cost() const;
};

/// Reads a file of goals; `settings` are those of the command line. Errors name its place: keys and names that nothing has, with the nearest; bounds without a
/// value between them; goals that contradict each other.
Result<Goals> read_goals(const std::filesystem::path& file, const world::World& world,
                         const openfab_fablet_list& fablets,
                         const std::vector<std::string>& settings);

/// Returns the unit of a goal, with a space before it, as numbers are shown; empty for a share.
std::string unit_of(const Goal& goal);

}  // namespace openfab::fit
