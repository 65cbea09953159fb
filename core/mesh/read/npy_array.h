// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads arrays of NumPy (`.npy`), as they lie in `.npz` archives.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::mesh {

/// A view of an array's numbers in the bytes of a file.
class NpyArray {
  public:
    /// Parses the bytes of one array, which must outlive it: little-endian numbers, last index fastest.
    static Complaint parse(std::string_view bytes, NpyArray* out);

    const std::vector<int64_t>& shape() const { return shape_; }
    int64_t size() const { return size_; }
    bool is_float() const { return kind_ == 'f'; }
    /// Returns a number; whole ones beyond 2^53 are not exact.
    double at(int64_t i) const;
    /// Returns "(12, 3)".
    std::string shape_text() const;

  private:
    std::vector<int64_t> shape_;
    int64_t size_ = 0;
    char kind_ = 'f';  ///< f, i, u or b
    int32_t width_ = 8;
    const char* data_ = nullptr;
};

}  // namespace openfab::mesh
