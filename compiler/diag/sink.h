// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Collects diagnostics. The steps of the front end report and carry on; the driver renders once, at
// the end.

#include <cstddef>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "compiler/diag/diagnostic.h"

namespace openfab::diag {

class Sink {
  public:
    /// The most diagnostics kept: more than anyone reads, so that a file of random bytes does not
    /// fill memory.
    static constexpr size_t kMaxKept = 2000;

    /// Adds a message; a second one with the same id at the same span is dropped. The reference,
    /// for notes and help, lives until the next report.
    template <typename... Args>
    Diagnostic& report(const source::Span& span, const Descriptor<Args...>& what,
                       std::type_identity_t<Args>... args) {
        return add(what.id, what.severity, span,
                   fmt::vformat(what.format, fmt::make_format_args(args...)));
    }

    /// Adds what another sink holds, by the same rule.
    void take(Diagnostic d);

    /// Adds a note at `import`, which imported the module `file`, to every message about that file.
    void set_origin(uint32_t file, const source::Span& import, std::string note);

    /// A point to roll back to: what was reported after it is dropped.
    struct Mark {
        size_t kept = 0;
        size_t errors = 0;
        size_t warnings = 0;
    };
    Mark mark() const { return {kept_.size(), errors_, warnings_}; }
    void rollback(const Mark& mark);

    size_t errors() const { return errors_; }
    size_t warnings() const { return warnings_; }
    /// Returns the diagnostics in order of file and position.
    std::vector<Diagnostic> sorted() const;

  private:
    Diagnostic& add(Id id, Severity severity, const source::Span& span, std::string message);

    /// Counts a message; returns whether to keep it.
    bool count(const Diagnostic& d);
    void add_origins(Diagnostic* d) const;

    std::vector<Diagnostic> kept_;
    std::map<uint32_t, Note> origins_;
    Diagnostic dropped_;
    size_t errors_ = 0;
    size_t warnings_ = 0;
};

}  // namespace openfab::diag
