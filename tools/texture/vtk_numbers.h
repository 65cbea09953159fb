// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of one array of a VTK file: bytes behind a header, in base64 or as they are, packed block
// by block or not.

#include <cstdint>
#include <memory>
#include <string_view>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// In the order of vtk_file.cpp's names.
enum class VtkType {
    kInt8,
    kUInt8,
    kInt16,
    kUInt16,
    kInt32,
    kUInt32,
    kInt64,
    kUInt64,
    kFloat32,
    kFloat64
};

/// Reads the numbers of an array, one after the other.
class VtkNumbers {
  public:
    virtual ~VtkNumbers() = default;
    /// Reads `count` numbers. Fails where there are fewer.
    virtual Result<void> next(double* out, size_t count) = 0;
};

constexpr const char* kVtkCutShort = "it is cut short: an array has fewer numbers than it says";

/// Where an array's bytes are.
struct VtkBytes {
    const InputFile* file = nullptr;  ///< from `begin` on; else in `text`
    int64_t begin = 0;
    std::string_view text;
    bool base64 = false, packed = false, swapped = false;
    int64_t header_bytes = 4;  ///< of each number of the header
};

/// Opens an array of `count` numbers. Fails where its header does not agree, or where there are not
/// bytes for as many.
Result<std::unique_ptr<VtkNumbers>> open_vtk_bytes(const VtkBytes& bytes, VtkType type,
                                                   int64_t count);

}  // namespace openfab::tools
