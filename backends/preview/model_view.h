// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print as it lies on a table, seen at an angle from above: `view=model:TURN:TILT`. Voxels are
// gathered into cells that are about as wide as high, and a slice of cells is painted over the ones
// below it, from the back to the front, so that no more than a few slices are ever held. Each
// material has a strength by its preview's alpha a: s = a / (1 - a) per mm, and half of the light
// over kSightMm where it is opaque. Clear materials are filters besides: a channel of colour c is
// absorbed at s (1 + 20 (1 - a) (1 - c)) per mm, so that magenta over yellow over white is red.
// Boundaries are lit from the upper left, with normals from the density gradient, as far as they
// are visible: cells behind dense ones do not bend their surface, and opaque cells among others
// hide what is behind.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/preview/picture.h"
#include "backends/preview/preview_spec.h"

namespace openfab::preview {

/// Maximum memory of the view, for the budget.
constexpr int64_t kModelBytes = 97'000'000;

class ModelPreview : public backends::SliceObserver {
  public:
    ModelPreview(PreviewSpec spec, TakePicture take);

    Result<void> begin(const pipeline::PrintInfo& info) override;
    void observe(const pipeline::SliceView& slice) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    /// Optical properties of a cell, by channel and per mm: reflected light and extinction.
    struct Cell {
        float color[3]{};
        float extinction[3]{};
        float strength() const { return extinction[0] + extinction[1] + extinction[2]; }
    };
    /// Adds the density from which boundaries are found: 0 void, 1 opaque.
    struct Material : Cell {
        float density = 0;
    };
    /// A slice of cells with a rim of void ones around it.
    struct Layer {
        std::vector<Cell> cells;
        std::vector<float> density;
        std::vector<float> along_x, along_y, smooth;  ///< density, blurred along x, y and both
        int32_t first_row = 0;  ///< rows with something in them; first > last: none
        int32_t last_row = -1;
    };
    struct Painted {
        float color[3]{};  ///< premultiplied
        float alpha = 0;
    };

    static constexpr int32_t kHeld = 6;
    static constexpr int32_t kRim = 4;

    size_t index(int32_t x, int32_t y) const {
        return static_cast<size_t>(y + kRim) * stride_ + static_cast<size_t>(x + kRim);
    }
    /// Layers are counted from the first slice of the print; those outside are void.
    Layer& layer(int32_t k) { return layers_[static_cast<size_t>(k + kHeld) % kHeld]; }
    bool cut_away(int32_t x, int32_t y) const;
    void close_layer();
    void blur(Layer* layer);
    bool is_amid_opaque(int32_t k, size_t i);
    void light(int32_t k);
    void paint(int32_t k);
    void paint_row(const Layer& layer, int32_t row, double z_mm);
    Cell sample(const Layer& layer, double x, double y) const;

    PreviewSpec spec_;
    TakePicture take_;
    pipeline::PrintInfo info_;
    std::vector<Material> by_code_;
    Vec3i step_;   ///< voxels a cell
    Vec3i count_;  ///< cells
    Vec3d cell_mm_;
    size_t stride_ = 0;
    int32_t away_x_ = 0, away_y_ = 0;  ///< direction along each axis away from the viewer
    Vec3d right_, up_, viewer_;        ///< unit; picture axes, and where the viewer is
    Vec3d lamp_;
    double low_a_ = 0, low_b_ = 0;  ///< mm along right_ and up_ of the picture's lower left
    double pixel_mm_ = 1;
    int32_t width_ = 0, height_ = 0;
    std::vector<Painted> painted_;  ///< bottom row first
    std::array<Layer, kHeld> layers_;
    int32_t open_ = 0;      ///< the layer being gathered
    int32_t gathered_ = 0;  ///< slices in it
    std::vector<uint8_t> codes_;
};

}  // namespace openfab::preview
