// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/diag/sink.h"

#include <algorithm>
#include <utility>

namespace openfab::diag {

namespace {

constexpr const char* kIds[] = {
#define OPENFAB_DIAGNOSTIC(name, id, ...) id,
#include "compiler/diag/diagnostics.def"
#undef OPENFAB_DIAGNOSTIC
};

bool comes_before(const Diagnostic& a, const Diagnostic& b) {
    if (a.span.file != b.span.file) return a.span.file < b.span.file;
    return a.span.begin < b.span.begin;
}

}  // namespace

const char* id_text(Id id) {
    return kIds[static_cast<size_t>(id)];
}

bool Sink::count(const Diagnostic& d) {
    const bool known = std::any_of(kept_.begin(), kept_.end(), [&](const Diagnostic& other) {
        return other.id == d.id && other.span == d.span;
    });
    if (!known) ++(d.severity == Severity::kError ? errors_ : warnings_);
    return !known && kept_.size() < kMaxKept;
}

Diagnostic& Sink::add(Id id, Severity severity, const source::Span& span, std::string message) {
    Diagnostic d{id, severity, span, std::move(message), {}, {}, {}};
    if (!count(d)) {
        dropped_ = {};
        return dropped_;
    }
    kept_.push_back(std::move(d));
    return kept_.back();
}

void Sink::take(Diagnostic d) {
    if (count(d)) kept_.push_back(std::move(d));
}

void Sink::rollback(const Mark& mark) {
    kept_.resize(mark.kept);
    errors_ = mark.errors;
    warnings_ = mark.warnings;
}

void Sink::set_origin(uint32_t file, const source::Span& import, std::string note) {
    origins_.try_emplace(file, Note{import, std::move(note)});
}

/// From the module to what imports it, and so on up to the program.
void Sink::add_origins(Diagnostic* d) const {
    auto origin = origins_.find(d->span.file);
    for (size_t i = 0; i < origins_.size() && origin != origins_.end(); ++i) {
        d->notes.push_back(origin->second);
        origin = origins_.find(origin->second.span.file);
    }
}

std::vector<Diagnostic> Sink::sorted() const {
    std::vector<Diagnostic> out = kept_;
    for (Diagnostic& d : out)
        add_origins(&d);
    std::stable_sort(out.begin(), out.end(), comes_before);
    return out;
}

}  // namespace openfab::diag
