// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/sample_kernel.h"

int openfab_sample_sse41(halide_buffer_t* requests, halide_buffer_t* texels, halide_buffer_t* info,
                         int32_t fields, int32_t channels, halide_buffer_t* out) {
    return openfab::texture::sse41::sample(requests, texels, info, fields, channels, out);
}
