// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/frontend/frontend.h"

namespace openfab::driver {

int check(const std::vector<std::string>& files, const CommonOptions& common) {
    int exit_code = kExitDone;
    source::SourceManager sources;
    for (const std::string& file : files) {
        diag::Sink own;
        std::string fault;
        const bool ok = frontend::compile_to_ir(sources, file, own, &fault, {false}).has_value();
        print_diagnostics(own, sources, common);
        if (!fault.empty()) {
            exit_code = std::max(exit_code, fail(fault, unread_exit_code(file)));
        } else if (!ok) {
            exit_code = std::max(exit_code, kExitUserInput);
        }
    }
    return exit_code;
}

}  // namespace openfab::driver
