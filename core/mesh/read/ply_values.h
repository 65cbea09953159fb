// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers behind the header of a PLY file, as text or as bytes of either order.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/result.h"
#include "mesh/read/ply_header.h"

namespace openfab::mesh {

/// Reads the values after the header, one by one.
class PlyValues {
  public:
    PlyValues(std::string_view bytes, const PlyHeader& header)
        : bytes_(bytes), header_(header), at_(header.body), line_(header.body_line) {}

    /// Reads the next number; returns an error text, empty if none.
    Complaint next(PlyType type, double* out) {
        return header_.ascii ? next_ascii(type, out) : next_binary(type, out);
    }
    /// Returns the maximum number of values that can follow.
    size_t most_left(PlyType type) const {
        return (bytes_.size() - at_) / (header_.ascii ? 1 : ply_type_bytes(type));
    }
    int32_t line() const { return line_; }

    /// Returns the next `count` elements of `size` bytes, as stored in the file; null if there are
    /// fewer, or if they are not little-endian.
    const char* look(size_t count, size_t size) const {
        if (header_.ascii || header_.big_endian || (bytes_.size() - at_) / size < count)
            return nullptr;
        return bytes_.data() + at_;
    }
    void pass(size_t bytes) { at_ += bytes; }

  private:
    Complaint next_binary(PlyType type, double* out);
    Complaint next_ascii(PlyType type, double* out);

    std::string_view bytes_;
    const PlyHeader& header_;
    size_t at_;
    int32_t line_;
};

}  // namespace openfab::mesh
