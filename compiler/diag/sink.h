// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Collects diagnostics. Phases report and carry on; the driver renders once, at the end.

#include <cstddef>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "compiler/diag/diagnostic.h"

namespace openfab::diag {

class Sink {
  public:
    /// More than anyone reads; a file of random bytes must not fill memory.
    static constexpr size_t kMaxKept = 2000;

    /// Adds a message; a second one with the same id at the same place is dropped. The reference,
    /// for notes and help, lives until the next report.
    template <typename... Args>
    Diagnostic& report(const source::Span& span, const Descriptor<Args...>& what,
                       std::type_identity_t<Args>... args) {
        return add(what.id, what.severity, span,
                   fmt::vformat(what.format, fmt::make_format_args(args...)));
    }

    /// Adds what another sink holds, by the same rule.
    void take(Diagnostic d);

    /// Messages about `file`, a module, get a note at the import that brought it in.
    void set_origin(uint32_t file, const source::Span& import, std::string note);

    /// A point to go back to: what was reported after it is forgotten.
    struct Mark {
        size_t kept = 0;
        size_t errors = 0;
        size_t warnings = 0;
    };
    Mark mark() const { return {kept_.size(), errors_, warnings_}; }
    void undo(const Mark& mark);

    size_t errors() const { return errors_; }
    size_t warnings() const { return warnings_; }
    /// In order of file and position.
    std::vector<Diagnostic> sorted() const;

  private:
    Diagnostic& add(Id id, Severity severity, const source::Span& span, std::string message);

    /// Counts a message; true where it is to be kept.
    bool count(const Diagnostic& d);
    void add_origins(Diagnostic* d) const;

    std::vector<Diagnostic> kept_;
    std::map<uint32_t, Note> origins_;
    Diagnostic dropped_;
    size_t errors_ = 0;
    size_t warnings_ = 0;
};

}  // namespace openfab::diag
