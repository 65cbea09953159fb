/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0 */
#pragma once

/* The extern stage of slab kernels that asks the runtime for what voxels find at their nearest
 * surface point. The runtime's side is an openfab_nearest_source, whose address is the kernel's
 * argument OPENFAB_ARG_NEAREST_SOURCE; it knows the columns that the call lists, and which result
 * each field is (openfab_fablet.fields). */

#include <HalideRuntime.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Some of the columns of a call. */
struct openfab_nearest_request {
    int32_t first; /* index in the list of the first column */
    int32_t count;
    const uint8_t* demand;   /* 8 bytes a column: 1 where the voxel needs its results, else 0 */
    ptrdiff_t demand_stride; /* from column to column, bytes */
    float* results;          /* 8 floats a field of a column, or ints by their bits */
    ptrdiff_t field_stride, column_stride; /* floats */
};

struct openfab_nearest_source {
    /* Writes all fields of the request's columns, 0 for a voxel that needs none. Returns 0 or a
     * Halide error code. Parallel loops call it from several threads at once. */
    int (*answer)(struct openfab_nearest_source* source,
                  const struct openfab_nearest_request* request);
};

/* `demand` is uint8 (z 8, column), `results` float (z 8, field, column). In a query of bounds
 * (buffers without memory) the shape of `demand` follows from that of `results`. */
int openfab_nearest(halide_buffer_t* demand, void* source, halide_buffer_t* results);

#ifdef __cplusplus
}
#endif
