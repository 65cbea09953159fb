// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The constant table of one fablet in memory, as abi/fablet_table.h lays it out. It is used in
// memory (compiler/lower/code/jit.h) or written as C source (compiler/lower/code/table.h).

#include <algorithm>
#include <array>
#include <deque>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "compiler/ir/ir.h"
#include "compiler/lower/algorithm/args.h"
#include "compiler/passes/pipeline.h"

namespace openfab::lower {

/// One fablet of a program.
struct FabletUnit {
    const ir::Fablet* fablet = nullptr;
    const passes::KernelStages* stages = nullptr;
    std::string source_name;  ///< file name of the source, for messages
    uint64_t hash = 0;
    /// Of a volume with derivatives: the directions, float uniforms by their indices among the values. Amounts are in
    /// states then, and behind them, of direction k in state 1 + slot_count * (1 + k) + s, the derivative of slot s.
    std::vector<int32_t> directions{};
};

/// A kernel of a fablet, and its slot in the table.
struct KernelSlot {
    const ir::Stage* stage = nullptr;
    SlabStages inside;                                 ///< of the slab kernel
    openfab_kernel openfab_fablet::*kernel = nullptr;  ///< null for the kernel of a segment
    openfab_segments openfab_fablet::*segments = nullptr;
    size_t segment = 0;  ///< index among the kernels of `segments`
    std::string name;    ///< in C names: "slab", "volume_segment3"
    /// Likewise, of a shape.
    openfab_kernel openfab_shape::*shape_kernel = nullptr;
    openfab_segments openfab_shape::*shape_segments = nullptr;
};

/// Returns what the slab kernel of a fablet has inside.
SlabStages stages_inside_slab(const passes::KernelStages& stages);

/// Returns the kernels of a fablet, in the order of the table.
std::vector<KernelSlot> kernel_slots(const passes::KernelStages& stages);

/// Owns everything that the table points to; the unit may be destroyed.
class FabletData {
  public:
    explicit FabletData(const FabletUnit& unit);
    FabletData(const FabletData&) = delete;
    FabletData& operator=(const FabletData&) = delete;

    /// Returns the table, valid while this object lives.
    const openfab_fablet& table() const { return table_; }
    const openfab_kernel& kernel(const KernelSlot& slot) const {
        if (slot.shape_kernel != nullptr) return shape_.*slot.shape_kernel;
        if (slot.kernel != nullptr) return table_.*slot.kernel;
        const openfab_segments& segments =
            slot.shape_segments != nullptr ? shape_.*slot.shape_segments : table_.*slot.segments;
        return segments.kernels[slot.segment];
    }
    void set_function(const KernelSlot& slot, openfab_isa isa, openfab_kernel_fn function) {
        const_cast<openfab_kernel&>(kernel(slot)).fn[isa] = function;
    }
    /// Takes note of what one of its kernels stores.
    void add_stored(int64_t bytes) { table_.stored_bytes = std::max(table_.stored_bytes, bytes); }

  private:
    const char* keep(const std::string& text) { return strings_.emplace_back(text).c_str(); }
    const double* keep_limits(const ir::Uniform& uniform);
    const uint32_t* keep_bits(const std::vector<uint32_t>& bits);
    const openfab_varying* keep_varyings(const std::vector<ir::Varying>& varyings);
    openfab_kernel make_kernel_entry(const ir::Stage& stage, const SlabStages& inside = {});
    openfab_segments make_segments(const passes::SegmentedStage& segmented);
    void make_shape(const ir::Fablet& fablet, const passes::KernelStages& stages);

    openfab_fablet table_{};
    openfab_shape shape_{};
    std::deque<std::string> strings_;
    std::deque<std::vector<uint32_t>> bits_;
    std::deque<std::array<double, 2>> limits_;
    std::vector<openfab_uniform> uniforms_;
    std::vector<openfab_table_value> table_values_;
    std::deque<std::vector<openfab_varying>> varyings_;
    std::deque<std::vector<openfab_arg>> args_;
    std::deque<std::vector<openfab_kernel>> kernels_;
    std::deque<std::vector<openfab_step>> steps_;
    std::deque<std::vector<openfab_query>> queries_;
    std::deque<std::vector<openfab_query_output>> query_outputs_;
    std::deque<std::vector<openfab_printf>> printfs_;
    std::deque<std::vector<int32_t>> values_;
    std::deque<std::vector<openfab_scalar_type>> states_;
    std::deque<std::vector<openfab_elements>> elements_;
};

}  // namespace openfab::lower
