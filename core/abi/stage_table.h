/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0 */
#pragma once

/* The fixed-function kernels, compiled when the project is built (compiler/stages), in
 * libopenfab_kernels.a. They follow Halide's argv convention as the fablets' kernels do
 * (fablet_table.h).
 *
 * Shapes are innermost dimension first; z is the slice within the slab of 8 and always the
 * innermost, stride 1. A column is 8 voxels along z.
 *
 * Amounts become 16-bit fractions in every slab kernel, per voxel and independent of all others,
 * and in a kernel of its own for amounts that are there already. Channel 0 is void, which a voxel
 * without any amount is made of; the channels from 1 on take one slot each, ordered by material and
 * then by number. Slots of one material, and void, are added up in this order; the fraction of a
 * material is that of the last channel that has it, and the others' mean nothing.
 *
 * normalise:
 *   0 groups         int32   (m)                        columns of the weights
 *   1 channels       int32   (3, channel)               see openfab_channel
 *   2 weights        float   (z 8, column, slot)        column stride 8, slot stride free
 *   3 out fractions  uint16  (z 8, channel, m)          those of materials add up to 65535
 *   4 out codes      uint8   (z 8, m)                   the material of a pure voxel,
 *                                                       OPENFAB_CODE_MIXED elsewhere
 *   5 out unusable   uint16  (z 8, m)                   how many amounts are negative or NaN
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

/* Maximum number of materials with 4-bit codes, and with any: of 8 bits, 0 is void and
 * OPENFAB_CODE_MIXED none. */
#define OPENFAB_MAX_MATERIALS_4BIT 15
#define OPENFAB_MAX_MATERIALS 254

/* The rows of the table of channels. */
enum openfab_channel {
    OPENFAB_CHANNEL_SLOT = 0,     /* 0 of channel 0 */
    OPENFAB_CHANNEL_JOINS = 1,    /* 1 where the channel before has the same material */
    OPENFAB_CHANNEL_MATERIAL = 2, /* its code, 0 void; -1 where the next channel joins */
    OPENFAB_CHANNEL_ROWS = 3,
};

struct openfab_stages {
    openfab_kernel_fn normalise[OPENFAB_ISA_COUNT];
    openfab_kernel_fn pack4[OPENFAB_ISA_COUNT];
    openfab_kernel_fn pack8[OPENFAB_ISA_COUNT];
};

extern const struct openfab_stages openfab_stage_table;

#ifdef __cplusplus
}
#endif
