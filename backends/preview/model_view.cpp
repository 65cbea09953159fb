// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/model_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/preview/preview.h"
#include "base/color.h"
#include "base/rotation.h"

namespace openfab::preview {

namespace {

/// Cells in a layer, and pixels, at most.
constexpr int64_t kMaxCells = 300'000;
constexpr double kMaxPixels = 1.5e6;
constexpr double kMinPixels = 2.5e5;
/// Half of the light over kSightMm.
constexpr double kOpaquePerMm = 0.6931 / kSightMm;
/// An opaque cell among such cells, or one that is wider than kSightMm, lets exp(-kHiding) of the
/// light through: colours mix over some depth at a surface, and what a skin covers is not seen.
constexpr double kHiding = 6;
/// The density from which on a cell is opaque throughout.
constexpr float kFull = 0.995F;

Vec3d unit(Vec3d v) {
    return v * (1 / length(v));
}

/// Blur by 1 4 6 4 1, and the slope of the result. Towards `away` (1, -1, or 0 for neither) no
/// position counts for less than the one before it: cells behind dense ones are not visible, and
/// must not bend the surface that hides it.
float binomial(const float* p, ptrdiff_t step, int32_t away) {
    float low = p[-2 * step], high = p[2 * step];
    if (away < 0) low = std::max(low, p[-step]);
    if (away > 0) high = std::max(high, p[step]);
    return (low + high + 4 * (p[-step] + p[step]) + 6 * p[0]) * (1.0F / 16);
}

float slope(const float* p, ptrdiff_t step, int32_t away) {
    const auto side = [&](ptrdiff_t by, bool hidden) {
        const float one = p[by];
        const float two = hidden ? std::max(p[2 * by], one) : p[2 * by];
        const float three = hidden ? std::max(p[3 * by], two) : p[3 * by];
        return 5 * one + 4 * two + three;
    };
    return (side(step, away > 0) - side(-step, away < 0)) * (1.0F / 16);
}

/// 1 - exp(-x) for x >= 0, to 2 %, by the exponential's series.
float absorbed(float x) {
    return 1 - 1 / (1 + x * (1 + x * (0.5F + x * (1.0F / 6 + x * (1.0F / 24)))));
}

}  // namespace

ModelPreview::ModelPreview(PreviewSpec spec, TakePicture take)
    : spec_(std::move(spec)), take_(std::move(take)) {}

Result<void> ModelPreview::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    by_code_.assign(256, {});
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const auto& preview = info.materials[m].preview;
        const double alpha = preview[3] / 255.0;
        Material& cell = by_code_[m + 1];
        const double strength =
            alpha < 0.8 ? std::min(alpha / (1 - alpha), kOpaquePerMm) : kOpaquePerMm;
        for (size_t c = 0; c < 3; ++c) {
            const double color = srgb_to_linear(preview[c] / 255.0);
            cell.color[c] = static_cast<float>(color * strength);
            cell.extinction[c] =
                static_cast<float>(strength * (1 + 20 * (1 - alpha) * (1 - color)));
        }
        cell.density = static_cast<float>(0.3 + 0.7 * alpha);
    }
    const Vec3d pitch = info.pitch_mm;
    const int32_t slices = info.slice_end - info.slice_begin;
    // Cells as near to cubes as whole voxels allow, larger ones where there would be too many.
    for (double side = std::max({pitch.x, pitch.y, pitch.z});; side *= 1.1) {
        for (int a = 0; a < 3; ++a) {
            step_[a] = std::max(1, static_cast<int32_t>(side / pitch[a] + 0.5));
            count_[a] = ((a == 2 ? slices : info.size[a]) + step_[a] - 1) / step_[a];
            cell_mm_[a] = pitch[a] * step_[a];
        }
        if (static_cast<int64_t>(count_.x) * count_.y <= kMaxCells) break;
    }
    const SinCos turn = sin_cos_degrees(spec_.turn_deg);
    const SinCos tilt = sin_cos_degrees(spec_.tilt_deg);
    right_ = {turn.cos, turn.sin, 0};
    viewer_ = {turn.sin * tilt.cos, 0 - turn.cos * tilt.cos, tilt.sin};
    up_ = cross(viewer_, right_);
    away_x_ = viewer_.x > 0 ? -1 : viewer_.x < 0 ? 1 : 0;
    away_y_ = viewer_.y > 0 ? -1 : viewer_.y < 0 ? 1 : 0;
    lamp_ = unit(right_ * -0.5 + up_ * 0.6 + viewer_ * 0.8);
    double high_a = -1e30;
    double high_b = -1e30;
    low_a_ = low_b_ = 1e30;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
            p[a] = ((corner >> a) & 1) != 0 ? count_[a] * cell_mm_[a] : 0.0;
        low_a_ = std::min(low_a_, dot(p, right_));
        high_a = std::max(high_a, dot(p, right_));
        low_b_ = std::min(low_b_, dot(p, up_));
        high_b = std::max(high_b, dot(p, up_));
    }
    const double area = (high_a - low_a_) * (high_b - low_b_);
    // Cells are blended between, so pixels finer than cells are smooth: coarse drafts fill a screen
    // too.
    pixel_mm_ = std::min(0.8 * std::min(cell_mm_.x, cell_mm_.y), std::sqrt(area / kMinPixels));
    pixel_mm_ = std::max(pixel_mm_, std::sqrt(area / kMaxPixels));
    width_ = std::max(1, static_cast<int32_t>(std::ceil((high_a - low_a_) / pixel_mm_)));
    height_ = std::max(1, static_cast<int32_t>(std::ceil((high_b - low_b_) / pixel_mm_)));
    painted_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), {});
    stride_ = static_cast<size_t>(count_.x) + 2 * kRim;
    for (Layer& layer : layers_) {
        layer.cells.assign(stride_ * (static_cast<size_t>(count_.y) + 2 * kRim), {});
        layer.density.assign(layer.cells.size(), 0);
        for (std::vector<float>* blurred : {&layer.along_x, &layer.along_y, &layer.smooth})
            blurred->assign(layer.cells.size(), 0);
    }
    codes_.assign(static_cast<size_t>(info.size.x), 0);
    return {};
}

/// Returns whether a cell lies in the half, or for xy the quarter, that faces the viewer.
bool ModelPreview::cut_away(int32_t x, int32_t y) const {
    const bool in_x = viewer_.x >= 0 ? 2 * x >= info_.size.x : 2 * x < info_.size.x;
    const bool in_y = viewer_.y > 0 ? 2 * y >= info_.size.y : 2 * y < info_.size.y;
    switch (spec_.cut) {
        case Cut::kX:
            return in_x;
        case Cut::kY:
            return in_y;
        case Cut::kXY:
            return in_x && in_y;
        case Cut::kNone:
            break;
    }
    return false;
}

void ModelPreview::observe(const pipeline::SliceView& slice) {
    Layer& layer = this->layer(open_);
    const float share = 1.0F / static_cast<float>(step_.x * step_.y * step_.z);
    for (int32_t y = 0; y < info_.size.y; ++y) {
        backends::unpack_row(slice, y, info_.bits, codes_.data());
        Cell* row = &layer.cells[index(0, y / step_.y)];
        float* density = &layer.density[index(0, y / step_.y)];
        bool any = false;
        for (int32_t x = 0; x < info_.size.x; ++x) {
            const uint8_t code = codes_[x];
            if (code == 0 || cut_away(x, y)) continue;
            any = true;
            Cell& cell = row[x / step_.x];
            const Material& add = by_code_[code];
            for (size_t c = 0; c < 3; ++c) {
                cell.color[c] += add.color[c] * share;
                cell.extinction[c] += add.extinction[c] * share;
            }
            density[x / step_.x] += add.density * share;
        }
        if (!any) continue;
        if (layer.last_row < layer.first_row) layer.first_row = y / step_.y;
        layer.last_row = y / step_.y;
    }
    if (++gathered_ == step_.z) close_layer();
}

/// Layer k needs the densities of two layers on each side, so it is lit and painted two layers
/// later.
void ModelPreview::close_layer() {
    blur(&layer(open_));
    gathered_ = 0;
    if (open_ >= 2) {
        light(open_ - 2);
        paint(open_ - 2);
    }
    ++open_;
    Layer& next = layer(open_);
    std::fill(next.cells.begin(), next.cells.end(), Cell{});
    std::fill(next.density.begin(), next.density.end(), 0.0F);
    for (std::vector<float>* blurred : {&next.along_x, &next.along_y, &next.smooth})
        std::fill(blurred->begin(), blurred->end(), 0.0F);
    next.first_row = 0;
    next.last_row = -1;
}

/// Along x, along y, and both.
void ModelPreview::blur(Layer* layer) {
    if (layer->last_row < layer->first_row) return;
    const int32_t first = std::max(layer->first_row - kRim, 0);
    const int32_t last = std::min(layer->last_row + kRim, count_.y - 1);
    const auto stride = static_cast<ptrdiff_t>(stride_);
    for (int32_t y = first - kRim; y <= last + kRim; ++y) {
        for (int32_t x = 0; x < count_.x; ++x)
            layer->along_x[index(x, y)] = binomial(&layer->density[index(x, y)], 1, away_x_);
    }
    for (int32_t y = first; y <= last; ++y) {
        for (int32_t x = 0; x < count_.x; ++x) {
            const size_t i = index(x, y);
            layer->along_y[i] = binomial(&layer->density[i], stride, away_y_);
            layer->smooth[i] = binomial(&layer->along_x[i], stride, away_y_);
        }
    }
}

/// Returns whether an opaque cell has opaque ones on all six sides.
bool ModelPreview::is_amid_opaque(int32_t k, size_t i) {
    const std::vector<float>& d = layer(k).density;
    return std::min({d[i - 1], d[i + 1], d[i - stride_], d[i + stride_], layer(k - 1).density[i],
                     layer(k + 1).density[i]}) > kFull;
}

/// Shades the boundaries of a layer; interior cells keep their colour, and opaque ones hide what is
/// behind them.
void ModelPreview::light(int32_t k) {
    Layer& self = layer(k);
    const double width = std::min({cell_mm_.x, cell_mm_.y, cell_mm_.z});
    const auto hiding = static_cast<float>(std::max(1.0, kHiding / (kOpaquePerMm * width)));
    const auto stride = static_cast<ptrdiff_t>(stride_);
    for (int32_t y = self.first_row; y <= self.last_row; ++y) {
        for (int32_t x = 0; x < count_.x; ++x) {
            const size_t i = index(x, y);
            Cell& cell = self.cells[i];
            if (cell.strength() <= 0) continue;
            if (self.density[i] > kFull && (width > kSightMm || is_amid_opaque(k, i))) {
                for (int c = 0; c < 3; ++c) {
                    cell.color[c] *= hiding;
                    cell.extinction[c] *= hiding;
                }
            }
            double dx = 0;
            double dy = 0;
            double dz = 0;
            constexpr double kSmooth[5]{1.0 / 16, 4.0 / 16, 6.0 / 16, 4.0 / 16, 1.0 / 16};
            constexpr double kSlope[5]{-0.25, -0.5, 0, 0.5, 0.25};
            for (int32_t d = -2; d <= 2; ++d) {
                const Layer& at = layer(k + d);
                dx += kSmooth[d + 2] * slope(&at.along_y[i], 1, away_x_);
                dy += kSmooth[d + 2] * slope(&at.along_x[i], stride, away_y_);
                // The lowest layer is visible beside the one above it.
                const float s =
                    d == -2 ? std::max(at.smooth[i], layer(k - 1).smooth[i]) : at.smooth[i];
                dz += kSlope[d + 2] * s;
            }
            const Vec3d outward{-dx / cell_mm_.x, -dy / cell_mm_.y, -dz / cell_mm_.z};
            const double steep = length(outward) * std::min(cell_mm_.x, cell_mm_.y);
            if (steep < 0.015) continue;
            const Vec3d n = unit(outward);
            const double weight = std::min(1.0, steep * 7);
            const double facing = std::max(dot(n, lamp_), 0.0);
            const double shade = 0.28 + 0.12 * n.z + 0.70 * facing;
            const Vec3d half = unit(lamp_ + viewer_);
            double gloss = std::max(dot(n, half), 0.0);
            for (int power = 0; power < 5; ++power)
                gloss *= gloss;
            const double factor = 1 + (shade - 1) * weight;
            const double shine = gloss * 0.12 * weight * kOpaquePerMm * std::min(steep * 2, 1.0);
            for (float& c : cell.color)
                c = static_cast<float>(c * factor + shine);
        }
    }
}

ModelPreview::Cell ModelPreview::sample(const Layer& layer, double x, double y) const {
    const double fx = std::floor(x - 0.5);
    const double fy = std::floor(y - 0.5);
    const auto ix = static_cast<int32_t>(fx);
    const auto iy = static_cast<int32_t>(fy);
    Cell sum;
    if (ix < -1 || iy < -1 || ix >= count_.x || iy >= count_.y) return sum;
    const auto tx = static_cast<float>(x - 0.5 - fx);
    const auto ty = static_cast<float>(y - 0.5 - fy);
    const Cell* corner = &layer.cells[index(ix, iy)];
    const Cell* corners[4]{corner, corner + 1, corner + stride_, corner + stride_ + 1};
    const float weights[4]{(1 - tx) * (1 - ty), tx * (1 - ty), (1 - tx) * ty, tx * ty};
    for (int c = 0; c < 4; ++c) {
        if (corners[c]->strength() <= 0) continue;
        for (int i = 0; i < 3; ++i) {
            sum.color[i] += weights[c] * corners[c]->color[i];
            sum.extinction[i] += weights[c] * corners[c]->extinction[i];
        }
    }
    return sum;
}

/// Composites over the layers below: the pixels whose ray meets the layer, each along its path
/// through it from far to near.
void ModelPreview::paint(int32_t k) {
    const Layer& self = layer(k);
    if (self.last_row < self.first_row) return;
    const double z = k * cell_mm_.z;
    const double low = (self.first_row - 1) * cell_mm_.y;
    const double high = (self.last_row + 2) * cell_mm_.y;
    const double wide = count_.x * cell_mm_.x;
    double low_b = 1e30;
    double high_b = -1e30;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p{(corner & 1) != 0 ? wide : 0, (corner & 2) != 0 ? high : low,
                      (corner & 4) != 0 ? z + cell_mm_.z : z};
        low_b = std::min(low_b, dot(p, up_));
        high_b = std::max(high_b, dot(p, up_));
    }
    const int32_t first =
        std::max(0, static_cast<int32_t>(std::floor((low_b - low_b_) / pixel_mm_)));
    const int32_t last =
        std::min(height_ - 1, static_cast<int32_t>(std::ceil((high_b - low_b_) / pixel_mm_)));
    for (int32_t row = first; row <= last; ++row)
        paint_row(self, row, z);
}

void ModelPreview::paint_row(const Layer& self, int32_t row, double z) {
    const double b = low_b_ + (row + 0.5) * pixel_mm_;
    const double through = cell_mm_.z / viewer_.z;  // length of a ray's path through the layer
    const double sideways = std::sqrt(std::max(0.0, 1 - viewer_.z * viewer_.z)) * through;
    const int32_t steps =
        std::max(1, static_cast<int32_t>(std::ceil(sideways / std::min(cell_mm_.x, cell_mm_.y))));
    const double step = through / steps;
    const double start = (z - b * up_.z) / viewer_.z + step / 2;
    for (int32_t column = 0; column < width_; ++column) {
        const double a = low_a_ + (column + 0.5) * pixel_mm_;
        const Vec3d at = right_ * a + up_ * b + viewer_ * start;
        Painted& pixel = painted_[static_cast<size_t>(row) * static_cast<size_t>(width_) +
                                  static_cast<size_t>(column)];
        for (int32_t s = 0; s < steps; ++s) {
            const double x = (at.x + viewer_.x * step * s) / cell_mm_.x;
            const double y = (at.y + viewer_.y * step * s) / cell_mm_.y;
            const Cell cell = sample(self, x, y);
            if (cell.strength() <= 0) continue;
            float covered = 0;
            for (int c = 0; c < 3; ++c) {
                const float alpha = absorbed(cell.extinction[c] * static_cast<float>(step));
                pixel.color[c] =
                    pixel.color[c] * (1 - alpha) + alpha * (cell.color[c] / cell.extinction[c]);
                covered += alpha * (1.0F / 3);
            }
            pixel.alpha += covered * (1 - pixel.alpha);
        }
    }
}

Result<void> ModelPreview::finish(const pipeline::PrintTotals&) {
    if (gathered_ > 0) close_layer();
    for (int32_t after = 0; after < 2; ++after)
        close_layer();
    Picture picture;
    picture.width = width_;
    picture.height = height_;
    picture.pixel_mm = pixel_mm_;
    picture.pixels.resize(painted_.size());
    for (int32_t y = 0; y < height_; ++y) {
        for (int32_t x = 0; x < width_; ++x) {
            const Painted& from =
                painted_[static_cast<size_t>(height_ - 1 - y) * static_cast<size_t>(width_) +
                         static_cast<size_t>(x)];
            if (from.alpha <= 0) continue;
            Pixel& pixel = picture.at(x, y);
            pixel.coverage = from.alpha;
            for (int c = 0; c < 3; ++c)
                pixel.color[c] = from.color[c] / from.alpha;
        }
    }
    return take_(picture);
}

}  // namespace openfab::preview
