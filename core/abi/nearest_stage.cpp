// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/nearest_stage.h"

#include "base/check.h"

int openfab_nearest(halide_buffer_t* demand, void* source, halide_buffer_t* results) {
    const halide_dimension_t& columns = results->dim[2];
    if (demand->host == nullptr || results->host == nullptr) {
        if (demand->host == nullptr) {
            demand->dim[0].min = 0;
            demand->dim[0].extent = 8;
            demand->dim[1].min = columns.min;
            demand->dim[1].extent = columns.extent;
        }
        return 0;
    }
    // The lowering bounds both so; strides are Halide's own, of buffers that it allocates.
    OPENFAB_CHECK_EQ(results->dim[0].extent, 8);
    OPENFAB_CHECK_EQ(results->dim[0].stride, 1);
    OPENFAB_CHECK_EQ(demand->dim[0].stride, 1);
    const auto offset = static_cast<ptrdiff_t>(columns.min - demand->dim[1].min);
    openfab_nearest_request request;
    request.first = columns.min;
    request.count = columns.extent;
    request.demand = demand->host + offset * demand->dim[1].stride - demand->dim[0].min;
    request.demand_stride = demand->dim[1].stride;
    request.results = reinterpret_cast<float*>(results->host);
    request.field_stride = results->dim[1].stride;
    request.column_stride = columns.stride;
    auto* asked = static_cast<openfab_nearest_source*>(source);
    return asked->answer(asked, &request);
}
