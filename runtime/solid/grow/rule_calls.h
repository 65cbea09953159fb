// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls the kernel of a @Grow stage (openfab_shape in abi/fablet_table.h) on lists of nodes. One a thread.

#include <cstdint>
#include <vector>

#include "abi/fablet_table.h"
#include "runtime/part/part.h"
#include "runtime/solid/stage_calls.h"

namespace openfab::solid {

/// Nodes by component of the struct's members, bits.
struct NodeColumns {
    std::vector<uint32_t> bits;  ///< [component][lane]
    size_t lanes = 0;

    /// Makes room for nodes in whole groups of lanes, all 0.
    void assign(size_t components, size_t nodes);
    uint32_t* column(size_t component) { return bits.data() + component * lanes; }
    const uint32_t* column(size_t component) const { return bits.data() + component * lanes; }
};

/// Where nodes stand: their numbers among their parents' children, levels and paths.
struct NodePlaces {
    std::vector<int32_t> child, level;
    std::vector<uint32_t> path;
};

class RuleCalls final : public StageCalls {
  public:
    /// `stage`: the part of Part::shape, which must outlive it, as `fixed`, its arguments, must.
    RuleCalls(const part::Part& stage, const surface::StaticArgs& fixed, openfab_isa isa);

    /// Computes nodes of their parents. Both hold whole groups of lanes, of which `count` nodes count.
    abi::KernelStatus grow(const NodeColumns& parents, const NodePlaces& places, size_t count,
                           NodeColumns* out);

  private:
    void* data(const openfab_arg& arg) override;
    size_t column(const openfab_arg& arg) const {
        return first_component(arg.a) + static_cast<size_t>(arg.b);
    }

    // Of the current call.
    const NodeColumns* parents_ = nullptr;
    const NodePlaces* places_ = nullptr;
    NodeColumns* out_ = nullptr;
};

inline void NodeColumns::assign(size_t components, size_t nodes) {
    lanes = whole_lanes(nodes);
    bits.assign(components * lanes, 0);
}

}  // namespace openfab::solid
