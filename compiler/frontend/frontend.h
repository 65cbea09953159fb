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

/// A function of a module that is the dither rule of fablets without one.
struct DitherRule {
    std::string source;  ///< the module's file
    std::string name;

    bool operator==(const DitherRule&) const = default;
};

struct FrontEndOptions {
    bool need_fablet = true;     ///< false: a module of functions is enough
    bool enable_printf = false;  ///< compile `printf` and `assert` in
    const DitherRule* dither = nullptr;
};

/// Lexes, parses, checks and translates a file and its imports. Empty after any error; diagnostics
/// are in `sink`. A file that cannot be read is reported in `fault`, not as a diagnostic, since it
/// has no location.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources,
                                        const std::filesystem::path& path, diag::Sink& sink,
                                        std::string* fault, const FrontEndOptions& options = {});

/// Does the same for a file that `sources` already holds. `fault` may be null where no dither rule is given.
std::optional<ir::Module> compile_to_ir(source::SourceManager& sources, uint32_t file,
                                        diag::Sink& sink, const FrontEndOptions& options = {},
                                        std::string* fault = nullptr);

}  // namespace openfab::frontend
