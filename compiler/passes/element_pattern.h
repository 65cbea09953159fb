// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds what values for the elements of an array have in common: the same operations on the same
// values, but for constants and states that grow from element to element by a step.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// What one value is for each element, by its number.
struct ElementNode {
    enum class Kind : uint8_t {
        kCommon,     ///< `id`, whatever the number
        kNumber,     ///< first + step * number, of an integer type
        kState,      ///< the input of state first + step * number; step is at least 1
        kIs,         ///< whether an index, argument 0, is first + number: see `below` and `above`
        kOperation,  ///< as `id`, of the arguments
    };
    Kind kind = Kind::kCommon;
    ir::ValueId id = ir::kNoValue;  ///< of element 0
    uint32_t first = 0, step = 0;
    bool below = false;  ///< kIs: an index below the first is the first
    bool above = false;  ///< an index above the last is the last
    std::vector<size_t> args;
};

/// Of fewer elements one is chosen after the other.
constexpr size_t kFewestElements = 16;

class ElementPattern {
  public:
    /// `stage`, of a kernel of segments, must outlive it.
    explicit ElementPattern(const ir::Stage& stage) : stage_(stage) {}

    /// Finds the pattern of at least two values, that of element 0 first. Returns false if there is
    /// none.
    bool find(std::span<const ir::ValueId> elements);

    const ir::Stage& stage() const { return stage_; }
    size_t count() const { return count_; }
    size_t root() const { return root_; }
    const ElementNode& node(size_t k) const { return nodes_[k]; }

    /// Emits the value of the element `number`, an int of 0 to count() - 1. `renamed`: what values of
    /// the stage are to the builder.
    ir::ValueId emit(ir::ValueId number, const std::vector<ir::ValueId>& renamed,
                     ir::Builder* builder) const;

  private:
    using Values = std::vector<ir::ValueId>;

    std::optional<size_t> unify(const Values& values);
    std::optional<ElementNode> make(const Values& values);
    std::optional<ElementNode> of_constants(const Values& values) const;
    std::optional<ElementNode> of_inputs(const Values& values) const;
    std::optional<ElementNode> of_test(const Values& values);
    std::optional<size_t> unify_argument(const Values& values, size_t k);
    ir::ValueId emit(size_t k, ir::ValueId number, const std::vector<ir::ValueId>& renamed,
                     std::vector<ir::ValueId>* made, ir::Builder* builder) const;

    const ir::Instr& at(ir::ValueId id) const { return stage_.instrs[id]; }

    const ir::Stage& stage_;
    size_t count_ = 0;
    size_t root_ = 0;
    std::vector<ElementNode> nodes_;
    std::map<Values, std::optional<size_t>> known_;
};

/// Returns how many of the first values have a pattern that `fits`, of which there is at least
/// `fewest`; else 0. `pattern` is then that of those.
template <typename Fits>
size_t longest_run(ElementPattern* pattern, std::span<const ir::ValueId> values, size_t fewest,
                   const Fits& fits) {
    const auto works = [&](size_t count) {
        return pattern->find(values.first(count)) && fits(*pattern);
    };
    if (values.size() < fewest || !works(fewest)) return 0;
    if (values.size() == fewest || works(values.size())) return values.size();
    size_t most = fewest, too_many = values.size();
    while (too_many - most > 1) {
        const size_t middle = most + (too_many - most) / 2;
        (works(middle) ? most : too_many) = middle;
    }
    works(most);
    return most;
}

/// Emits `value` kept within first and last, which are bits of its type, an integer one; a side that
/// is not `clamped` is left as it is.
ir::ValueId emit_clamped(ir::ValueId value, uint32_t first, uint32_t last, bool below, bool above,
                         ir::Builder* builder);

/// A Table of states, which only these passes know: a = state of element 0, b = states from one to the
/// next, bits = how many; args {number, an int}.
bool is_element_load(const ir::Instr& instr);

}  // namespace openfab::passes
