// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads a stranger's file in a process of its own: a forked child with bounded memory and time, which starts no programs,
// opens no connections and, unless it is allowed to, changes no files. What it has read comes back over a line
// (jail_line.h).
//
// The child of a process with threads has the forking thread alone. A reader therefore takes no lock that others hold:
// the C library makes those of `malloc` usable in a child, readers have no others, and run threads of their own
// (own_threads.h) instead of a pool's.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "base/jail_line.h"
#include "base/result.h"

namespace openfab {

struct JailLimits {
    /// What the reader may take. Beside it the process gets as much again, and some for itself.
    int64_t memory_bytes = 0;
    int64_t seconds = 0;  ///< of processor time; 0: those of a file of this size
    /// Files and folders that may be read, as returned by without_links; empty: all. Counts where the kernel has Landlock.
    std::vector<std::filesystem::path> reads;
    /// Of converters, which write what they make, and say themselves what is to be known: the folders in which they may.
    std::vector<std::filesystem::path> writes;
    bool converts = false;
};

/// Calls `read` in a child, and `take` here with the other end of its line. If `read` fails, its error is returned, and
/// `take` is not called. A reader that crashes, takes too much or does not end is an error, which names `file`.
Result<void> run_in_jail(const std::filesystem::path& file, const JailLimits& limits,
                         const std::function<Result<void>()>& read,
                         const std::function<void(JailLine*)>& send,
                         const std::function<bool(JailLine*)>& take);

/// Returns whether this process is the child of run_in_jail.
bool inside_jail();

/// Tells the parent which of several files is read now: errors name it. Nothing outside of a jail.
void now_reading(const std::filesystem::path& file);

/// The limits of a reader that needs this file alone.
JailLimits limits_of_header(const std::filesystem::path& file, int64_t memory_bytes);

/// Returns how many seconds of the processor a file, or a folder of files, may take.
int64_t reading_seconds(const std::filesystem::path& file);

/// Calls `read` in a jail, and returns its value, which a function `pass(JailLine*, T*)` takes over the line. Under
/// sanitizers, and in a jail, it calls `read` alone: they are to see readers.
template <typename T>
Result<T> read_in_jail(const std::filesystem::path& file, const JailLimits& limits,
                       const std::function<Result<T>()>& read) {
#ifdef OPENFAB_SANITIZED
    constexpr bool kHere = true;
#else
    constexpr bool kHere = false;
#endif
    if (kHere || inside_jail()) return read();
    T value{};
    const auto make = [&]() -> Result<void> {
        Result<T> made = read();
        if (!made) return made.error();
        value = std::move(*made);
        return {};
    };
    const auto send = [&](JailLine* line) { pass(line, &value); };
    const auto take = [&](JailLine* line) {
        pass(line, &value);
        return line->fine();
    };
    if (Result<void> done = run_in_jail(file, limits, make, send, take); !done) return done.error();
    return value;
}

}  // namespace openfab
