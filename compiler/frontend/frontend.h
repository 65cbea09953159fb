// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The front end: source file to IR.

#include <filesystem>
#include <optional>
#include <string>

#include "compiler/diag/sink.h"
#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::frontend {

struct FrontEndOptions {
    bool need_fablet = true;     ///< false: a module of functions is enough
    bool enable_printf = false;  ///< compile `printf` and `assert` in
};

/// Lexes, parses, checks and translates a file and its imports. Empty after any error; diagnostics
/// are in `sink`. A file that cannot be read is reported in `fault`, not as a diagnostic, since it
/// has no location.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault, const FrontEndOptions& options = {});

/// Does the same for a file that `sources` already holds.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink, const FrontEndOptions& options = {});

}  // namespace openfab::frontend
