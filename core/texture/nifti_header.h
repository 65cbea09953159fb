// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The header of a NIfTI file, 1 or 2, https://nifti.nimh.nih.gov. The cache reads from it whether its
// numbers are in a file of their own, the converter everything else.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::texture {

struct NiftiHeader {
    /// Bytes of a file's beginning that are enough to read it.
    static constexpr size_t kBytes = 544;

    bool swapped = false;    ///< big-endian
    bool detached = false;   ///< its numbers are in a file of their own
    bool is_double = false;  ///< its places are of 64 bits
    std::array<int64_t, 8> dim{};
    int64_t datatype = 0;
    std::array<double, 8> pixdim{};
    double offset = 0;  ///< of the first number, in bytes
    double slope = 0, intercept = 0;
    int64_t units = 0;
    int64_t qform = 0, sform = 0;  ///< above 0: it is given
    std::array<double, 3> quaternion{}, shift{};
    std::array<std::array<double, 4>, 3> affine{};  ///< rows
};

/// Returns whether bytes begin as such a file.
bool is_nifti(std::string_view bytes);
/// Reads the header; fails where the bytes are none.
Result<NiftiHeader> read_nifti_header(std::string_view bytes);
/// Returns the name of the data file that belongs to a detached header: `a.img` of `a.hdr`.
std::string nifti_data_file(const std::string& header_name);

}  // namespace openfab::texture
