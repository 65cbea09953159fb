// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/lattice.h"

#include <algorithm>

#include "backends/common/tee_sink.h"

namespace openfab::boundary {

namespace {

constexpr size_t kBorder = 2;  // one voxel on each side
constexpr size_t kOverrun = 8;

}  // namespace

Layer::Layer(int32_t width, int32_t height)
    : stride_(static_cast<size_t>(width) + kBorder + kOverrun),
      codes_(stride_ * (static_cast<size_t>(height) + kBorder)) {}

void Layer::fill(const pipeline::SliceView& slice, int32_t bits) {
    for (int32_t y = 0; y < slice.height; ++y)
        backends::unpack_row(slice, y, bits,
                             codes_.data() + (static_cast<size_t>(y) + 1) * stride_ + 1);
}

void Layer::clear() {
    std::fill(codes_.begin(), codes_.end(), uint8_t{0});
}

}  // namespace openfab::boundary
