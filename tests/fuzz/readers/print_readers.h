// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Readers of prints (readers.h), and files for readers that open one by its name.

#include <filesystem>
#include <string>
#include <string_view>

namespace openfab::testing {

/// A folder that all readers share.
const std::filesystem::path& folder();
/// A file in it of these bytes.
std::string written(const std::string& name, std::string_view bytes);

/// Opens a cached texture, and all of its tiles.
bool open_pyramid(const std::filesystem::path& file);

bool ofr(std::string_view bytes);
bool gcvf(std::string_view bytes);
bool slices(std::string_view bytes);
bool zarr_array(std::string_view bytes);
bool zarr_store(std::string_view bytes);

}  // namespace openfab::testing
