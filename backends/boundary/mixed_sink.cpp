// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/mixed_sink.h"

#include <fmt/format.h>

#include <utility>

#include "backends/boundary/messages.h"
#include "backends/common/tee_sink.h"

namespace openfab::boundary {

int64_t mixed_bytes_per_column(int32_t slices) {
    return (int64_t{slices} + 1) * int64_t{sizeof(Quarters)} + 1;
}

MixedSink::MixedSink(const std::filesystem::path& path, backends::MixtureInlet* inlet)
    : meshes_(make_mixed_writer(path, &mixtures_)) {
    inlet->set_output(&planes_);
}

Result<void> MixedSink::begin(const pipeline::PrintInfo& info) {
    if (info.materials.size() > kMostFilaments)
        return user_error(
            fmt::format(messages::kTooManyFilaments, info.materials.size(), kMostFilaments));
    info_ = info;
    mixtures_.begin(info.materials);
    pipeline::PrintInfo all = info;
    all.bits = 8;
    all.materials.resize(kMostFilaments);
    return meshes_.begin(all);
}

std::vector<uint8_t> MixedSink::encode(const pipeline::SliceView& slice) const {
    return backends::unpack_slice(slice, info_.bits);
}

Result<void> MixedSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    std::vector<Quarters> mixed = planes_.take(z);
    mixed.resize(bytes.size());
    for (size_t i = 0; i < bytes.size(); ++i) {
        // What the fablet has as void is support, or the substitute of another machine's part.
        if (bytes[i] == 0 || bytes[i] == info_.support_code || mixed[i] == 0) continue;
        bytes[i] = mixtures_.number(mixed[i]);
        if (bytes[i] != 0) continue;
        broken_ = true;
        return user_error(
            fmt::format(messages::kTooManyMixtures, kMostFilaments, mixtures_.filaments()),
            messages::kTooManyMixturesHelp);
    }
    return meshes_.commit(z, std::move(bytes));
}

Result<void> MixedSink::finish(const pipeline::PrintTotals& totals) {
    if (broken_) return {};  // reported already
    return meshes_.finish(totals);
}

}  // namespace openfab::boundary
