// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/jit.h"

namespace openfab::lower {

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options) {
    const std::vector<KernelUnit> units = list_kernels(fablets, options.isas);
    std::unique_ptr<LoadedProgram> out(new LoadedProgram);
    out->kernels_.resize(units.size());
    std::optional<Fault> fault =
        compile_each(units, options.threads, [&](size_t k) -> std::optional<Fault> {
            auto made = compile_in_memory(request_of(units[k], options));
            if (auto* trouble = std::get_if<Fault>(&made)) return std::move(*trouble);
            out->kernels_[k] = std::get<LoadedKernel>(std::move(made));
            return std::nullopt;
        });
    if (fault) return *fault;
    for (const FabletUnit& fablet : fablets)
        out->tables_.push_back(&out->data_.emplace_back(fablet).table());
    for (size_t k = 0; k < units.size(); ++k) {
        out->data_[units[k].fablet].set_function(units[k].slot, units[k].isa,
                                                 out->kernels_[k].function);
    }
    out->list_ = {static_cast<int32_t>(out->tables_.size()), out->tables_.data()};
    return out;
}

}  // namespace openfab::lower
