// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "backends/raster/png_encode.h"
#include "tools/openfab/check_findings.h"

namespace openfab::tools {

namespace {

using Color = std::array<uint8_t, 3>;

constexpr int32_t kGap = 12;       // pixels between views
constexpr int32_t kLongest = 900;  // of a view
constexpr int32_t kMark = 2;       // pixels around a place, so that single voxels are seen
constexpr Color kPaper{255, 255, 255};

Color color_of(Fault fault) {
    switch (fault) {
        case Fault::kWall:
            return {214, 39, 40};
        case Fault::kGap:
            return {31, 119, 180};
        case Fault::kHole:
            return {23, 160, 207};
        case Fault::kIsland:
            return {255, 127, 14};
        case Fault::kTrappedVoid:
            return {148, 103, 189};
        case Fault::kTrappedSupport:
            return {227, 119, 194};
        case Fault::kTouch:
            return {44, 160, 44};
    }
    return {};
}

/// A projection along one axis.
struct View {
    int32_t right, up, depth;  ///< axes
    int32_t left, width, height;
    double scale;  ///< pixels a mm
};

class Picture {
  public:
    explicit Picture(const CheckedPrint& print) : print_(print) {
        const Vec3d& pitch = print.info.pitch_mm;
        const Vec3i& size = print.codes.size;
        double longest = 0;
        for (int axis = 0; axis < 3; ++axis)
            longest = std::max(longest, size[axis] * pitch[axis]);
        const double scale = std::min(kLongest / longest, 4 / std::min(pitch.x, pitch.y));
        int32_t left = kGap;
        for (const auto& [right, up, depth] :
             {std::array{0, 2, 1}, std::array{1, 2, 0}, std::array{0, 1, 2}}) {
            View view{right, up, depth, left, 0, 0, scale};
            view.width = std::max(1, static_cast<int32_t>(size[right] * pitch[right] * scale));
            view.height = std::max(1, static_cast<int32_t>(size[up] * pitch[up] * scale));
            left += view.width + kGap;
            height_ = std::max(height_, view.height + 2 * kGap);
            views_.push_back(view);
        }
        width_ = left;
        pixels_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), kPaper);
        for (const View& view : views_)
            draw(view);
    }

    void mark(const Vec3i& voxel, const Color& color) {
        for (const View& view : views_) {
            const Vec3d& pitch = print_.info.pitch_mm;
            const auto x =
                static_cast<int32_t>((voxel[view.right] + 0.5) * pitch[view.right] * view.scale);
            const auto y =
                static_cast<int32_t>((voxel[view.up] + 0.5) * pitch[view.up] * view.scale);
            for (int32_t j = y - kMark; j <= y + kMark; ++j) {
                for (int32_t i = x - kMark; i <= x + kMark; ++i)
                    put(view, i, j, color);
            }
        }
    }

    std::vector<uint8_t> encode() const {
        raster::PngImage image;
        image.width = width_;
        image.height = height_;
        image.color = raster::PngColor::kRgb;
        image.text = "OpenFab";
        return raster::encode_png_rows(image, [&](int32_t y, uint8_t* row) {
            for (int32_t x = 0; x < width_; ++x) {
                const Color& color = pixels_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                                             static_cast<size_t>(x)];
                std::copy(color.begin(), color.end(), row + 3 * x);
            }
        });
    }

  private:
    void put(const View& view, int32_t x, int32_t y, const Color& color) {
        const int32_t row = height_ - kGap - 1 - y, column = view.left + x;
        if (row < 0 || row >= height_ || column < 0 || column >= width_) return;
        pixels_[static_cast<size_t>(row) * static_cast<size_t>(width_) +
                static_cast<size_t>(column)] = color;
    }

    /// Darker where more is behind a pixel.
    void draw(const View& view) {
        const inspection::Box<uint8_t>& codes = print_.codes;
        const Vec3d& pitch = print_.info.pitch_mm;
        for (int32_t y = 0; y < view.height; ++y) {
            for (int32_t x = 0; x < view.width; ++x) {
                Vec3i p;
                p[view.right] =
                    std::min(static_cast<int32_t>((x + 0.5) / view.scale / pitch[view.right]),
                             codes.size[view.right] - 1);
                p[view.up] = std::min(static_cast<int32_t>((y + 0.5) / view.scale / pitch[view.up]),
                                      codes.size[view.up] - 1);
                int32_t count = 0;
                for (p[view.depth] = 0; p[view.depth] < codes.size[view.depth]; ++p[view.depth])
                    count += codes.values[codes.at(p.x, p.y, p.z)] != 0 ? 1 : 0;
                if (count == 0) continue;
                const double share = static_cast<double>(count) / codes.size[view.depth];
                const auto grey = static_cast<uint8_t>(225 - 110 * std::sqrt(share));
                put(view, x, y, {grey, grey, grey});
            }
        }
    }

    const CheckedPrint& print_;
    std::vector<View> views_;
    int32_t width_ = 0, height_ = 0;
    std::vector<Color> pixels_;
};

}  // namespace

std::vector<uint8_t> picture_of(const CheckedPrint& print, const std::vector<Finding>& findings) {
    Picture picture(print);
    for (const Finding& finding : findings) {
        for (const Vec3i& voxel : finding.voxels)
            picture.mark(voxel, color_of(finding.fault));
    }
    return picture.encode();
}

}  // namespace openfab::tools
