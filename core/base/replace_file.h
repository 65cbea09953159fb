// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"

namespace openfab {

/// Replaces a file's content at once, so that nobody reads half of it; it keeps its permissions.
Result<void> replace_file(const std::filesystem::path& file, const std::string& text);

/// Copies a file at once, with its permissions: where it fails, as on a full disk, what was there before is there.
Result<void> copy_at_once(const std::filesystem::path& from, const std::filesystem::path& to);

/// Refuses a folder, pipe or device as the name of a file that is made under another name and
/// renamed: `-o /dev/null` would replace the device.
Result<void> check_replaceable(const std::filesystem::path& file);

}  // namespace openfab
