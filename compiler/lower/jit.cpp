// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/jit.h"

#include <fmt/format.h>

namespace openfab::lower {

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options) {
    const std::vector<KernelUnit> units = list_kernels(fablets, options);
    std::variant<MadeKernels, Fault> kernels = make_kernels(units, options);
    if (auto* fault = std::get_if<Fault>(&kernels)) return std::move(*fault);
    auto& made = std::get<MadeKernels>(kernels);
    std::unique_ptr<LoadedProgram> out(new LoadedProgram);
    out->times_ = std::move(made.times);
    for (size_t k = 0; k < units.size(); ++k) {
        const std::string& function = units[k].request.function;
        auto loaded = load_code(made.objects[k]->code, function + "_argv");
        if (const auto* trouble = std::get_if<std::string>(&loaded)) {
            Fault fault;
            fault.internal = fmt::format("{}: the object cannot be loaded: {}", function, *trouble);
            return fault;
        }
        out->kernels_.push_back(std::get<LoadedKernel>(std::move(loaded)));
    }
    for (const FabletUnit& fablet : fablets)
        out->tables_.push_back(&out->data_.emplace_back(fablet).table());
    for (size_t k = 0; k < units.size(); ++k) {
        out->data_[units[k].fablet].set_function(units[k].slot, units[k].request.isa,
                                                 out->kernels_[k].function);
    }
    out->list_ = {static_cast<int32_t>(out->tables_.size()), out->tables_.data()};
    return out;
}

}  // namespace openfab::lower
