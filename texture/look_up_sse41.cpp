// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#define OPENFAB_LOOK_UP_ISA sse41
#include "texture/look_up.inl"

int openfab_look_up_sse41(halide_buffer_t* places, halide_buffer_t* texels, halide_buffer_t* info,
                          int32_t fields, int32_t channels, halide_buffer_t* out) {
    return openfab::texture::sse41::look_up(places, texels, info, fields, channels, out);
}
