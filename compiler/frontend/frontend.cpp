// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/frontend/frontend.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <set>
#include <string_view>

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

/// The names in what could not be parsed, which may be declared there.
std::set<std::string, std::less<>> names_in(const source::SourceManager& sources,
                                            const std::vector<source::Span>& damaged) {
    std::set<std::string, std::less<>> out;
    for (const source::Span& span : damaged) {
        const std::string_view text = sources.text(span);
        const auto is_word = [](char c) {
            return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
        };
        for (size_t at = 0; at < text.size();) {
            size_t end = at;
            while (end < text.size() && is_word(text[end]))
                ++end;
            if (end > at) out.emplace(text.substr(at, end - at));
            at = end + 1;
        }
    }
    return out;
}

/// Adds to the errors of the parser those of the checker that do not follow from them: none that lies in text which was
/// not understood, is about a name that stands there, or about what may stand there.
void report_beside(const source::SourceManager& sources, const std::vector<check::Unit>& units,
                   check::CheckOptions options, diag::Sink* sink) {
    const std::vector<source::Span>& damaged = units.back().file->damaged;
    const std::set<std::string, std::less<>> names = names_in(sources, damaged);
    diag::Sink found;
    options.need_fablet = false;
    check::check(units, options, &found);
    for (diag::Diagnostic& d : found.sorted()) {
        const bool may_be_there = d.id == diag::Id::kMissingStage || d.id == diag::Id::kNoFablet ||
                                  d.id == diag::Id::kRecursion;
        const bool inside =
            std::any_of(damaged.begin(), damaged.end(), [&](const source::Span& span) {
                return span.file == d.span.file && span.begin < d.span.end &&
                       d.span.begin < span.end;
            });
        const bool named = names.count(sources.text(d.span)) != 0;
        if (d.severity == diag::Severity::kError && !may_be_there && !inside && !named)
            sink->take(std::move(d));
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
    check::CheckOptions checks{options.need_fablet, nullptr, library_module_of, {}};
    if (options.dither != nullptr) {
        const std::optional<size_t> unit = modules.load_module(options.dither->source, fault);
        if (!unit) return std::nullopt;
        checks.rule = {*unit, options.dither->name};
    }
    const std::vector<check::Unit>& units = modules.load(file);
    if (sink.errors() != errors) {
        if (modules.can_check()) report_beside(sources, units, checks, &sink);
        return std::nullopt;
    }
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
