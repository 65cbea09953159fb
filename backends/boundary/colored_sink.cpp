// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/colored_sink.h"

#include <utility>

#include "backends/boundary/color_layers.h"
#include "backends/common/tee_sink.h"

namespace openfab::boundary {

namespace {

enum Body : uint8_t { kVoid, kOpaque, kClear, kSupport };

/// The print as one of bodies.
pipeline::PrintInfo of_bodies(const pipeline::PrintInfo& info) {
    pipeline::PrintInfo out = info;
    out.bits = 8;
    out.materials.clear();
    for (const char* name : {"opaque", "clear", "support"})
        out.materials.emplace_back().name = name;
    out.support_code = kSupport;
    return out;
}

}  // namespace

int64_t colored_bytes_per_column(int32_t slices) {
    return int64_t{slices} * int64_t{sizeof(Rgba)} + ColorLayers::kBytesPerColumn +
           int64_t{sizeof(Rgba)} + 1;
}

ColoredSink::ColoredSink(const std::filesystem::path& path, backends::MixtureInlet* inlet)
    : meshes_(make_colored_writer(path)) {
    inlet->set_output(&planes_);
}

Result<void> ColoredSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    colors_ = std::make_unique<MixtureColors>(info.materials);
    return meshes_.begin(of_bodies(info));
}

std::vector<uint8_t> ColoredSink::encode(const pipeline::SliceView& slice) const {
    return backends::unpack_slice(slice, info_.bits);
}

Result<void> ColoredSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    constexpr Rgba kHalf = 128;
    slice_ = planes_.take(z);
    slice_.resize(bytes.size());
    for (size_t i = 0; i < bytes.size(); ++i) {
        uint8_t& code = bytes[i];
        if (code == 0) continue;
        // What the fablet has as void is support, or the substitute of another machine's part.
        if (slice_[i] == 0) slice_[i] = colors_->of_code(code);
        const bool is_clear = (slice_[i] & 255) < kHalf;
        code = code == info_.support_code ? kSupport : is_clear ? kClear : kOpaque;
    }
    return meshes_.commit_colored(z, std::move(bytes), slice_);
}

Result<void> ColoredSink::finish(const pipeline::PrintTotals& totals) {
    return meshes_.finish(totals);
}

}  // namespace openfab::boundary
