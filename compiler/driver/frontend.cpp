// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/frontend.h"

#include "compiler/sema/check.h"
#include "compiler/sema/translate.h"
#include "compiler/syntax/parser.h"

namespace openfab::driver {

std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault) {
    const std::optional<uint32_t> file = sources.load(path, fault);
    if (!file) return std::nullopt;
    return compile_to_ir(sources, *file, sink);
}

std::optional<ir::Module> compile_to_ir(const source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink) {
    const std::vector<syntax::Token> tokens = syntax::lex(sources, file, &sink);
    if (sink.errors() != 0) return std::nullopt;
    const ast::File tree = syntax::parse(sources, tokens, &sink);
    if (sink.errors() != 0) return std::nullopt;
    const sema::Program program = sema::check(tree, &sink);
    if (sink.errors() != 0) return std::nullopt;
    ir::Module module = sema::translate(program, &sink);
    if (sink.errors() != 0) return std::nullopt;
    return module;
}

}  // namespace openfab::driver
