// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/check_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "client/child.h"
#include "client/members.h"
#include "client/print_words.h"
#include "program/progress.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Shows how far a print is, once it turns out to take long.
class Watch {
  public:
    explicit Watch(fs::path file) : file_(std::move(file)) {}
    ~Watch() { progress_.end(); }

    void look() {
        using Clock = std::chrono::steady_clock;
        constexpr std::chrono::milliseconds kLong{2000}, kOften{250};
        const Clock::time_point now = Clock::now();
        if (now - began_ < kLong || now - looked_ < kOften) return;
        looked_ = now;
        pipeline::ProgressEvent last;
        constexpr int64_t kMost = 1000;
        if (const auto event = client::last_progress(client::end_of_file(file_, kMost))) {
            last.slices_done = static_cast<int32_t>(client::number_member(*event, "slices_done"));
            last.slices_total = static_cast<int32_t>(client::number_member(*event, "slices_total"));
            last.voxels_done = static_cast<int64_t>(client::number_member(*event, "voxels_done"));
            last.voxels_total = static_cast<int64_t>(client::number_member(*event, "voxels_total"));
            last.seconds = client::number_member(*event, "seconds");
        }
        if (last.slices_done > 0) progress_.update(last);
    }

  private:
    fs::path file_;
    program::Progress progress_{program::ProgressMode::kAuto, stderr};
    std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now(), looked_;
};

}  // namespace

Grid grid_of(const pipeline::PrintInfo& info, int32_t parts) {
    return {{info.size.x, info.size.y, info.slice_end - info.slice_begin}, info.pitch_mm, parts};
}

Grid coarser(const Grid& grid, double larger) {
    Grid out{{}, grid.pitch_mm * larger, grid.parts};
    for (int axis = 0; axis < 3; ++axis)
        out.size[axis] = static_cast<int32_t>(std::ceil(grid.size[axis] / larger));
    return out;
}

Result<CheckedPrint> read_print(ofr::OfrReader* reader, int32_t parts) {
    CheckedPrint print;
    print.info = reader->info();
    print.parts = parts;
    const Vec3i size = grid_of(print.info, parts).size;
    print.codes = inspection::Box<uint8_t>({size.x + 2, size.y + 2, size.z + 2});
    for (int32_t z = 0;; ++z) {
        const Result<bool> more = reader->next();
        if (!more) return more.error();
        if (!*more) break;
        const pipeline::SliceView& slice = reader->slice();
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x)
                print.codes.values[print.codes.at(x + 1, y + 1, z + 1)] =
                    slice.code(x, y, print.info.bits);
        }
    }
    return print;
}

Result<std::optional<Grid>> print_for_check(const std::vector<std::string>& argv,
                                            const fs::path& file, int32_t parts, int64_t memory,
                                            const std::function<bool(const Grid&)>& takes) {
    const fs::path out = fs::path(file).replace_extension(".out");
    const fs::path err = fs::path(file).replace_extension(".err");
    std::error_code ignored;
    fs::remove(file, ignored);
    auto child = client::Child::start(argv, out, err);
    if (!child) return child.error();
    Watch watch(err);
    std::optional<Grid> grid;
    const auto grid_is_taken = [&] {
        if (grid || !fs::exists(file, ignored)) return true;
        const auto reader = ofr::OfrReader::open(file.string(), memory);
        if (!reader) return true;  // not yet
        grid = grid_of((*reader)->info(), parts);
        return takes(*grid);
    };
    std::chrono::milliseconds pause{2};
    while (!(*child)->exit_code()) {
        if (!grid_is_taken()) return grid;
        watch.look();
        std::this_thread::sleep_for(pause);
        constexpr std::chrono::milliseconds kLongest{50};
        pause = std::min(2 * pause, kLongest);
    }
    const int code = (*child)->wait();
    constexpr int64_t kMost = 20000;
    if (code != 0) return client::print_error(client::end_of_file(err, kMost), code);
    if (!grid_is_taken()) return grid;
    return std::optional<Grid>();
}

}  // namespace openfab::tools
