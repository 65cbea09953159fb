// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/ink_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "tools/color/messages.h"
#include "tools/color/nrrd_write.h"
#include "tools/texture/volume_reader.h"

namespace openfab::color {

namespace {

constexpr double kOne = 65535;

size_t index_of(int r, int g, int b) {
    return static_cast<size_t>((b * kInkTableNodes + g) * kInkTableNodes + r);
}

}  // namespace

Result<InkTable> InkTable::bake(const PrinterProfile& profile, const BakeOptions& options) {
    std::vector<Rgb> colours;
    constexpr double kLast = kInkTableNodes - 1;
    for (int b = 0; b < kInkTableNodes; ++b) {
        for (int g = 0; g < kInkTableNodes; ++g) {
            for (int r = 0; r < kInkTableNodes; ++r)
                colours.push_back({r / kLast, g / kLast, b / kLast});
        }
    }
    Result<std::vector<Inks>> inks = profile.to_inks(colours, options.intent, options.black_point);
    if (!inks) return inks.error();
    Excess excess;
    for (Inks& node : *inks) {
        const double sum = node[0] + node[1] + node[2] + node[3];
        constexpr double kRounding = 1e-4;
        if (sum > 1 + kRounding) excess.share += 1 / static_cast<double>(colours.size());
        excess.most = std::max(excess.most, sum);
        node = limited(node, options.limit);
        // As the file has it; downwards, so that the sum stays within the limit.
        for (double& ink : node)
            ink = std::floor(ink * kOne) / kOne;
    }
    InkTable table(std::move(*inks));
    table.excess_ = excess;
    return table;
}

Result<InkTable> InkTable::read(const std::filesystem::path& file) {
    const auto bad = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBefore, file.string()));
    };
    const tools::MadeReader reader = tools::open_nrrd(file, {}, {});
    if (!reader) return bad(reader.error());
    tools::VolumeReader& volume = **reader;
    const Vec3i& size = volume.size;
    if (volume.channels != 4 || size.x != kInkTableNodes || size.y != kInkTableNodes ||
        size.z != kInkTableNodes) {
        return bad(user_error(fmt::format(messages::kInkTableSides, size.x, size.y, size.z,
                                          volume.channels, kInkTableNodes),
                              messages::kInkTableHelp));
    }
    std::vector<Inks> nodes;
    std::vector<float> slice(static_cast<size_t>(volume.slice_floats()));
    for (int32_t z = 0; z < size.z; ++z) {
        if (Result<void> got = volume.read_slice(z, slice.data(), [](int64_t) {}); !got)
            return bad(got.error());
        for (size_t i = 0; i < slice.size(); i += 4) {
            Inks node;
            for (size_t c = 0; c < 4; ++c)
                node[c] = std::clamp(static_cast<double>(slice[i + c]), 0.0, 1.0);
            nodes.push_back(node);
        }
    }
    return InkTable(std::move(nodes));
}

Inks InkTable::at(const Rgb& colour) const {
    std::array<int, 3> cell{};
    std::array<double, 3> f{};
    for (size_t i = 0; i < 3; ++i) {
        const double place = std::clamp(colour[i], 0.0, 1.0) * (kInkTableNodes - 1);
        cell[i] = std::min(static_cast<int>(place), kInkTableNodes - 2);
        f[i] = place - cell[i];
    }
    std::array<size_t, 3> axes = {0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](size_t a, size_t b) { return f[a] > f[b]; });
    const Inks* before = &nodes_[index_of(cell[0], cell[1], cell[2])];
    Inks sum = *before;
    for (const size_t axis : axes) {
        ++cell[axis];
        const Inks& next = nodes_[index_of(cell[0], cell[1], cell[2])];
        for (size_t i = 0; i < sum.size(); ++i)
            sum[i] += (next[i] - (*before)[i]) * f[axis];
        before = &next;
    }
    return sum;
}

std::string InkTable::format(const std::string& description) const {
    std::vector<uint16_t> values;
    values.reserve(nodes_.size() * 4);
    for (const Inks& node : nodes_) {
        for (const double ink : node)
            values.push_back(static_cast<uint16_t>(std::lround(ink * kOne)));
    }
    return nrrd_of({kInkTableNodes, kInkTableNodes, kInkTableNodes}, 4, values, description);
}

}  // namespace openfab::color
