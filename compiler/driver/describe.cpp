// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>

#include "base/say.h"
#include "base/text.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/interface.h"
#include "compiler/frontend/frontend.h"

namespace openfab::driver {

int describe_file(const std::string& file, const CommonOptions& common) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const std::optional<ir::Module> module = frontend::compile_to_ir(sources, file, sink, &fault);
    print_diagnostics(sink, sources, common);
    if (!fault.empty()) return fail(fault, unread_exit_code(file));
    if (!module) return kExitUserInput;
    write_out(printable_json(describe(*module)));
    return kExitDone;
}

}  // namespace openfab::driver
