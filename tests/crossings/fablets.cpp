// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/fablets.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <memory>
#include <optional>

#include "abi/kernel_call.h"
#include "compiler/frontend/frontend.h"
#include "compiler/lower/code/kernel_cache.h"
#include "program/prepare.h"
#include "tests/support/load_module.h"
#include "tests/support/places/places.h"

namespace openfab::testing {

namespace {

std::unique_ptr<lower::LoadedProgram> load(const std::string& source) {
    namespace fs = std::filesystem;
    const fs::path folder = build_dir() / "tests/crossings_cache/here";
    fs::create_directories(folder);
    static lower::KernelCache cache(folder);
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, source_dir() / "tests/crossings" / source, sink, &fault);
    if (!module) {
        ADD_FAILURE() << source << ": " << fault;
        return nullptr;
    }
    auto loaded = load_module(*module, {.isas = {abi::best_isa()}, .cache = &cache});
    if (std::holds_alternative<lower::Fault>(loaded)) {
        ADD_FAILURE() << source << ": " << std::get<lower::Fault>(loaded).trouble;
        return nullptr;
    }
    return std::move(std::get<0>(loaded));
}

}  // namespace

const openfab_fablet_list& fablets_of(const std::string& source) {
    static std::map<std::string, std::unique_ptr<lower::LoadedProgram>> loaded;
    static const openfab_fablet_list none{};
    auto found = loaded.find(source);
    if (found == loaded.end()) found = loaded.emplace(source, load(source)).first;
    return found->second != nullptr ? found->second->fablets() : none;
}

Result<void> print_here(const openfab_fablet_list& fablets, const std::vector<std::string>& words,
                        MemorySink* sink) {
    std::vector<const char*> argv{"print"};
    for (const std::string& word : words)
        argv.push_back(word.c_str());
    const Result<program::Options> options =
        program::parse_options(static_cast<int>(argv.size()), argv.data(), "openfab print", false);
    if (!options) return options.error();
    static const std::atomic<bool> interrupt{false};
    Result<program::PreparedPrint> prepared =
        program::prepare_print(*options, fablets, {.interrupt = interrupt});
    if (!prepared) return prepared.error();
    pipeline::PrintStatistics statistics;
    return prepared->print->run(*sink, nullptr, interrupt, &statistics);
}

std::string shown(const Error& error) {
    return error.text() + (error.help.empty() ? "" : "\nhelp: " + error.help);
}

}  // namespace openfab::testing
