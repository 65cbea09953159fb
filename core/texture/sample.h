// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Samples pictures for generated code: an extern stage of its Halide pipeline
// (compiler/lower/algorithm/sample.cpp), compiled once for each instruction set of kernels. It is not
// generated, since Halide gathers 8 texels one by one through one port, which took half of the
// time; here two neighbours of a row are one load. compiler/interp/sample.h defines a sample
// operation by operation; the bits are the same.
//
//   requests float [z][field][…] or [lane][field][…]: fields 0 active (1 or 0), 1 u, 2 v,
//            3 scale of the footprint (1 by default), and if there are 10 fields, 4 to 6 the change
//            of u along the three axes of a voxel, 7 to 9 that of v
//   texels, info   of a Pyramid
//   fields   number of fields of a request: 4 or 10
//   channels 8 bits for each result, the first lowest: its channel, or kOwnColor + one of the first
//            three
//   out      float, shape of `requests` with results for fields: 0 in inactive lanes
//
// The innermost extent is a multiple of 8 and dense. In a query of bounds (buffers without memory)
// the shape of `requests` follows from that of `out`. Returns 0.

#include <HalideRuntime.h>

namespace openfab::texture {

constexpr int32_t kSampleFields = 4;
constexpr int32_t kSampleFieldsWithFootprint = 10;
constexpr int32_t kMaxSampleResults = 4;  ///< at most
/// Added to a channel of colour: the colour of what is there, instead of how it looks on white.
constexpr int32_t kOwnColor = 128;

}  // namespace openfab::texture

extern "C" {
int openfab_sample_sse41(halide_buffer_t* requests, halide_buffer_t* texels, halide_buffer_t* info,
                         int32_t fields, int32_t channels, halide_buffer_t* out);
int openfab_sample_avx2(halide_buffer_t* requests, halide_buffer_t* texels, halide_buffer_t* info,
                        int32_t fields, int32_t channels, halide_buffer_t* out);
}
