// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets compiled into this process.

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "abi/fablet_table.h"
#include "compiler/frontend/frontend.h"
#include "compiler/lower/code/jit.h"

namespace openfab::python {

/// What the compiler has to say of a text.
struct Diagnostics {
    int code = 0;          ///< exit code of openflc; 0: it compiles
    std::string rendered;  ///< as openflc shows it: places, carets, help; empty: nothing to say
    std::string json;      ///< the same as data (diag::render_json)
    std::string fault;     ///< an error without a place; empty where there is none
};

/// The interface of the fablets in a text: the JSON of `openflc describe`, empty where it does not
/// compile.
struct Interface {
    Diagnostics diagnostics;
    std::string json;
    std::vector<std::filesystem::path> files;  ///< the file and all that it imports
};

/// Checks a file with all that it imports; a module of functions, too.
Interface read_interface(const std::filesystem::path& file);
/// Checks a text that is called `name` in messages, and imports from the standard library alone.
Interface read_interface(const std::string& name, std::string text);

/// The kernels of some fablets, for any number of prints at once.
class Program {
  public:
    const openfab_fablet_list& fablets() const { return loaded_->fablets(); }
    /// The sources and all that they import.
    const std::vector<std::filesystem::path>& files() const { return files_; }
    /// The number of kernels that no cache had.
    int compiled() const;
    /// Returns the directions in which one of its fablets has derivatives (lower::FabletUnit::directions).
    std::span<const int32_t> directions(const openfab_fablet& fablet) const;
    /// Prints as a print binary of these fablets does with these words, the first of which names it; returns its exit code.
    int main(const std::vector<std::string>& words) const;

  private:
    friend std::variant<std::shared_ptr<const Program>, Diagnostics> compile(
        const std::vector<std::string>& files, bool enable_printf,
        const std::optional<frontend::DitherRule>& rule,
        const std::vector<std::string>& derivatives, Diagnostics* warnings);
    Program() = default;

    std::unique_ptr<lower::LoadedProgram> loaded_;
    std::vector<std::filesystem::path> files_;
    std::vector<std::vector<int32_t>> directions_;  ///< of each fablet
};

/// Compiles the fablets of some files for this machine, with the kernels of OpenFab's own cache.
/// `rule` is the dither rule of those without one; `derivatives` names uniforms by which fractions are differentiated;
/// `warnings` receives what else there is to say.
std::variant<std::shared_ptr<const Program>, Diagnostics> compile(
    const std::vector<std::string>& files, bool enable_printf,
    const std::optional<frontend::DitherRule>& rule, const std::vector<std::string>& derivatives,
    Diagnostics* warnings);

}  // namespace openfab::python
