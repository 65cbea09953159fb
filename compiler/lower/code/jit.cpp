// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/jit.h"

#include <fmt/format.h>

namespace openfab::lower {

namespace {

Fault load_fault(const KernelUnit& unit, const std::string& trouble) {
    return fault_of(
        fmt::format("{}: the object cannot be loaded: {}", unit.request.function, trouble));
}

bool is_kept(const KernelUnit& unit, KernelCache* cache) {
    return cache != nullptr && cache->find(unit.key) != nullptr;
}

}  // namespace

std::variant<LoadedKernel, Fault> load_kernel(const KernelUnit& unit, const KernelObject& object) {
    const std::string& function = unit.request.function;
    auto loaded = load_code(object.code, function + "_argv");
    if (const auto* trouble = std::get_if<std::string>(&loaded)) return load_fault(unit, *trouble);
    return std::get<LoadedKernel>(std::move(loaded));
}

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options) {
    std::unique_ptr<LoadedProgram> out(new LoadedProgram(options.cache));
    for (const FabletUnit& fablet : fablets)
        out->tables_.push_back(&out->data_.emplace_back(fablet).table());
    out->list_ = {static_cast<int32_t>(out->tables_.size()), out->tables_.data()};
    std::vector<KernelUnit> units;
    for (KernelUnit& unit : list_kernels(fablets, options)) {
        if (!options.bounds_later || !can_come_later(unit) || is_kept(unit, options.cache)) {
            units.push_back(std::move(unit));
            continue;
        }
        FabletData& data = out->data_[unit.fablet];
        auto function = out->later_.add(unit, data.kernel(unit.slot));
        if (const auto* trouble = std::get_if<std::string>(&function))
            return load_fault(unit, *trouble);
        data.set_function(unit.slot, unit.request.isa, std::get<openfab_kernel_fn>(function));
    }
    // Beside the others, which go first.
    out->later_.start();
    std::variant<MadeKernels, Fault> kernels = make_kernels(units, options);
    if (auto* fault = std::get_if<Fault>(&kernels)) return std::move(*fault);
    auto& made = std::get<MadeKernels>(kernels);
    out->times_ = std::move(made.times);
    for (size_t k = 0; k < units.size(); ++k) {
        auto loaded = load_kernel(units[k], *made.objects[k]);
        if (auto* fault = std::get_if<Fault>(&loaded)) return std::move(*fault);
        out->kernels_.push_back(std::get<LoadedKernel>(std::move(loaded)));
        FabletData& data = out->data_[units[k].fablet];
        data.set_function(units[k].slot, units[k].request.isa, out->kernels_[k].function);
        data.add_stored(made.objects[k]->stored_bytes);
    }
    return out;
}

}  // namespace openfab::lower
