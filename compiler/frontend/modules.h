// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds, reads and parses the modules that a program imports. A module is a file `name.fl` beside
// the file that imports it, else one of the standard library, which is embedded in this program.

#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/diag/sink.h"
#include "compiler/source/source_manager.h"

namespace openfab::frontend {

/// Returns the names of the modules of the standard library, sorted.
std::vector<std::string> library_modules();
/// Returns the text of one; empty if there is none of this name.
std::string library_text(std::string_view name);
/// Returns the module of the standard library that has a function, constant or struct of a name; empty if none does.
std::string library_module_of(std::string_view name);
/// Returns the names of the modules beside a file, which is in `folder`.
std::vector<std::string> modules_beside(const std::filesystem::path& folder);

/// What follows an error: nothing, or what else can be found out, for editors.
enum class OnError : uint8_t { kStop, kContinue };

class Modules {
  public:
    Modules(source::SourceManager* sources, diag::Sink* sink, OnError on_error = OnError::kStop)
        : sources_(sources), sink_(sink), on_error_(on_error) {}

    /// Parses a file and all that it imports. With kStop the result is usable only if the sink has no errors, or
    /// as can_check() says; with
    /// kContinue it holds what could be parsed, the program always.
    /// The units point into this object.
    const std::vector<check::Unit>& load(uint32_t program);

    /// True if the program's tree holds all but its `damaged` parts, and its imports are whole: it can be checked,
    /// whatever the sink holds.
    bool can_check() const { return can_check_; }

    /// Parses a module that no program imports, and all that it imports, before the program; returns its unit's index.
    /// A file that cannot be read is reported in `fault`.
    std::optional<size_t> load_module(const std::filesystem::path& path, std::string* fault);

  private:
    /// A module that is being read or has been read.
    struct Entry {
        uint32_t file = 0;
        size_t unit = 0;
        bool done = false;
    };

    std::optional<size_t> parse(uint32_t file, const std::string& name);
    std::optional<size_t> import(const ast::Import& import, uint32_t from);
    std::optional<size_t> parse_module(uint32_t file, const std::string& key,
                                       const std::string& name, std::optional<source::Span> import);
    std::optional<uint32_t> find(const ast::Import& import, uint32_t from, std::string* key);
    void report_unknown(const ast::Import& import, uint32_t from);

    source::SourceManager* sources_;
    diag::Sink* sink_;
    OnError on_error_;
    bool can_check_ = false;
    std::deque<ast::File> files_;
    std::vector<check::Unit> units_;
    std::map<std::string, Entry> known_;  ///< by path, or by name in the library
};

}  // namespace openfab::frontend
