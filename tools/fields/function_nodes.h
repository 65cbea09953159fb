// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A compiled stage as nodes of a 3MF function (implicit extension): the other way of function_text.h.
// Every value of a stage is a scalar, so that each instruction is a node or a few. Arithmetic is what it
// was, in the same order: what `openfab import` makes of it has the same bits.

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "tools/fields/fablet_ir.h"
#include "tools/fields/stage_bounds.h"

namespace openfab::tools {

/// A value of a function: a number, or what a node gives.
struct NodeValue {
    bool is_number = true;
    float number = 0;
    std::string ref;  ///< "NODE.OUTPUT"
    bool is_vector = false;

    bool is(float x) const { return is_number && number == x; }
};

class FunctionNodes {
  public:
    /// `place`: where the function is asked.
    explicit FunctionNodes(const StagePlace& place) : place_(place) {}

    /// Sets the values of the uniforms of the stages that follow; they must outlive them.
    void use(std::span<const uint32_t> values) { uniforms_ = values; }

    /// Adds what outputs of a stage need. Fails with what in it no function can say. `distance`: the
    /// value at the stage's point where it asks for the distance to its own surface.
    Result<std::vector<NodeValue>> add(const IrStage& stage, const std::vector<uint32_t>& outputs,
                                       const std::optional<NodeValue>& distance);

    NodeValue binary(const char* kind, const NodeValue& a, const NodeValue& b);
    /// A vector, which is only for outputs.
    NodeValue vector(const std::array<NodeValue, 3>& parts);
    /// `a` < `b` ? `c` : `d`.
    NodeValue select(const NodeValue& a, const NodeValue& b, const NodeValue& c,
                     const NodeValue& d);

    /// Writes the function, with outputs of these names.
    std::string text(int id, const std::string& name,
                     const std::vector<std::pair<std::string, NodeValue>>& outputs);
    /// What no function can say in what was added; empty if there is nothing.
    const std::string& fault() const { return fault_; }

  private:
    std::string ref(const NodeValue& value);
    NodeValue node(const char* kind, const std::vector<std::pair<const char*, NodeValue>>& inputs);
    NodeValue unary(const char* kind, const NodeValue& a);
    NodeValue coordinate(int32_t axis, bool scaled);
    NodeValue frame(int32_t index) const;
    NodeValue input(const IrLine& line);
    NodeValue line(uint32_t index);
    NodeValue choose(uint32_t condition, const NodeValue& yes, const NodeValue& no);
    NodeValue pick(const IrLine& line);
    NodeValue whole(ir::Type type, uint32_t bits);
    NodeValue if_equal(const IrLine& condition, const NodeValue& same, const NodeValue& other);
    const std::vector<bool>& all_undefined();
    bool may_be_undefined(uint32_t index);
    bool is_within(uint32_t index, double lo, double hi);
    NodeValue value(uint32_t index);
    void fail(const std::string& what);

    std::span<const uint32_t> uniforms_;
    StagePlace place_;
    const IrStage* stage_ = nullptr;
    std::optional<NodeValue> distance_;
    std::vector<NodeValue> values_;    ///< of the stage's lines that are needed
    std::vector<bool> undefined_;      ///< by line of the stage; empty: not asked for yet
    std::vector<ValueBounds> bounds_;  ///< likewise
    std::string nodes_, fault_;
    std::map<std::string, NodeValue> known_;  ///< by kind and inputs
    std::map<uint32_t, std::string> constants_;
    size_t count_ = 0;
};

}  // namespace openfab::tools
