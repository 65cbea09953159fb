// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "compiler/lower/schedule/apply_schedule.h"

namespace openfab::lower {

namespace {

struct Reason {
    const char* halide;  ///< a part of its message
    const char* message;
    const char* help;
    const char* directives;  ///< which one is to blame, if the line has it
    bool of_tuples = false;  ///< its message names no Func: those of several values may be meant
};

constexpr Reason kReasons[] = {
    {"invalid location", "`{}` is not computed in a loop around all that reads it",
     "a func is computed inside a loop of a func that uses it, or in none (compute_root)",
     "compute_at"},
    {"constant extent", "a loop of `{}` has no constant length",
     "only loops of constant length can be vectorized or unrolled; give a factor, as in "
     "`vectorize(n, 8)`",
     "vectorize unroll"},
    {"prefetch", "`{}` cannot be prefetched here", "", "prefetch"},
    // Mended in later versions.
    {"op->value_index == 0",
     "`{}` would be stored here on a condition that reads a func of several values, as it is one: "
     "Halide 14 cannot do that",
     "compute it at an outer loop, or split and unroll by factors that divide", "compute_at", true},
};

/// Returns whether `text` holds `name` as a whole word; Halide numbers Funcs of one name.
bool mentions(const std::string& text, const std::string& name) {
    const auto is_word = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    };
    for (size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
        const size_t end = at + name.size();
        if ((at == 0 || !is_word(text[at - 1])) && (end == text.size() || !is_word(text[end])))
            return true;
    }
    return false;
}

const schedule::Directive* find_directive(const schedule::Line& line, const std::string& names) {
    for (const schedule::Directive& directive : line.directives) {
        if (mentions(names, directive.name.text)) return &directive;
    }
    return nullptr;
}

bool names(const schedule::Line& line, const std::string& func) {
    const std::string& pattern = line.func.text;
    return pattern.back() == '*' ? func.starts_with(pattern.substr(0, pattern.size() - 1))
                                 : func == pattern;
}

/// Finds the last line that has one of these directives for a Func of which `text` speaks; else the
/// last that names such a Func; else the last.
struct Guilty {
    const schedule::Line* line = nullptr;
    const schedule::Directive* directive = nullptr;
    schedule::Word start;

    Guilty(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
           const std::string& text, const std::string& directives)
        : start(schedule::start_of(schedule)) {
        for (const schedule::Line& each : schedule.lines) {
            const bool spoken_of =
                std::any_of(kernel.funcs().begin(), kernel.funcs().end(), [&](const auto& func) {
                    return func.is_listed && names(each, func.name) && mentions(text, func.name);
                });
            const schedule::Directive* blamed = find_directive(each, directives);
            if (!spoken_of || (directive != nullptr && blamed == nullptr)) continue;
            line = &each;
            directive = blamed;
        }
        if (line == nullptr && !schedule.lines.empty()) line = &schedule.lines.back();
    }

    schedule::Word word() const {
        if (directive != nullptr) return directive->name;
        if (line != nullptr) return line->func;
        return start;
    }
    std::string name() const { return line != nullptr ? line->func.text : "the kernel"; }
};

/// Returns the names of Funcs of several values that are computed in a loop.
std::string names_of_tuples(const ScheduledKernel& kernel) {
    std::string out;
    for (const ScheduledFunc& func : kernel.funcs()) {
        if (func.func.outputs() > 1 && func.compute.level == Placement::Level::kAt)
            out += func.name + " ";
    }
    return out;
}

}  // namespace

schedule::Fault fault_of_lowering(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
                                  const std::string& message) {
    const auto* reason =
        std::find_if(std::begin(kReasons), std::end(kReasons),
                     [&](const Reason& r) { return message.find(r.halide) != std::string::npos; });
    const bool known = reason != std::end(kReasons);
    const Guilty guilty(schedule, kernel,
                        known && reason->of_tuples ? names_of_tuples(kernel) : message,
                        known ? reason->directives : "");
    if (!known || guilty.directive == nullptr) {
        return schedule::fault_at(
            guilty.word(),
            fmt::format("`{}` cannot be computed as this schedule asks", guilty.name()),
            "the loops that it asks for cannot be made");
    }
    return schedule::fault_at(
        guilty.word(), fmt::format(fmt::runtime(reason->message), guilty.name()), reason->help);
}

schedule::Fault storage_fault(const schedule::Word& directive, const std::string& func) {
    return schedule::fault_at(
        directive,
        fmt::format("it is not certain that this holds all of `{}` that is in use at a time", func),
        "make it larger; without it, what is stored is right by itself");
}

schedule::Fault fault_of_bound(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
                               const std::string& text) {
    const Guilty guilty(schedule, kernel, text, "bound_storage");
    return storage_fault(guilty.word(), guilty.name());
}

}  // namespace openfab::lower
