// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Source file to IR, for every command that needs more than the text.

#include <filesystem>
#include <optional>
#include <string>

#include "compiler/diag/sink.h"
#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

struct FrontEndOptions {
    bool need_fablet = true;  ///< else a module of functions will do
    bool prints = false;      ///< `printf` and `assert` do something
};

/// Lexes, parses, checks and translates a file and what it imports. Empty where anything is an
/// error; what was found is in `sink`. A file that cannot be read is said in `fault` and is no
/// diagnostic, since it has no place.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault, const FrontEndOptions& options = {});

/// The same for a file that `sources` already holds.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink, const FrontEndOptions& options = {});

}  // namespace openfab::driver
