// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "python/src/program.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "abi/kernel_call.h"
#include "compiler/diag/render.h"
#include "compiler/driver/compilation.h"
#include "compiler/driver/interface.h"
#include "compiler/frontend/frontend.h"
#include "compiler/lower/code/compile.h"
#include "compiler/lower/code/kernel_cache.h"
#include "program/options.h"
#include "program/print_main.h"

namespace openfab::python {

namespace {

/// One for all, so that kernels stay in memory from one program to the next.
lower::KernelCache& kernel_cache() {
    static lower::KernelCache* const cache = [] {
        const Result<std::filesystem::path> folder = lower::KernelCache::own_folder();
        // Never destroyed: a print may run while the process ends.
        return new lower::KernelCache(folder ? *folder : std::filesystem::path());
    }();
    return *cache;
}

Diagnostics render(int code, const diag::Sink& sink, const source::SourceManager& sources) {
    Diagnostics out;
    out.code = code;
    if (sink.errors() + sink.warnings() > 0) {
        out.rendered = diag::render_text(sink, sources);
        out.json = diag::render_json(sink, sources);
    }
    return out;
}

Interface interface_of(source::SourceManager* sources, uint32_t file, bool need_fablet) {
    diag::Sink sink;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(*sources, file, sink, {.need_fablet = need_fablet});
    Interface out;
    out.diagnostics = render(module ? 0 : driver::kExitUserInput, sink, *sources);
    if (module) out.json = driver::describe(*module);
    out.files = sources->files();
    return out;
}

}  // namespace

Interface read_interface(const std::filesystem::path& file) {
    source::SourceManager sources;
    std::string fault;
    const std::optional<uint32_t> number = sources.load(file, &fault);
    if (number) return interface_of(&sources, *number, false);
    Interface out;
    out.diagnostics.code = driver::unread_exit_code(file);
    out.diagnostics.fault = fault;
    return out;
}

Interface read_interface(const std::string& name, std::string text) {
    source::SourceManager sources;
    if (text.size() <= source::SourceManager::kMaxFileBytes)
        return interface_of(&sources, sources.add(name, std::move(text)), true);
    Interface out;
    out.diagnostics.code = driver::kExitUserInput;
    out.diagnostics.fault = name + ": the text is larger than 16 MB";
    return out;
}

int Program::compiled() const {
    const auto& times = loaded_->times();
    return static_cast<int>(std::count_if(times.begin(), times.end(),
                                          [](const auto& kernel) { return kernel.compiled; }));
}

std::span<const int32_t> Program::directions(const openfab_fablet& fablet) const {
    const openfab_fablet_list& list = fablets();
    const auto* const* found = std::find(list.fablets, list.fablets + list.count, &fablet);
    const auto index = static_cast<size_t>(found - list.fablets);
    return index < directions_.size() ? std::span<const int32_t>(directions_[index])
                                      : std::span<const int32_t>();
}

int Program::main(const std::vector<std::string>& words) const {
    std::vector<char*> argv;
    std::vector<std::string> own = words;
    for (std::string& word : own)
        argv.push_back(word.data());
    return program::print_main(static_cast<int>(argv.size()), argv.data(), fablets());
}

std::variant<std::shared_ptr<const Program>, Diagnostics> compile(
    const std::vector<std::string>& files, bool enable_printf,
    const std::optional<frontend::DitherRule>& rule, const std::vector<std::string>& derivatives,
    Diagnostics* warnings) {
    driver::CompilationOptions options;
    options.files = files;
    options.dither = rule;
    options.derivatives = derivatives;
    options.target = abi::isa_name(abi::best_isa(program::kUsualIsa));
    options.enable_printf = enable_printf;
    const driver::CommonOptions common;
    driver::Compilation compilation(options, common);
    const driver::Compilation::Outcome outcome = compilation.run();
    Diagnostics said = render(outcome.code, outcome.sink, compilation.sources());
    said.fault = outcome.fault;
    if (said.code != 0) return said;
    auto loaded =
        lower::load_program(compilation.fablets(), compilation.program_options(&kernel_cache()));
    if (const auto* fault = std::get_if<lower::Fault>(&loaded)) {
        said.code = fault->is_outside ? driver::kExitOutside : driver::kExitBug;
        said.fault = fault->schedule ? fault->schedule->message : fault->trouble;
        return said;
    }
    kernel_cache().trim();
    std::shared_ptr<Program> program(new Program());
    program->loaded_ = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
    for (const lower::FabletUnit& unit : compilation.fablets())
        program->directions_.push_back(unit.directions);
    program->files_ = compilation.sources().files();
    *warnings = std::move(said);
    return std::shared_ptr<const Program>(std::move(program));
}

}  // namespace openfab::python
