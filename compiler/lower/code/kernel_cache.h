// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Machine code of kernels that were compiled before, so that a change of a fablet compiles only the
// kernels that it changes: neither a comment nor a uniform's value changes any. `openflc run`,
// `build` and with it `openfab print` share one folder. An entry is an object file, and behind it,
// where neither linker nor loader reads, a seal:
//
//   object file | "OFKERNEL" | stored_bytes (8 bytes)
//   | xxh3 of the object, seeded with that of the key and stored_bytes (8 bytes)

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "base/lru_cache.h"
#include "base/result.h"
#include "compiler/lower/code/compile.h"

namespace openfab::lower {

/// Names a kernel by all that decides its code: 128 bits, so that two never meet.
struct KernelKey {
    uint64_t high = 0;
    uint64_t low = 0;

    bool operator==(const KernelKey&) const = default;
    /// Returns 32 hex digits.
    std::string text() const;
};

/// Returns the key of a kernel for this build of the compiler; the name of its function plays no
/// part.
KernelKey key_of(const KernelRequest& request);

/// An object file in memory.
struct KernelObject {
    KernelKey key;
    std::string code;
    int64_t stored_bytes = 0;  ///< see CompiledKernel

    size_t bytes() const { return code.size(); }
};

/// Thread-safe; processes may share a folder.
class KernelCache {
  public:
    /// More than the kernels of the gallery take for every instruction set.
    static constexpr int64_t kFolderBytes = 64 << 20;

    /// Keeps kernels in memory and, unless `folder` is empty, in a folder that only this user can
    /// write (own_folder), of at most `folder_bytes` after `trim`.
    explicit KernelCache(std::filesystem::path folder = {}, int64_t folder_bytes = kFolderBytes);

    /// Returns OpenFab's own folder for kernels; an error says why it must not be used.
    static Result<std::filesystem::path> own_folder();

    /// Returns the kernel, or null where it is not kept. Damaged entries are removed.
    std::shared_ptr<const KernelObject> find(const KernelKey& key);
    /// Keeps a kernel. What cannot be written to the folder is kept in memory alone.
    void insert(std::shared_ptr<const KernelObject> object);
    /// Removes what was not used for longest until the folder is below its bound, and what writers
    /// that were killed left there.
    void trim();

  private:
    std::filesystem::path entry(const KernelKey& key) const;
    std::shared_ptr<const KernelObject> read(const KernelKey& key) const;
    bool write(const KernelObject& object) const;

    std::filesystem::path folder_;
    int64_t folder_bytes_;
    LruCache<uint64_t, KernelObject> memory_;
};

/// What became of a request.
struct MadeKernel {
    std::shared_ptr<const KernelObject> object;
    bool compiled = false;  ///< else it was in the cache
};

/// Returns a kernel from the cache, else compiles and keeps it; `cache` may be null.
std::variant<MadeKernel, Fault> find_or_compile(const KernelRequest& request, const KernelKey& key,
                                                KernelCache* cache);

}  // namespace openfab::lower
