// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/frontend.h"

#include "compiler/check/check.h"
#include "compiler/driver/modules.h"
#include "compiler/translate/translate.h"

namespace openfab::driver {

namespace {

void locate_prints(const source::SourceManager& sources, ir::Stage* stage) {
    for (ir::Print& print : stage->prints) {
        const source::Location at = sources.locate(print.span.file, print.span.begin);
        print.source = std::filesystem::path(sources.name(print.span.file)).filename().string();
        print.line = static_cast<int32_t>(at.line);
        print.column = static_cast<int32_t>(at.column);
    }
}

}  // namespace

std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault, const FrontEndOptions& options) {
    const std::optional<uint32_t> file = sources.load(path, fault);
    if (!file) return std::nullopt;
    return compile_to_ir(sources, *file, sink, options);
}

std::optional<ir::Module> compile_to_ir(source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink, const FrontEndOptions& options) {
    // What was there before, of other files of the same command, does not count.
    const size_t errors = sink.errors();
    Modules modules(&sources, &sink);
    const std::vector<sema::Unit>& units = modules.load(file);
    if (sink.errors() != errors) return std::nullopt;
    const sema::Program program = sema::check(units, {options.need_fablet}, &sink);
    if (sink.errors() != errors) return std::nullopt;
    ir::Module module = sema::translate(program, {options.prints}, &sink);
    if (sink.errors() != errors) return std::nullopt;
    for (ir::Fablet& fablet : module.fablets) {
        locate_prints(sources, &fablet.surface);
        locate_prints(sources, &fablet.volume);
    }
    return module;
}

}  // namespace openfab::driver
