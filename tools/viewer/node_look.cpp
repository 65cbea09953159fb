// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/node_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/talking_program.h"
#include "base/vec.h"
#include "client/child.h"
#include "client/fablet_compiler.h"
#include "tools/viewer/look_picture.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/printed_values.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int kSide = 44;         ///< pixels of a slice's longer side
constexpr int kSurfaceSide = 32;  ///< and of a surface's
constexpr int kAlong = 96;        ///< places of a line
constexpr int kMostLines = 40'000;
constexpr int64_t kMostOutput = 256 << 20;
constexpr int64_t kMostWords = 4000;

std::string triple(const Vec3d& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v.x, v.y, v.z);
}

Vec3d size_mm(const pipeline::PrintInfo& print) {
    return {print.size.x * print.pitch_mm.x, print.size.y * print.pitch_mm.y,
            print.size.z * print.pitch_mm.z};
}

double longest(const Vec3d& v) {
    return std::max({v.x, v.y, v.z});
}

/// The pitch next to `pitch` of which a voxel has its centre at a place; of grids that begin at 0, as all do.
double pitch_through(double place, double pitch) {
    const double voxel = std::floor(place / pitch);
    // Near 0 voxels would become too small, or turn over.
    return voxel >= 1 || voxel <= -2 ? place / (voxel + 0.5) : pitch;
}

/// Whether the values are those of points of a surface, which come before all voxels.
bool is_surface_stage(const JsonValue& printed) {
    const JsonValue* found = member_of(printed, "surface");
    return found != nullptr && found->boolean;
}

}  // namespace

LookGrid grid_of(const Look& of) {
    const pipeline::PrintInfo& print = of.print;
    const Vec3d size = size_mm(print);
    LookGrid grid;
    grid.pitch_mm = print.pitch_mm;
    // Across an axis only the voxels about the point print.
    const auto thin = [&](int axis) {
        const double pitch = pitch_through(of.point_mm[axis], grid.pixel_mm);
        const double low = std::floor(of.point_mm[axis] / pitch) * pitch;
        grid.pitch_mm[axis] = pitch;
        grid.within_mm[static_cast<size_t>(axis)] = std::pair(low, low + pitch);
    };
    switch (of.over) {
        case LookOver::kVoxel:
            break;
        case LookOver::kSurface:
            grid.pixel_mm = grid.shell_mm = longest(size) / kSurfaceSide;
            grid.pitch_mm = {grid.pixel_mm, grid.pixel_mm, grid.pixel_mm};
            break;
        case LookOver::kLine: {
            grid.pixel_mm = longest(size) / kSide;
            for (int a = 0; a < 3; ++a) {
                if (a != of.axis) thin(a);
            }
            grid.pixel_mm = std::max(size[of.axis] / kAlong, print.pitch_mm[of.axis]);
            grid.pitch_mm[of.axis] = grid.pixel_mm;
            break;
        }
        case LookOver::kSlice: {
            Vec3d flat = size;
            flat[of.axis] = 0;
            grid.pixel_mm = longest(flat) / kSide;
            // Slices across z need not be found among others.
            grid.one_slice = of.axis == 2;
            for (int a = 0; a < 3; ++a) {
                if (a != of.axis) grid.pitch_mm[a] = grid.pixel_mm;
            }
            if (!grid.one_slice) thin(of.axis);
            break;
        }
    }
    return grid;
}

Result<std::string> NodeLooker::look(const Look& of, const JsonValue& printed) {
    const std::lock_guard lock(mutex_);
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
    if (!folder) return folder.error();
    const JsonValue* text = member_of(printed, "text");
    const Result<fs::path> source = client::put_source(
        (*folder)->path(), of.source, text == nullptr ? std::string() : text->text);
    if (!source) return source.error();
    std::vector<std::string> argv{(programs_ / "openflc").string(), "run", "--prints",
                                  fmt::format("--print-lines={}", kMostLines)};
    for (const fs::path& one : of.sources)
        argv.push_back(as_argument(one == of.source ? *source : one));
    argv.push_back(as_argument(fs::absolute(of.world)));
    argv.emplace_back("--progress=none");
    const LookGrid grid = grid_of(of);
    argv.push_back("--pitch=" + triple(grid.pitch_mm));
    if (of.over == LookOver::kVoxel) {
        argv.push_back("--probe=" + triple(of.point_mm));
    } else {
        argv.push_back("--output=" + ((*folder)->path() / "look.ofr").string());
    }
    if (grid.one_slice) {
        const double z = (of.point_mm.z - of.print.origin_mm.z) / of.print.pitch_mm.z;
        const auto slice = static_cast<int32_t>(std::clamp(z, 0.0, of.print.size.z - 1.0));
        argv.push_back(fmt::format("--slices={}:{}", slice, slice + 1));
    } else if (is_surface_stage(printed)) {
        argv.emplace_back("--slices=0:1");
    }
    for (const std::string& one : of.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& setting : of.settings)
        argv.push_back("--set=" + setting);
    const fs::path out = (*folder)->path() / "look.out";
    const fs::path err = (*folder)->path() / "look.err";
    for (const std::string& word : client::memory_words())
        argv.push_back(word);
    Result<std::unique_ptr<client::Child>> child = client::Child::start(argv, out, err);
    if (!child) return child.error();
    if ((*child)->wait() != 0) {
        const std::string words = client::end_of_file(err, kMostWords);
        const size_t error = words.find("error: ");
        return user_error(words.empty() ? messages::kRunFailed
                                        : words.substr(error == std::string::npos ? 0 : error));
    }
    PrintedValues read(printed);
    read.read(client::end_of_file(err, kMostOutput));
    const bool is_curve = of.over == LookOver::kLine;
    const bool is_picture = of.over == LookOver::kSlice || of.over == LookOver::kSurface;
    const std::vector<Vec3d> none;
    const LookPicture picture(is_picture ? read.places() : none, grid.pixel_mm,
                              of.over == LookOver::kSurface ? 3 : of.axis);
    const double step = grid.pixel_mm;
    const double begin = is_curve ? std::floor(of.print.origin_mm[of.axis] / step + 1e-6) : 0;
    const LookCurve curve(is_curve ? read.places() : none, of.axis, (begin + 0.5) * step,
                          is_curve ? step : 1, is_curve ? kAlong + 1 : 0);
    JsonText json;
    json.begin_object();
    if (is_picture) picture.write_frame(&json);
    if (is_curve) curve.write_frame(&json);
    json.key("materials");
    const JsonValue* materials = member_of(printed, "materials");
    materials == nullptr ? json.begin_array().end_array() : json.value(*materials);
    json.key("nodes").begin_array();
    for (const auto& [node, value] : read.values()) {
        if (value.at.empty()) continue;
        json.begin_object().member("node", node).member("type", value.type);
        json.member("numbers", static_cast<int64_t>(value.numbers));
        if (is_picture) picture.write(value, &json);
        if (is_curve) curve.write(value, &json);
        if (of.over == LookOver::kVoxel) write_voxel(value, &json);
        json.end_object();
    }
    json.end_array().end_object();
    return json.take();
}

}  // namespace openfab::viewer
