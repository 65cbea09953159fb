// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/split_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "base/say.h"
#include "base/text.h"
#include "texture/pyramid.h"
#include "texture/volume.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

using Key = std::array<int32_t, 3>;

/// Colours of a print's surface, as means over cells: mixtures are dithered.
struct SurfaceColours {
    struct Mean {
        Vec3d sum;
        double count = 0;
    };
    Vec3d origin_mm;
    double cell_mm = 1;
    std::map<Key, Mean> cells;

    Key key(const Vec3d& p) const {
        Key out;
        for (int a = 0; a < 3; ++a)
            out[static_cast<size_t>(a)] =
                static_cast<int32_t>(std::floor((p[a] - origin_mm[a]) / cell_mm));
        return out;
    }

    /// Returns the largest difference of colours on two sides of a point, 0 to 1: most on the edge itself.
    double contrast(const Vec3d& p) const {
        constexpr int32_t kReach = 2;
        const Key middle = key(p);
        std::array<std::array<Mean, 2>, 3> sides;
        for (int32_t z = -kReach; z <= kReach; ++z) {
            for (int32_t y = -kReach; y <= kReach; ++y) {
                for (int32_t x = -kReach; x <= kReach; ++x) {
                    const auto at = cells.find({middle[0] + x, middle[1] + y, middle[2] + z});
                    if (at == cells.end()) continue;
                    const Vec3i step{x, y, z};
                    for (int a = 0; a < 3; ++a) {
                        if (step[a] == 0) continue;
                        Mean& side = sides[static_cast<size_t>(a)][step[a] > 0 ? 1 : 0];
                        side.sum = side.sum + at->second.sum;
                        side.count += at->second.count;
                    }
                }
            }
        }
        double most = 0;
        for (const auto& [low, high] : sides) {
            if (low.count == 0 || high.count == 0) continue;
            const Vec3d d = high.sum * (1 / high.count) - low.sum * (1 / low.count);
            most = std::max({most, std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
        }
        return most;
    }
};

/// Adds the surface of the middle one of three slices.
class SurfaceReader {
  public:
    SurfaceReader(const pipeline::PrintInfo& info, SurfaceColours* out) : info_(info), out_(*out) {
        for (const pipeline::SliceMaterial& material : info.materials) {
            constexpr double kWhole = 255;
            const auto& rgba = material.preview;
            colours_.push_back({rgba[0] / kWhole, rgba[1] / kWhole, rgba[2] / kWhole});
        }
    }

    void add(const std::vector<uint8_t>& below, const std::vector<uint8_t>& here,
             const std::vector<uint8_t>& above, int32_t z) {
        const Vec3i& size = info_.size;
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const auto at =
                    static_cast<size_t>(y) * static_cast<size_t>(size.x) + static_cast<size_t>(x);
                if (!solid(here[at])) continue;
                const auto side = [&](int32_t i, int32_t j) {
                    return i >= 0 && j >= 0 && i < size.x && j < size.y &&
                           solid(here[static_cast<size_t>(j) * static_cast<size_t>(size.x) +
                                      static_cast<size_t>(i)]);
                };
                if (side(x - 1, y) && side(x + 1, y) && side(x, y - 1) && side(x, y + 1) &&
                    solid(below[at]) && solid(above[at]))
                    continue;
                const Vec3d p{info_.origin_mm.x + (x + 0.5) * info_.pitch_mm.x,
                              info_.origin_mm.y + (y + 0.5) * info_.pitch_mm.y,
                              info_.origin_mm.z + (z + 0.5) * info_.pitch_mm.z};
                SurfaceColours::Mean& mean = out_.cells[out_.key(p)];
                mean.sum = mean.sum + colours_[here[at] - size_t{1}];
                mean.count += 1;
            }
        }
    }

  private:
    bool solid(uint8_t code) const {
        return code != 0 && code != static_cast<uint8_t>(info_.support_code);
    }

    const pipeline::PrintInfo& info_;
    SurfaceColours& out_;
    std::vector<Vec3d> colours_;
};

}  // namespace

Result<AtPoint> seam_by_colours(const std::string& print, const Affine3d& to_build,
                                int64_t memory) {
    auto reader = ofr::OfrReader::open(print, memory);
    if (!reader) return reader.error();
    const pipeline::PrintInfo info = (*reader)->info();
    auto colours = std::make_shared<SurfaceColours>();
    colours->origin_mm = info.origin_mm;
    constexpr double kCells = 96;
    const Vec3d box{info.size.x * info.pitch_mm.x, info.size.y * info.pitch_mm.y,
                    info.size.z * info.pitch_mm.z};
    colours->cell_mm = std::max({box.x / kCells, box.y / kCells, box.z / kCells,
                                 2 * info.pitch_mm.x, 2 * info.pitch_mm.y, 2 * info.pitch_mm.z});
    SurfaceReader surface(info, colours.get());
    const size_t voxels = static_cast<size_t>(info.size.x) * static_cast<size_t>(info.size.y);
    std::array<std::vector<uint8_t>, 3> slices;
    for (std::vector<uint8_t>& slice : slices)
        slice.assign(voxels, 0);
    for (int32_t z = info.slice_begin;; ++z) {
        const Result<bool> more = (*reader)->next();
        if (!more) return more.error();
        std::rotate(slices.begin(), slices.begin() + 1, slices.end());
        std::fill(slices[2].begin(), slices[2].end(), 0);
        for (int32_t y = 0; *more && y < info.size.y; ++y) {
            for (int32_t x = 0; x < info.size.x; ++x)
                slices[2][static_cast<size_t>(y) * static_cast<size_t>(info.size.x) +
                          static_cast<size_t>(x)] = (*reader)->slice().code(x, y, info.bits);
        }
        if (z > info.slice_begin) surface.add(slices[0], slices[1], slices[2], z - 1);
        if (!*more) break;
    }
    return AtPoint([colours, to_build](const Vec3d& p) {
        constexpr double kSteep = 4;
        return 1 / (1 + kSteep * colours->contrast(to_build.apply(p)));
    });
}

Result<AtPoint> stress_of(const std::string& volume, const Affine3d& to_build, int64_t memory) {
    texture::VolumeOptions options;
    options.image.space = "data";
    std::string file = volume;
    std::error_code ignored;
    if (const size_t colon = volume.rfind(':');
        colon != std::string::npos && !std::filesystem::exists(volume, ignored)) {
        file = volume.substr(0, colon);
        options.field = volume.substr(colon + 1);
    } else if (file.ends_with(".vti")) {
        options.field = "von_mises_MPa";  // as `openfab mechanics part` calls it
    }
    constexpr int32_t kClamp = 0;
    const auto pyramid =
        texture::get_volume(file, options, kClamp, texture::kFilterTrilinear, {memory, {}});
    if (!pyramid) return with_context(pyramid.error(), "--stress: ");
    const std::shared_ptr<const texture::Pyramid> held = *pyramid;
    for (const std::string& told : held->notes())
        note("--stress: " + told);
    if (held->channels() != 1) {
        return user_error(
            fmt::format(messages::kStressNumbers, printable(volume), held->channels()),
            messages::kStressNumbersHelp);
    }
    const std::span<const int32_t> info = held->info();
    std::array<float, 6> box;  // the lowest corner, and the size
    std::memcpy(box.data(), info.data() + texture::kInfoHeader, sizeof box);
    const int32_t* level = info.data() + texture::kVolumeInfoHeader;
    const Vec3i cells{level[1], level[2], level[3]};
    const auto first = static_cast<size_t>(level[0]);
    return AtPoint([held, box, cells, first, to_build](const Vec3d& p) {
        const Vec3d at = to_build.apply(p);
        Vec3i i;
        for (int a = 0; a < 3; ++a) {
            const auto axis = static_cast<size_t>(a);
            const double place = (at[a] - double{box[axis]}) / double{box[axis + 3]} * cells[a];
            if (!(place >= 0 && place < cells[a])) return 0.0;
            i[a] = static_cast<int32_t>(place);
        }
        const size_t texel =
            (static_cast<size_t>(i.z) * static_cast<size_t>(cells.y) + static_cast<size_t>(i.y)) *
                static_cast<size_t>(cells.x) +
            static_cast<size_t>(i.x);
        const auto value = static_cast<double>(held->texels()[first + texel]);
        return std::isfinite(value) ? value : 0.0;
    });
}

}  // namespace openfab::tools
