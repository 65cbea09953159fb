// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/print_inks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "backends/ofr/ofr_reader.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/color/messages.h"

namespace openfab::color {

namespace {

/// Calls use(slice) for each slice, from the bottom.
Result<void> each_slice(ofr::OfrReader* print,
                        const std::function<void(const pipeline::SliceView&)>& use) {
    for (;;) {
        const Result<bool> more = print->next();
        if (!more) return more.error();
        if (!*more) return {};
        use(print->slice());
    }
}

}  // namespace

Result<std::vector<int>> inks_of_codes(const pipeline::PrintInfo& info, const std::string& file) {
    std::vector<int> out(info.materials.size() + 1, -1);
    constexpr std::array<const char*, 4> kNames = {"cyan", "magenta", "yellow", "black"};
    for (size_t i = 0; i < kNames.size(); ++i) {
        bool found = false;
        for (size_t m = 0; m < info.materials.size(); ++m) {
            if (lower_ascii(info.materials[m].name).find(kNames[i]) == std::string::npos) continue;
            out[m + 1] = static_cast<int>(i);
            found = true;
        }
        if (!found) {
            return user_error(fmt::format(messages::kNoMaterialNamed, file, kNames[i]),
                              messages::kNoMaterialNamedHelp);
        }
    }
    return out;
}

Result<PrintTop> read_print_top(const std::string& file, double window_mm, double skin_mm,
                                int64_t memory_bytes) {
    Result<std::unique_ptr<ofr::OfrReader>> print = ofr::OfrReader::open(file);
    if (!print) return print.error();
    const pipeline::PrintInfo info = (*print)->info();
    const Result<std::vector<int>> inks = inks_of_codes(info, file);
    if (!inks) return inks.error();
    if (window_mm < std::max(info.pitch_mm.x, info.pitch_mm.y)) {
        return user_error(fmt::format(messages::kWindowTooSmall, window_mm, file, info.pitch_mm.x,
                                      info.pitch_mm.y),
                          messages::kWindowTooSmallHelp);
    }
    const auto windows_along = [&](int32_t voxels, double pitch) {
        return std::max(1, static_cast<int>(std::lround(voxels * pitch / window_mm)));
    };
    PrintTop out;
    out.width = windows_along(info.size.x, info.pitch_mm.x);
    out.height = windows_along(info.size.y, info.pitch_mm.y);
    const size_t area = static_cast<size_t>(info.size.x) * static_cast<size_t>(info.size.y);
    const size_t windows = static_cast<size_t>(out.width) * static_cast<size_t>(out.height);
    using Counts = std::array<int64_t, 5>;  // the last: of what is no ink
    const size_t bytes = area * sizeof(int32_t) + windows * (sizeof(Counts) + sizeof(Inks));
    if (bytes > static_cast<size_t>(memory_bytes)) {
        return user_error(
            fmt::format(messages::kAreaTakes, file, format_bytes(static_cast<int64_t>(bytes)),
                        format_bytes(memory_bytes)),
            messages::kAreaTakesHelp);
    }
    std::vector<bool> is_seen(inks->size(), true);
    is_seen[0] = false;
    for (size_t m = 0; m < info.materials.size(); ++m) {
        if (lower_ascii(info.materials[m].name).find("clear") != std::string::npos)
            is_seen[m + 1] = false;
    }
    if (info.support_code > 0 && static_cast<size_t>(info.support_code) < is_seen.size())
        is_seen[static_cast<size_t>(info.support_code)] = false;
    // Slices come from the bottom: the first pass finds the top, the second one what lies below it.
    std::vector<int32_t> top(area, -1);
    const auto each_voxel = [&](const pipeline::SliceView& slice, const auto& use) {
        size_t column = 0;
        for (int32_t y = 0; y < slice.height; ++y) {
            for (int32_t x = 0; x < slice.width; ++x, ++column) {
                const uint8_t code = slice.code(x, y, info.bits);
                if (code >= is_seen.size() || !is_seen[code]) continue;
                use(column, x, y, code);
            }
        }
    };
    Result<void> read = each_slice(print->get(), [&](const pipeline::SliceView& slice) {
        each_voxel(slice, [&](size_t column, int32_t, int32_t, uint8_t) { top[column] = slice.z; });
    });
    if (!read) return read.error();
    std::vector<Counts> counts(windows);
    const auto layers = std::max(1, static_cast<int32_t>(std::lround(skin_mm / info.pitch_mm.z)));
    const auto window_of = [](int32_t voxel, int32_t size, int along) {
        return static_cast<size_t>(int64_t{voxel} * along / size);
    };
    print = ofr::OfrReader::open(file);
    if (!print) return print.error();
    read = each_slice(print->get(), [&](const pipeline::SliceView& slice) {
        each_voxel(slice, [&](size_t column, int32_t x, int32_t y, uint8_t code) {
            if (slice.z <= top[column] - layers) return;
            const size_t row =
                static_cast<size_t>(out.height) - 1 - window_of(y, info.size.y, out.height);
            const size_t window =
                row * static_cast<size_t>(out.width) + window_of(x, info.size.x, out.width);
            const int ink = (*inks)[code];
            ++counts[window][static_cast<size_t>(ink < 0 ? 4 : ink)];
        });
    });
    if (!read) return read.error();
    for (const Counts& window : counts) {
        int64_t all = 0;
        for (const int64_t count : window)
            all += count;
        Inks& shares = out.windows.emplace_back(Inks{});
        out.is_there.push_back(all > 0);
        for (size_t i = 0; all > 0 && i < shares.size(); ++i)
            shares[i] = static_cast<double>(window[i]) / static_cast<double>(all);
    }
    return out;
}

}  // namespace openfab::color
