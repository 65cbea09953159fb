// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The header of a PLY file: its elements and their properties.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::mesh {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Returns the size of a value in a binary file.
size_t ply_type_bytes(PlyType type);

inline bool is_ply_integer(PlyType type) {
    return type < PlyType::kFloat32;
}

/// A property of an element.
struct PlyProperty {
    std::string name;
    PlyType type = PlyType::kFloat32;
    bool is_list = false;
    PlyType count_type = PlyType::kUint8;  ///< type of a list's length
};

/// An element with its properties.
struct PlyElement {
    std::string name;
    int64_t count = 0;
    std::vector<PlyProperty> properties;
};

/// The parsed header.
struct PlyHeader {
    bool ascii = true;
    bool big_endian = false;
    std::vector<PlyElement> elements;
    std::vector<std::string> pictures;  ///< of comments `TextureFile NAME`, in order
    size_t body = 0;                    ///< offset of the first byte after the header
    int32_t body_line = 0;              ///< its line
};

/// Parses the header. Errors are `file:line:1: …`.
Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& file);

}  // namespace openfab::mesh
