// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "tests/support/load_module.h"

namespace openfab::bench {

/// Compiles OpenFL text to IR. An error prints the diagnostics and ends the benchmark.
inline ir::Module load_module(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("bench.fl", text), sink);
    if (!module) {
        fmt::print(stderr, "{}", diag::render_text(sink, sources));
        std::exit(4);
    }
    return *std::move(module);
}

/// Compiles OpenFL text in this process. An error ends the benchmark.
inline std::unique_ptr<lower::LoadedProgram> load_fablet(const std::string& text) {
    auto loaded = testing::load_module(load_module(text));
    if (std::holds_alternative<lower::Fault>(loaded)) std::exit(4);
    return std::move(std::get<0>(loaded));
}

}  // namespace openfab::bench
