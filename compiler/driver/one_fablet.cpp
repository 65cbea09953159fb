// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/one_fablet.h"

#include <fmt/format.h>

#include "compiler/driver/commands.h"
#include "compiler/frontend/frontend.h"

namespace openfab::driver {

namespace {

const ir::Fablet* find_fablet(const ir::Module& module, const std::string& name,
                              std::string* fault) {
    std::string list;
    for (const ir::Fablet& fablet : module.fablets) {
        if (fablet.name == name || (name.empty() && module.fablets.size() == 1)) return &fablet;
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", fablet.name);
    }
    *fault = name.empty()
                 ? "the file has several fablets (" + list + "); choose one with `--fablet`"
                 : "the file has no fablet `" + name + "`; it has " + list;
    return nullptr;
}

}  // namespace

int read_fablet(const std::string& file, const std::string& name, bool enable_printf,
                const CommonOptions& common, source::SourceManager* sources, OneFablet* out) {
    diag::Sink sink;
    std::string fault;
    out->module =
        frontend::compile_to_ir(*sources, file, sink, &fault, {.enable_printf = enable_printf});
    print_diagnostics(sink, *sources, common);
    if (!fault.empty()) return fail(fault, unread_exit_code(file));
    if (!out->module) return kExitUserInput;
    out->fablet = find_fablet(*out->module, name, &fault);
    return out->fablet == nullptr ? fail(fault, kExitUsage) : kExitDone;
}

}  // namespace openfab::driver
