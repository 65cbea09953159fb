// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls the kernel of a @Grow stage (openfab_shape in abi/fablet_table.h) on lists of nodes. One a thread.

#include <cstdint>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "abi/kernel_call.h"
#include "runtime/part/part.h"
#include "runtime/segments/driver.h"
#include "runtime/surface/kernel_args.h"

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

class RuleCalls final : segments::Arguments, segments::Handler {
  public:
    /// `stage`: the part of Part::shape, which must outlive it, as `fixed`, its arguments, must.
    RuleCalls(const part::Part& stage, const surface::StaticArgs& fixed, openfab_isa isa);

    /// Computes nodes of their parents. Both hold whole groups of lanes, of which `count` nodes count.
    abi::KernelStatus grow(const NodeColumns& parents, const NodePlaces& places, size_t count,
                           NodeColumns* out);
    /// Returns how many components a node has.
    size_t components() const { return components_; }

  private:
    void* data(const openfab_arg& arg);
    const void* input(const openfab_arg& arg) override;
    segments::OutputView output(const openfab_arg& arg) override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;
    void printf(const openfab_printf& call, std::span<const int32_t> groups,
                const segments::States& states) override;
    size_t column(const openfab_arg& arg) const {
        return first_component_[static_cast<size_t>(arg.a)] + static_cast<size_t>(arg.b);
    }

    const openfab_shape& shape_;
    const surface::StaticArgs& fixed_;
    openfab_isa isa_;
    std::vector<size_t> first_component_;
    size_t components_ = 0;
    segments::Driver driver_;
    std::vector<uint8_t> wanted_;
    std::vector<std::unique_ptr<abi::KernelBuffer>> buffers_;
    size_t buffers_used_ = 0;
    std::vector<uint32_t> packed_;
    // Of the current call.
    const NodeColumns* parents_ = nullptr;
    const NodePlaces* places_ = nullptr;
    NodeColumns* out_ = nullptr;
    size_t first_ = 0;
    int32_t count_ = 0;
};

/// Returns `n` rounded up to whole groups of lanes.
inline size_t whole_lanes(size_t n) {
    constexpr auto kLanes = static_cast<size_t>(segments::kLanes);
    return (n + kLanes - 1) / kLanes * kLanes;
}

inline void NodeColumns::assign(size_t components, size_t nodes) {
    lanes = whole_lanes(nodes);
    bits.assign(components * lanes, 0);
}

}  // namespace openfab::solid
