// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interprets the IR, one voxel, vertex or patch at a time. It is the oracle that every other path
// is checked against, so it stays simple. It shares arithmetic with constant folding
// (compiler/ir/arithmetic.h) and defines texture lookups (compiler/interp/sample.h).

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/interp/sample.h"
#include "compiler/ir/ir.h"

namespace openfab::interp {

/// The inputs that a stage reads.
class Environment {
  public:
    virtual ~Environment() = default;
    /// Returns the bits of one input; kind, a, b as in ir::Instr. A bool is 0 or 1.
    virtual uint32_t input(int32_t kind, int32_t a, int32_t b) const = 0;
    virtual TextureView texture(int32_t index) const = 0;
    /// Returns one end of the interval of a lookup: `instr` is a SampleBound, `args` its evaluated
    /// arguments. The default, NaN, means unknown.
    virtual uint32_t sample_bound(const ir::Instr& instr, std::span<const uint32_t> args) const;
    /// Returns one result of a query whose guard holds; `query` is the Query, `args` its evaluated
    /// arguments, `result` the QueryResult. The default is 0.
    virtual uint32_t query(const ir::Instr& query, const ir::Instr& result,
                           std::span<const uint32_t> args) const;
    /// Receives a printf whose guard holds, with the bits of its values. The default drops it.
    virtual void printf(const ir::Printf& call, std::span<const uint32_t> values) const;
};

/// Returns the bits of every output, in the order of stage.outputs. The stage must pass ir::verify.
/// A lookup whose guard is false reads nothing and yields 0.
std::vector<uint32_t> evaluate(const ir::Stage& stage, const Environment& environment);

/// Returns the bits of a lookup whose guard holds; `args` are those of a Sample.
uint32_t evaluate_sample(const TextureView& texture, int32_t channel,
                         std::span<const uint32_t> args);

/// Returns the bits of every instruction, for tests; inside a loop those of the last iteration, 0
/// if none ran.
std::vector<uint32_t> evaluate_all(const ir::Stage& stage, const Environment& environment);

}  // namespace openfab::interp
