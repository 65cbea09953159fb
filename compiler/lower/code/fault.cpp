// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/fault.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "texture/cache.h"

namespace openfab::lower {

namespace {

/// Says which disk is full, and what names another one.
std::string full_disk(const std::filesystem::path& folder) {
    if (folder.empty()) return "the disk is full; free some of it, or set TMPDIR";
    const Result<std::filesystem::path> cache = texture::cache_folder();
    const bool kept = cache && folder.string().starts_with(cache->string());
    return fmt::format("the disk of `{}` is full; free some of it{}", folder.string(),
                       kept ? ", or let OPENFAB_CACHE name a folder on another one" : "");
}

}  // namespace

std::string remedy_of(const std::string& trouble, const std::filesystem::path& folder) {
    struct Shortage {
        const char* says;
        const char* remedy;
    };
    constexpr const char* kMemory =
        "the system gave no memory; allow more (`ulimit -v`), or free some";
    // Halide and LLVM hand the system's words on, or say which call failed.
    const std::array<Shortage, 7> shortages{{
        {"mprotect failed", kMemory},
        {"mmap failed", kMemory},
        {"out of memory", kMemory},
        {"Cannot allocate memory", kMemory},
        {"Too many open files", "the system opens no more files; allow more (`ulimit -n`)"},
        {"File too large", "files may not be that large here; allow larger ones (`ulimit -f`)"},
        {"Resource temporarily unavailable",
         "the system starts no more processes or threads (`ulimit -u`)"},
    }};
    for (const char* full : {"No space left on device", "Disk quota exceeded"}) {
        if (trouble.find(full) != std::string::npos) return full_disk(folder);
    }
    for (const auto& [says, remedy] : shortages) {
        if (trouble.find(says) != std::string::npos) return remedy;
    }
    return {};
}

Fault fault_of(std::string trouble) {
    Fault fault;
    const std::string remedy = remedy_of(trouble);
    fault.is_outside = !remedy.empty();
    fault.trouble = fault.is_outside ? fmt::format("the kernels cannot be compiled: {}", remedy)
                                     : std::move(trouble);
    return fault;
}

}  // namespace openfab::lower
