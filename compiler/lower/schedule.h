// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Schedule files: how a kernel runs, never what it computes. One chain of directives a line:
//
//   # comment
//   weights.vectorize(z)
//   texture_*.compute_at(weights, x).vectorize(z).update().vectorize(z)
//
// A name ending in `*` matches all Funcs with that prefix, maybe none. `update()` moves the rest of
// the line to the Func's loop over taps. Funcs and vars are those of compiler/lower/kernel.h and
// the vars that earlier lines split off. Directives:
//   split(var, outer, inner, factor)    tile(x, y, xo, yo, xi, yi, fx, fy)
//   fuse(inner, outer, fused)           reorder(var, …)
//   unroll(var[, factor])               vectorize(var[, factor])      parallel(var)
//   compute_at(func, var)               compute_root()
//   store_at(func, var)                 store_root()

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace openfab::lower {

/// An error in a schedule file; columns count bytes from 1.
struct ScheduleFault {
    std::string id = "schedule-illegal";
    std::string message;
    std::string help;  ///< may be empty
    int32_t line = 0;
    int32_t column = 0;
    int32_t length = 1;
    size_t offset = 0;  ///< of the column in the file's text
};

struct ScheduleWord {
    std::string text;
    int32_t column = 0;
    size_t offset = 0;
};

struct Directive {
    ScheduleWord name;
    std::vector<ScheduleWord> args;
};

struct ScheduleLine {
    int32_t line = 0;
    ScheduleWord func;
    std::vector<Directive> directives;
};

struct Schedule {
    std::string path;  ///< as given by the user, or "schedules/slab.sched"
    std::string text;
    std::vector<ScheduleLine> lines;
};

/// Returns help for an unknown word: "did you mean `x`?", else "it has x, y", where `all` is "it
/// has".
std::string near_or_all(std::string_view word, std::span<const std::string> names, const char* all);

/// Parses a schedule: form, directive names and argument counts. apply_schedule checks funcs and
/// vars.
std::variant<Schedule, ScheduleFault> parse_schedule(std::string path, std::string_view text);

/// Returns the built-in schedule of a kernel ("volume") for a target ("avx2"):
/// `<kernel>.<target>.sched` if there is one, else `<kernel>.sched`.
const Schedule& default_schedule(std::string_view kernel, std::string_view target);

}  // namespace openfab::lower
