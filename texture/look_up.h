// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Look-ups in pictures, as generated code asks for them: an extern stage of its Halide pipeline
// (compiler/lower/sample.cpp), compiled once for each instruction set of kernels. It is not
// generated itself since Halide loads texels from 8 places one by one through one port, which took
// half of all time; here the two neighbours of a row are one load. What a look-up is, operation for
// operation, is defined in compiler/interp/sample.h; the bits are the same.
//
//   places   float [z][field][…] or [lane][field][…]: fields 0 asked (1 or 0), 1 u, 2 v,
//            3 width of the footprint (1 as it is), and if there are 10 fields, 4 to 6 the change
//            of u along the three axes of a voxel, 7 to 9 that of v
//   texels, info   of a Pyramid
//   fields   how many fields a place has: 4 or 10
//   channels 8 bits for each result, the first lowest: the channel asked for
//   out      float, places' shape with results for fields: 0 where a place is not asked
//
// The innermost extent is a multiple of 8 and dense. In a query of bounds (buffers without memory)
// the shape of `places` follows from that of `out`. Returns 0.

#include <HalideRuntime.h>

namespace openfab::texture {

constexpr int32_t kPlaceFields = 4;
constexpr int32_t kPlaceFieldsWithFootprint = 10;
constexpr int32_t kLookUpResults = 4;  ///< at most

}  // namespace openfab::texture

extern "C" {
int openfab_look_up_sse41(halide_buffer_t* places, halide_buffer_t* texels, halide_buffer_t* info,
                          int32_t fields, int32_t channels, halide_buffer_t* out);
int openfab_look_up_avx2(halide_buffer_t* places, halide_buffer_t* texels, halide_buffer_t* info,
                         int32_t fields, int32_t channels, halide_buffer_t* out);
}
