// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of one array of a file of VTK or XDMF: as text, or as bytes. Those of VTK stand behind a
// header, in base64 or as they are, packed block by block or not.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// What an array holds, in the order of vtk_file.cpp's names.
enum class ArrayType {
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
class ArrayNumbers {
  public:
    virtual ~ArrayNumbers() = default;
    /// Reads `count` numbers. Fails where there are fewer.
    virtual Result<void> next(double* out, size_t count) = 0;
    /// Whether they are integers, of which a float may not hold each.
    virtual bool are_integers() const { return false; }
    /// Whether an integer was read that not even a double holds.
    virtual bool has_lost() const { return false; }
    bool told_rounded = false;  ///< that it does not
};

/// Where an array's bytes are.
struct ArrayBytes {
    const InputFile* file = nullptr;  ///< from `begin` on; else in `text`
    int64_t begin = 0;
    std::string_view text;
    bool base64 = false, packed = false, swapped = false;
    int64_t header_bytes = 4;  ///< of each number of the header; 0: there is none
};

/// Opens an array of `count` numbers with blanks between them. Fails where the text is too short for as
/// many; must not outlive it.
Result<std::unique_ptr<ArrayNumbers>> open_array_text(std::string_view text, int64_t count);

/// Opens an array of `count` numbers. Fails where its header does not agree, or where there are not
/// bytes for as many.
Result<std::unique_ptr<ArrayNumbers>> open_array_bytes(const ArrayBytes& bytes, ArrayType type,
                                                       int64_t count);

/// Picks the field that is read: the one of this name, without a name the `usual` one or the only one;
/// the first where several have it. Fails with the names that there are.
Result<size_t> pick_field(const std::vector<std::string>& names, const std::string& wanted,
                          const std::string& usual = {});

/// Returns the components of a field as channels. Fails where there are more than four.
Result<int32_t> field_channels(const std::string& name, int64_t components);

/// Whether the numbers of an array of sides `a` are in the order of one of sides `b`, the last of which runs
/// fastest: they are if one has the sides of the other but for some that are taken together, and sides of 1.
bool are_in_one_order(const std::vector<int64_t>& a, const std::vector<int64_t>& b);

/// Reads the next `count` numbers, rounded to float; tells where that changes an integer.
Result<void> read_floats(ArrayNumbers* numbers, float* out, int64_t count);

}  // namespace openfab::tools
