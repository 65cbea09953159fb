// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls libraries that were not made for untrusted files.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "base/jail.h"
#include "base/result.h"

namespace openfab::tools {

/// Calls `make` in a jail (base/jail.h) that may write where `output` lies, and in the folder of temporary files, and
/// returns its result. A file that makes the library crash, or take more, is an error like others, which names `file`;
/// what the child wrote stays. Within a jail it calls `make` alone.
Result<void> guarded(int64_t memory_bytes, const std::filesystem::path& file,
                     const std::function<Result<void>()>& make,
                     const std::filesystem::path& output = {});

/// Says what the person should know of a file that is read all the same, as a note (base/say.h).
void tell(const std::string& message);

}  // namespace openfab::tools
