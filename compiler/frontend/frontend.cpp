// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/frontend/frontend.h"

#include "compiler/check/check.h"
#include "compiler/frontend/modules.h"
#include "compiler/translate/translate.h"

namespace openfab::frontend {

namespace {

void locate_printfs(const source::SourceManager& sources, ir::Stage* stage) {
    for (ir::Printf& call : stage->printfs) {
        const source::Location at = sources.locate(call.span.file, call.span.begin);
        call.source = std::filesystem::path(sources.name(call.span.file)).filename().string();
        call.line = static_cast<int32_t>(at.line);
        call.column = static_cast<int32_t>(at.column);
    }
}

}  // namespace

std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault, const FrontEndOptions& options) {
    const std::optional<uint32_t> file = sources.load(path, fault);
    if (!file) return std::nullopt;
    return compile_to_ir(sources, *file, sink, options, fault);
}

std::optional<ir::Module> compile_to_ir(source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink, const FrontEndOptions& options,
                                        std::string* fault) {
    // Errors in other files of the same command do not count.
    const size_t errors = sink.errors();
    Modules modules(&sources, &sink);
    check::CheckOptions checks{options.need_fablet};
    if (options.dither != nullptr) {
        const std::optional<size_t> unit = modules.load_module(options.dither->source, fault);
        if (!unit) return std::nullopt;
        checks.rule = {*unit, options.dither->name};
    }
    const std::vector<check::Unit>& units = modules.load(file);
    if (sink.errors() != errors) return std::nullopt;
    const check::Program program = check::check(units, checks, &sink);
    if (sink.errors() != errors) return std::nullopt;
    ir::Module module = translate::translate(program, {options.enable_printf}, &sink);
    if (sink.errors() != errors) return std::nullopt;
    for (ir::Fablet& fablet : module.fablets) {
        locate_printfs(sources, &fablet.surface);
        locate_printfs(sources, &fablet.volume);
    }
    return module;
}

}  // namespace openfab::frontend
