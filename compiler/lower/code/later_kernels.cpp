// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/later_kernels.h"

#include <HalideRuntime.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <utility>

#include "base/check.h"
#include "compiler/lower/code/jit.h"

namespace openfab::lower {

namespace {

constexpr int kNiceness = 10;

bool is_bound(openfab_arg_kind kind) {
    return kind == OPENFAB_ARG_WEIGHT_LO || kind == OPENFAB_ARG_WEIGHT_HI;
}

}  // namespace

bool can_come_later(const KernelUnit& unit) {
    // A schedule of the user's may be wrong, which must be said before the print; and what it stores
    // is part of the print's plan. The built-in one stores a few groups.
    return unit.request.stage->kind == ir::StageKind::kVolumeBounds &&
           unit.request.schedule == nullptr;
}

LaterKernels::~LaterKernels() {
    give_up();
    if (thread_.joinable()) thread_.join();
}

std::variant<openfab_kernel_fn, std::string> LaterKernels::add(const KernelUnit& unit,
                                                               const openfab_kernel& entry) {
    Kernel& kernel = kernels_.emplace_back();
    kernel.stage = *unit.request.stage;
    kernel.unit = unit;
    kernel.unit.request.stage = kernel.unit.slot.stage = &kernel.stage;
    kernel.entry = &entry;
    auto caller = bind_code(call, &kernel);
    if (auto* trouble = std::get_if<std::string>(&caller)) return std::move(*trouble);
    kernel.caller = std::get<LoadedKernel>(std::move(caller));
    return kernel.caller.function;
}

void LaterKernels::start() {
    if (kernels_.empty()) return;
    done_ = false;
    thread_ = std::thread([this] { run(); });
}

std::variant<std::vector<KernelTime>, Fault> LaterKernels::finish() {
    if (thread_.joinable()) thread_.join();
    if (fault_) return *fault_;
    return times_;
}

void LaterKernels::run() {
    // Of this thread alone. The print goes first.
    (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNiceness);
    static std::mutex one_at_a_time;
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    for (Kernel& kernel : kernels_) {
        if (given_up_ || fault_) break;
        fault_ = make(&kernel);
    }
    done_ = true;
}

std::optional<Fault> LaterKernels::make(Kernel* kernel) {
    ProgramOptions options;
    options.threads = 1;
    options.cache = cache_;
    auto kernels = make_kernels({kernel->unit}, options);
    if (auto* fault = std::get_if<Fault>(&kernels)) return std::move(*fault);
    const auto& made = std::get<MadeKernels>(kernels);
    auto loaded = load_kernel(kernel->unit, *made.objects[0]);
    if (auto* fault = std::get_if<Fault>(&loaded)) return std::move(*fault);
    kernel->loaded = std::get<LoadedKernel>(std::move(loaded));
    kernel->function.store(kernel->loaded.function, std::memory_order_release);
    times_.insert(times_.end(), made.times.begin(), made.times.end());
    return std::nullopt;
}

int LaterKernels::call(void** args, void* self) {
    const auto& kernel = *static_cast<const Kernel*>(self);
    if (const openfab_kernel_fn function = kernel.function.load(std::memory_order_acquire))
        return function(args);
    for (int32_t k = 0; k < kernel.entry->arg_count; ++k) {
        if (!is_bound(kernel.entry->args[k].kind)) continue;
        const auto& buffer = *static_cast<const halide_buffer_t*>(args[k]);
        int32_t count = 1;
        for (int32_t d = 0; d < buffer.dimensions; ++d) {
            OPENFAB_CHECK_EQ(buffer.dim[d].stride, count);
            count *= buffer.dim[d].extent;
        }
        std::fill_n(reinterpret_cast<float*>(buffer.host), count,
                    std::numeric_limits<float>::quiet_NaN());
        if (kernel.entry->packed != 0) break;  // all outputs are this one argument
    }
    return 0;
}

}  // namespace openfab::lower
