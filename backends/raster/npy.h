// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The file format of numpy's arrays, version 1.0.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openfab::raster {

constexpr size_t kNpyHeaderBytes = 128;

/// Returns the header of an array in C order, of kNpyHeaderBytes whatever the shape, so that it can be
/// written again. `type` is numpy's: "|u1", "<f4".
std::vector<uint8_t> npy_header(const std::string& type, std::span<const int64_t> shape);

}  // namespace openfab::raster
