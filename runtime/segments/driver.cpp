// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/segments/driver.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "base/grow.h"

namespace openfab::segments {

namespace {

// The part of an L2 cache of 512 KiB to 2 MiB that the stage's own buffers leave.
constexpr size_t kStateBytes = 256u << 10;
constexpr size_t kGroupBytes = kLanes * sizeof(uint32_t);

bool is_output(openfab_arg_kind kind) {
    return kind == OPENFAB_ARG_STATE_OUT || kind == OPENFAB_ARG_POSITION ||
           kind == OPENFAB_ARG_SURFACE_OUT || kind == OPENFAB_ARG_SURFACE_STATUS ||
           kind == OPENFAB_ARG_SHAPE_VALUE || kind == OPENFAB_ARG_SHAPE_OUT;
}

}  // namespace

int32_t group_limit(const openfab_segments& segments) {
    const size_t one = static_cast<size_t>(std::max(segments.state_count, 1)) * kGroupBytes;
    const size_t blocks = kStateBytes / (one * kBlockGroups);
    return static_cast<int32_t>(std::clamp<size_t>(blocks, 1, 64)) * kBlockGroups;
}

void Driver::bind_kernel(const openfab_kernel& kernel, openfab_isa isa, Arguments* arguments,
                         Kernel* out) {
    const auto count = static_cast<size_t>(kernel.arg_count);
    out->fn = abi::function_for(kernel.fn, isa);
    out->args.resize(count);
    if (out->buffer_count < count) {
        out->buffers = std::make_unique<abi::KernelBuffer[]>(count);
        out->buffer_count = count;
    }
    out->outputs.clear();
    out->first_output = count;
    const int32_t lane_count = groups_ * kLanes;
    for (size_t i = 0; i < count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        abi::KernelBuffer& buffer = out->buffers[i];
        if (is_output(arg.kind)) {
            out->first_output = std::min(out->first_output, i);
            Output output;
            output.compact =
                compact_.data() + out->outputs.size() * static_cast<size_t>(lane_count);
            output.direct = true;
            if (arg.kind == OPENFAB_ARG_STATE_OUT) {
                output.view.data = states_[arg.a];
                for (size_t k = 0; k < i; ++k) {
                    const openfab_arg& read = kernel.args[k];
                    if (read.kind == OPENFAB_ARG_STATE && read.a == arg.a) output.direct = false;
                }
            } else {
                output.view = arguments->output(arg);
                output.direct = output.view.block_stride == kBlockGroups * kLanes;
            }
            if (kernel.packed != 0) output.direct = false;
            out->outputs.push_back(output);
            if (kernel.packed != 0 && i > out->first_output) continue;
            out->args[i] = buffer.raw();
        } else if (arg.kind == OPENFAB_ARG_GROUPS) {
            out->args[i] = buffer.raw();
        } else if (arg.kind == OPENFAB_ARG_STATE) {
            buffer.set_dense(abi::halide_type(arg.scalar), states_[arg.a], {lane_count});
            out->args[i] = buffer.raw();
        } else {
            out->args[i] = const_cast<void*>(arguments->input(arg));
        }
    }
}

void Driver::bind(const openfab_segments& segments, openfab_isa isa, Arguments* arguments) {
    const auto lane_count = static_cast<size_t>(groups_) * kLanes;
    grow(&memory_, static_cast<size_t>(segments.state_count) * lane_count);
    states_ = States(memory_.data(), lane_count);
    size_t outputs = 0;
    for (int32_t k = 0; k < segments.kernel_count; ++k) {
        const openfab_kernel& kernel = segments.kernels[k];
        const auto count = std::count_if(kernel.args, kernel.args + kernel.arg_count,
                                         [](const openfab_arg& a) { return is_output(a.kind); });
        outputs = std::max(outputs, static_cast<size_t>(count));
    }
    grow(&compact_, outputs * lane_count);
    grow(&kernels_, static_cast<size_t>(segments.kernel_count));
    for (int32_t k = 0; k < segments.kernel_count; ++k)
        bind_kernel(segments.kernels[k], isa, arguments, &kernels_[k]);
}

abi::KernelStatus Driver::run_kernel(const openfab_kernel& kernel, Kernel* bound) {
    const std::vector<int32_t>& list = lists_[depth_];
    const auto listed = static_cast<int32_t>(list.size());
    const bool all = listed == groups_;
    for (size_t i = 0; i < bound->args.size(); ++i) {
        const openfab_arg& arg = kernel.args[i];
        abi::KernelBuffer& buffer = bound->buffers[i];
        if (arg.kind == OPENFAB_ARG_GROUPS) {
            buffer.set_dense(abi::halide_type(OPENFAB_INT), list.data(), {listed});
        } else if (kernel.packed != 0 && i >= bound->first_output) {
            const auto apart = groups_ * kLanes;
            buffer.set_dim(0, kLanes, 1);
            buffer.set_dim(1, static_cast<int32_t>(bound->outputs.size()), apart);
            buffer.set_dim(2, listed, kLanes);
            buffer.set(abi::halide_type(OPENFAB_UINT), bound->outputs[0].compact, 3);
            break;
        } else if (i >= bound->first_output) {
            const Output& output = bound->outputs[i - bound->first_output];
            const uint32_t* to = all && output.direct ? output.view.data : output.compact;
            buffer.set_dense(abi::halide_type(arg.scalar), to, {kLanes, listed});
        }
    }
    const abi::KernelStatus status = abi::KernelStatus::of_code(bound->fn(bound->args.data()));
    if (!status.ok()) return status;
    for (const Output& output : bound->outputs) {
        if (all && output.direct) continue;
        const uint32_t* from = output.compact;
        for (const int32_t group : list) {
            uint32_t* to = output.view.data + (group / kBlockGroups) * output.view.block_stride +
                           (group % kBlockGroups) * kLanes;
            std::memcpy(to, from, kGroupBytes);
            from += kLanes;
        }
    }
    return {};
}

void Driver::move(const openfab_elements& elements) const {
    constexpr int32_t kNone = -1;
    const std::vector<int32_t>& list = lists_[depth_];
    const uint32_t* guard = elements.guard == kNone ? nullptr : states_[elements.guard];
    const bool picks =
        elements.kind == OPENFAB_ELEMENTS_LOAD || elements.kind == OPENFAB_ELEMENTS_STORE;
    if (picks) {
        uint32_t* const first = states_[elements.first];
        const ptrdiff_t apart = states_[elements.first + elements.apart] - first;
        uint32_t* const value = states_[elements.value];
        const uint32_t* const index = states_[elements.index];
        const bool loads = elements.kind == OPENFAB_ELEMENTS_LOAD;
        for (const int32_t group : list) {
            const ptrdiff_t begin = static_cast<ptrdiff_t>(group) * kLanes;
            for (ptrdiff_t i = begin; i < begin + kLanes; ++i) {
                if (guard != nullptr && guard[i] == 0) continue;
                // Where a lane is not active its index may be anything.
                const auto k = std::clamp(static_cast<int32_t>(index[i]), 0, elements.count - 1);
                uint32_t& element = first[k * apart + i];
                (loads ? value[i] : element) = loads ? element : value[i];
            }
        }
        return;
    }
    for (int32_t k = 0; k < elements.count; ++k) {
        uint32_t* const to = states_[elements.first + k * elements.apart];
        const uint32_t* const from = states_[elements.value + k * elements.value_apart];
        for (const int32_t group : list) {
            const ptrdiff_t begin = static_cast<ptrdiff_t>(group) * kLanes;
            for (ptrdiff_t i = begin; i < begin + kLanes; ++i)
                to[i] = guard == nullptr || guard[i] != 0 ? from[i] : to[i];
        }
    }
}

void Driver::narrow(const std::vector<int32_t>& from, int32_t active,
                    std::vector<int32_t>* to) const {
    const uint32_t* values = states_[active];
    // `to` may equal `from`: writes never overtake reads.
    if (to->size() < from.size()) to->resize(from.size());
    size_t kept = 0;
    for (const int32_t group : from) {
        const uint32_t* lanes = values + static_cast<ptrdiff_t>(group) * kLanes;
        uint32_t any = 0;
        for (int32_t l = 0; l < kLanes; ++l)
            any |= lanes[l];
        (*to)[kept] = group;
        kept += any != 0 ? 1 : 0;
    }
    to->resize(kept);
}

abi::KernelStatus Driver::run(const openfab_segments& segments, openfab_isa isa,
                              std::span<const uint8_t> wanted, Arguments* arguments,
                              Handler* handler, const std::atomic<bool>* stop) {
    groups_ = static_cast<int32_t>(wanted.size());
    bind(segments, isa, arguments);
    depth_ = 0;
    grow(&lists_, 1);
    lists_[0].clear();
    for (int32_t g = 0; g < groups_; ++g) {
        uint32_t* live = states_[0] + static_cast<ptrdiff_t>(g) * kLanes;
        for (int32_t l = 0; l < kLanes; ++l)
            live[l] = wanted[g] >> l & 1u;
        if (wanted[g] != 0) lists_[0].push_back(g);
    }
    if (lists_[0].empty()) return {};
    for (int32_t at = 0; at < segments.step_count;) {
        const openfab_step& step = segments.steps[at++];
        if (stop != nullptr && stop->load(std::memory_order_relaxed))
            return abi::KernelStatus::stopped();
        abi::KernelStatus status;
        switch (step.kind) {
            case OPENFAB_STEP_KERNEL:
                status = run_kernel(segments.kernels[step.a], &kernels_[step.a]);
                break;
            case OPENFAB_STEP_LOOP:
                grow(&lists_, depth_ + 2);
                narrow(lists_[depth_], step.a, &lists_[depth_ + 1]);
                if (lists_[depth_ + 1].empty()) {
                    at = step.b;
                } else {
                    ++depth_;
                }
                break;
            case OPENFAB_STEP_LOOP_END:
                OPENFAB_CHECK_GT(depth_, 0u);
                narrow(lists_[depth_], step.a, &lists_[depth_]);
                if (lists_[depth_].empty()) {
                    --depth_;
                } else {
                    at = step.b;
                }
                break;
            case OPENFAB_STEP_QUERY:
                status = handler->query(segments.queries[step.a], lists_[depth_], states_);
                break;
            case OPENFAB_STEP_PRINTF:
                handler->printf(segments.printfs[step.a], lists_[depth_], states_);
                break;
            case OPENFAB_STEP_ELEMENTS:
                move(segments.elements[step.a]);
                break;
        }
        if (!status.ok()) return status;
    }
    OPENFAB_CHECK_EQ(depth_, 0u);  // all loops have ended
    return {};
}

}  // namespace openfab::segments
