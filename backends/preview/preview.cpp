// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/preview/columns.h"
#include "backends/preview/messages.h"
#include "backends/preview/model_view.h"
#include "backends/preview/picture.h"
#include "base/color.h"

namespace openfab::preview {

namespace {

using pipeline::PrintInfo;
using pipeline::SliceView;

/// Colours of the codes in linear light; code 0 stays black and is never shown.
std::vector<std::array<double, 3>> linear_colors(const PrintInfo& info) {
    std::vector<std::array<double, 3>> colors(256);
    for (size_t m = 0; m < info.materials.size(); ++m) {
        for (size_t c = 0; c < 3; ++c)
            colors[m + 1][c] = srgb_to_linear(info.materials[m].preview[c] / 255.0);
    }
    return colors;
}

/// One pass of a 1 4 6 4 1 blur along x or y, over covered pixels.
void blur_heights(const Picture& picture, std::vector<float>* heights, int32_t dx, int32_t dy) {
    constexpr std::array<float, 5> kWeights{1, 4, 6, 4, 1};
    const std::vector<float> source = *heights;
    for (int32_t y = 0; y < picture.height; ++y) {
        for (int32_t x = 0; x < picture.width; ++x) {
            float sum = 0;
            float weights = 0;
            for (int32_t k = -2; k <= 2; ++k) {
                const int32_t u = x + k * dx;
                const int32_t v = y + k * dy;
                if (u < 0 || v < 0 || u >= picture.width || v >= picture.height) continue;
                const float weight = kWeights[k + 2] * picture.at(u, v).coverage;
                sum += weight * source[picture.index(u, v)];
                weights += weight;
            }
            if (weights > 0) (*heights)[picture.index(x, y)] = sum / weights;
        }
    }
}

/// Smooths the stair steps of slices from the heights: a step of one slice over one pixel would be
/// as steep as a roof.
std::vector<float> smooth_heights(const Picture& picture) {
    std::vector<float> heights(picture.pixels.size());
    for (size_t i = 0; i < heights.size(); ++i)
        heights[i] = picture.pixels[i].height_mm;
    for (int pass = 0; pass < 2; ++pass) {
        blur_heights(picture, &heights, 1, 0);
        blur_heights(picture, &heights, 0, 1);
    }
    return heights;
}

/// Lambert shading of the height field with a lamp at the upper left: level ground gets `flat`;
/// clamped to 1.
void shade(Picture* picture, double flat, double relief) {
    const double lamp[3]{-0.5, 0.6, 0.624};  // unit length
    const std::vector<float> heights = smooth_heights(*picture);
    // The height of a neighbour, or of the pixel itself where there is none: edges of the print are
    // not slopes.
    const auto height = [&](int32_t x, int32_t y, double self) -> double {
        if (x < 0 || y < 0 || x >= picture->width || y >= picture->height) return self;
        return picture->at(x, y).coverage > 0.5F ? heights[picture->index(x, y)] : self;
    };
    for (int32_t y = 0; y < picture->height; ++y) {
        for (int32_t x = 0; x < picture->width; ++x) {
            const double self = heights[picture->index(x, y)];
            const double span = 2 * picture->pixel_mm;
            const double dx = relief * (height(x + 1, y, self) - height(x - 1, y, self)) / span;
            const double dy = relief * (height(x, y - 1, self) - height(x, y + 1, self)) / span;
            const double lit =
                (-dx * lamp[0] - dy * lamp[1] + lamp[2]) / std::sqrt(dx * dx + dy * dy + 1);
            // A third of the light comes from everywhere, so that slopes away from the lamp keep
            // their colour.
            const double share = (0.5 + std::max(lit, 0.0) / lamp[2]) / 1.5;
            const auto factor = static_cast<float>(std::min(1.0, flat * share));
            for (float& c : picture->at(x, y).color)
                c *= factor;
        }
    }
}

/// Common base of the views: the grid, the colours, writing the file.
class Preview : public backends::SliceObserver {
  public:
    Preview(PreviewSpec spec, TakePicture take) : spec_(std::move(spec)), take_(std::move(take)) {}

    Result<void> begin(const PrintInfo& info) override {
        info_ = info;
        colors_ = linear_colors(info);
        grid_ = ColumnGrid::make(info.size);
        codes_.assign(padded(info.size.x), 0);
        row_.assign(padded(grid_.width), 0);
        return start();
    }

    Result<void> finish(const pipeline::PrintTotals&) override { return take_(draw()); }

  protected:
    virtual Result<void> start() = 0;
    virtual Picture draw() const = 0;

    /// Returns the codes of the sampled columns of row j.
    const PaddedRow& row_codes(const SliceView& slice, int32_t j) {
        backends::unpack_row(slice, grid_.y(j, info_.size), info_.bits, codes_.data());
        if (grid_.step == 1) return codes_;
        for (int32_t i = 0; i < grid_.width; ++i) {
            row_[i] = codes_[static_cast<size_t>(grid_.x(i, info_.size))];
        }
        return row_;
    }
    Pixel solid(uint8_t code) const {
        Pixel pixel;
        if (code == 0) return pixel;
        std::copy(colors_[code].begin(), colors_[code].end(), pixel.color);
        pixel.coverage = 1;
        return pixel;
    }
    std::array<double, 2> cell_mm() const {
        return {info_.pitch_mm.x * grid_.step, info_.pitch_mm.y * grid_.step};
    }
    /// Returns the column and row of the grid for cell (x, y) of a picture, top row first, mirrored
    /// for a view from behind.
    int32_t column(int32_t x, bool mirrored) const { return mirrored ? grid_.width - 1 - x : x; }
    int32_t row(int32_t y) const { return grid_.height - 1 - y; }

    PreviewSpec spec_;
    TakePicture take_;
    PrintInfo info_;
    ColumnGrid grid_;
    std::vector<std::array<double, 3>> colors_;
    PaddedRow codes_;
    PaddedRow row_;
};

/// A view that accumulates every slice, column by column.
template <typename Columns>
class ColumnPreview : public Preview {
  public:
    using Preview::Preview;

    void observe(const SliceView& slice) override {
        for (int32_t j = 0; j < grid_.height; ++j)
            columns_->add_row(slice.z, j, row_codes(slice, j));
    }

  protected:
    std::optional<Columns> columns_;
};

class LitPreview : public ColumnPreview<SightColumns> {
  public:
    using ColumnPreview::ColumnPreview;

  private:
    Result<void> start() override {
        columns_.emplace(grid_, info_.bits, spec_.view == View::kTop);
        return {};
    }

    Picture draw() const override {
        const bool back = spec_.view == View::kBottom;
        Picture picture = resample(grid_.width, grid_.height, cell_mm(), [&](int32_t x, int32_t y) {
            return seen(columns_->at(column(x, back), row(y)), back);
        });
        // The front shows a picture, so level ground keeps its colour; the back shows relief, which
        // needs room on both sides.
        shade(&picture, back ? 0.72 : 1.0, back ? 2.2 : 1.0);
        return picture;
    }

    Pixel seen(const Sight& sight, bool back) const {
        Pixel pixel;
        if (!sight.covered) return pixel;
        const double keep = kSightMm / (kSightMm + info_.pitch_mm.z);
        const auto deepest = static_cast<int32_t>(kSightEndMm / info_.pitch_mm.z + 0.5);
        const int32_t count = std::min(sight.count, std::max(deepest, 1));
        double weight = 1;
        double sum = 0;
        for (int32_t k = 0; k < count; ++k) {
            for (size_t c = 0; c < 3; ++c)
                pixel.color[c] += weight * colors_[sight.codes[k]][c];
            sum += weight;
            weight *= keep;
        }
        for (float& c : pixel.color)
            c /= sum;
        pixel.coverage = 1;
        pixel.height_mm = static_cast<float>((back ? -sight.z : sight.z) * info_.pitch_mm.z);
        return pixel;
    }
};

class TransmittedPreview : public ColumnPreview<ThicknessColumns> {
  public:
    using ColumnPreview::ColumnPreview;

  private:
    Result<void> start() override {
        columns_.emplace(grid_);
        return {};
    }

    Picture draw() const override {
        int32_t least = info_.size.z + 1;
        int32_t most = 0;
        for (int32_t j = 0; j < grid_.height; ++j) {
            for (int32_t x = 0; x < grid_.width; ++x) {
                const int32_t n = columns_->at(x, j);
                if (n == 0) continue;
                least = std::min(least, n);
                most = std::max(most, n);
            }
        }
        const double range = std::max(most - least, 1);
        return resample(grid_.width, grid_.height, cell_mm(), [&](int32_t x, int32_t y) {
            const int32_t n = columns_->at(column(x, spec_.view == View::kBottom), row(y));
            Pixel pixel;
            if (n == 0) return pixel;
            const double t = (n - least) / range;
            std::fill(std::begin(pixel.color), std::end(pixel.color), std::max(0.0, 1 - t * t));
            pixel.coverage = 1;
            return pixel;
        });
    }
};

class SlicePreview : public Preview {
  public:
    using Preview::Preview;

    void observe(const SliceView& slice) override {
        if (slice.z != spec_.slice) return;
        for (int32_t j = 0; j < grid_.height; ++j) {
            const PaddedRow& codes = row_codes(slice, j);
            std::copy_n(codes.begin(), grid_.width,
                        cells_.begin() + static_cast<std::ptrdiff_t>(cell(0, j)));
        }
    }

  private:
    Result<void> start() override {
        if (spec_.slice < info_.slice_begin || spec_.slice >= info_.slice_end) {
            return user_error(fmt::format(messages::kNoSuchSlice, spec_.file, spec_.slice,
                                          info_.slice_begin, info_.slice_end - 1));
        }
        cells_.assign(grid_.count(), 0);
        return {};
    }

    Picture draw() const override {
        return resample(grid_.width, grid_.height, cell_mm(),
                        [&](int32_t x, int32_t y) { return solid(cells_[cell(x, row(y))]); });
    }

    size_t cell(int32_t column, int32_t row) const {
        return static_cast<size_t>(row) * static_cast<size_t>(grid_.width) +
               static_cast<size_t>(column);
    }

    std::vector<uint8_t> cells_;  ///< lowest y first
};

class SectionPreview : public Preview {
  public:
    using Preview::Preview;

    void observe(const SliceView& slice) override {
        if ((slice.z - info_.slice_begin) % step_z_ != 0) return;
        const PaddedRow& codes = row_codes(slice, grid_.height / 2);
        rows_.insert(rows_.end(), codes.begin(), codes.begin() + grid_.width);
    }

  private:
    Result<void> start() override {
        // Twice the resolution of a picture is enough.
        constexpr int32_t kMaxRows = 4000;
        step_z_ = (info_.slice_end - info_.slice_begin) / kMaxRows + 1;
        rows_.clear();
        return {};
    }

    Picture draw() const override {
        const auto width = static_cast<size_t>(grid_.width);
        const auto height = static_cast<int32_t>(rows_.size() / width);
        // An interrupted print may have no slice yet; its picture is one empty row.
        return resample(
            grid_.width, std::max(height, 1), {cell_mm()[0], info_.pitch_mm.z * step_z_},
            [&](int32_t x, int32_t y) {
                if (height == 0) return Pixel{};
                return solid(
                    rows_[static_cast<size_t>(height - 1 - y) * width + static_cast<size_t>(x)]);
            });
    }

    int32_t step_z_ = 1;
    std::vector<uint8_t> rows_;  ///< lowest first
};

TakePicture write_to(const std::string& file) {
    return [file](const Picture& picture) -> Result<void> {
        const std::vector<uint8_t> png = to_png(picture);
        if (png.empty()) return outside_error(messages::kNoMemory + file);
        return backends::write_whole_file(file, png);
    };
}

}  // namespace

int64_t gathered_bytes(const PreviewSpec& spec) {
    return spec.view == View::kModel ? kModelBytes : kColumnBytes;
}

std::unique_ptr<backends::SliceObserver> make_preview(const PreviewSpec& spec, TakePicture take) {
    if (!take) take = write_to(spec.file);
    if (spec.transmitted) return std::make_unique<TransmittedPreview>(spec, std::move(take));
    switch (spec.view) {
        case View::kSection:
            return std::make_unique<SectionPreview>(spec, std::move(take));
        case View::kModel:
            return std::make_unique<ModelPreview>(spec, std::move(take));
        case View::kSlice:
            return std::make_unique<SlicePreview>(spec, std::move(take));
        case View::kTop:
        case View::kBottom:
            break;
    }
    return std::make_unique<LitPreview>(spec, std::move(take));
}

}  // namespace openfab::preview
