// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The slow, plain evaluator of the IR: one voxel, vertex or patch at a time. It is the oracle that
// every other path is checked against, so it stays simple. It shares arithmetic with constant
// folding (compiler/ir/arithmetic.h) and defines texture look-ups (compiler/interp/sample.h).

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/interp/sample.h"
#include "compiler/ir/ir.h"

namespace openfab::interp {

/// What a stage reads from outside.
class Environment {
  public:
    virtual ~Environment() = default;
    /// Bits of one input; kind, a, b as of ir::Instr. A bool is 0 or 1.
    virtual uint32_t input(int32_t kind, int32_t a, int32_t b) const = 0;
    virtual TextureView texture(int32_t index) const = 0;
    /// An end of the interval of a look-up: `instr` is a SampleBound, `args` its evaluated
    /// arguments. The default, NaN, means that nothing is known.
    virtual uint32_t sample_bound(const ir::Instr& instr, std::span<const uint32_t> args) const;
    /// One result of a query whose guard holds; `query` is the Query, `args` its evaluated
    /// arguments, `result` the QueryResult. The default is 0.
    virtual uint32_t query(const ir::Instr& query, const ir::Instr& result,
                           std::span<const uint32_t> args) const;
    /// A print whose guard holds, with its values' bits. The default drops it.
    virtual void print(const ir::Print& print, std::span<const uint32_t> values) const;
};

/// Bits of every output, in the order of stage.outputs. The stage must pass ir::verify. A look-up
/// whose guard is false reads nothing and gives 0.
std::vector<uint32_t> evaluate(const ir::Stage& stage, const Environment& environment);

/// Bits of every instruction, for tests that look inside; of one inside a loop as the last trip
/// left it, 0 where none ran.
std::vector<uint32_t> evaluate_all(const ir::Stage& stage, const Environment& environment);

}  // namespace openfab::interp
