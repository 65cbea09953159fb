// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/say.h"
#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/frontend/frontend.h"

namespace openfab::driver {

namespace {

/// Returns whether no stage is too long to be compiled, which the passes show.
bool are_short(const ir::Module& module, diag::Sink* sink, std::string* bug) {
    bool all = true;
    for (const ir::Fablet& fablet : module.fablets) {
        const passes::PipelineResult result = run_passes(fablet, {});
        if (bug->empty()) *bug = result.fault;
        all = result.fault.empty() && !refuse_long_stages(fablet, result, sink) && all;
    }
    return all;
}

}  // namespace

int check(const std::vector<std::string>& files, const CommonOptions& common) {
    int exit_code = kExitDone;
    source::SourceManager sources;
    for (const std::string& file : files) {
        diag::Sink own;
        std::string fault;
        std::string bug;
        const std::optional<ir::Module> module =
            frontend::compile_to_ir(sources, file, own, &fault, {false});
        const bool ok = module && are_short(*module, &own, &bug);
        print_diagnostics(own, sources, common);
        if (!fault.empty()) {
            exit_code = std::max(exit_code, fail(fault, unread_exit_code(file)));
        } else if (!bug.empty()) {
            exit_code = std::max(exit_code, fail(bug, kExitBug));
        } else if (!ok) {
            exit_code = std::max(exit_code, kExitUserInput);
        }
    }
    return exit_code;
}

}  // namespace openfab::driver
