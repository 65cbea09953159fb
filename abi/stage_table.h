/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0 */
#pragma once

/* The fixed-function kernels, compiled when the project is built (compiler/stages), normalise for
 * 1, 2, 3, 4, 6, 8, 12, 15, 24, 32, 48 and 64 materials, in libopenfab_kernels.a. They follow
 * Halide's argv convention as the fablets' kernels do (fablet_table.h). M is the set's number of
 * materials; fractions have M + 1 of them, void first.
 *
 * Shapes are innermost dimension first; z is the slice within the slab of 8 and always the
 * innermost, stride 1. x and y are the position inside a block of 8 x 8 x 8 unless stated
 * otherwise; n is an index in a list of blocks.
 *
 * normalise: amounts to 16-bit fractions; per voxel and independent of all others.
 *   0 weights        float   (z 8, x 8, y 8, slot, n)   slot stride 512, block stride free
 *   1 slot_material  int32   (slot)                     0 void, else the material's code, at most M
 *   2 owned          uint8   (x 8, y 8, n)              bit z: the voxel is owned; others are
 *                                                       void and pure
 *   3 out fractions  uint16  (z 8, m M+1, x 8, y 8, n)  their sum is 65535
 *   4 out codes      uint8   (z 8, x 8, y 8, n)         the material of a pure voxel,
 *                                                       OPENFAB_CODE_MIXED elsewhere
 *   5 out unusable   int32   (z 8, n)                   negative or NaN amounts in owned voxels,
 *                                                       by slice
 *
 * pack4, pack8: codes of whole rows to 8 slice planes, at 4 bits a voxel (voxel 2x in the low half
 * of byte x, 2x + 1 in the high half) or 8; v = 2 or 1 voxels a byte.
 *   0 columns        uint64  (x v * width, y)          byte z: the code of the voxel in slice z
 *   1 out planes     uint8   (x width, y, z 8)          bytes
 */

#include "abi/fablet_table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Marks voxels in `codes` whose material the dither has yet to choose. */
#define OPENFAB_CODE_MIXED 255

/* Maximum number of materials with 4-bit codes, and with any. */
#define OPENFAB_MAX_MATERIALS_4BIT 15
#define OPENFAB_MAX_MATERIALS 64

struct openfab_stage_set {
    int32_t materials;
    openfab_kernel_fn normalise[OPENFAB_ISA_COUNT];
};

struct openfab_stages {
    int32_t set_count;
    const struct openfab_stage_set* sets; /* by rising number of materials */
    openfab_kernel_fn pack4[OPENFAB_ISA_COUNT];
    openfab_kernel_fn pack8[OPENFAB_ISA_COUNT];
};

extern const struct openfab_stages openfab_stage_table;

#ifdef __cplusplus
}
#endif
