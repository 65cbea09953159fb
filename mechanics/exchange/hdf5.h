// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes HDF5 files of plain arrays, without its library: a superblock, one group, and arrays in one piece
// each (format specification 3.0: superblock 2, object headers 2; readers from HDF5 1.8 on).

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mechanics/exchange/text_file.h"

namespace openfab::mechanics {

enum class Hdf5Type { kUint8, kInt64, kFloat32, kFloat64 };

struct Hdf5Array {
    std::string name;
    std::vector<uint64_t> shape;
    Hdf5Type type = Hdf5Type::kFloat32;
    /// Puts all its values, so that arrays need not be in memory at once.
    std::function<void(TextFile*)> put;

    uint64_t bytes() const;
};

Result<void> write_hdf5(const std::filesystem::path& file, const std::vector<Hdf5Array>& arrays);

/// Jenkins' lookup3, which HDF5 guards its heads with.
uint32_t lookup3(std::span<const uint8_t> bytes);

}  // namespace openfab::mechanics
