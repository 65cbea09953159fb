// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a kernel looks up: inks on a grid over sRGB, read from a profile before the print. As a file
// it is an NRRD of four 16-bit channels, cyan, magenta, yellow, black; red is the axis along which
// it runs fastest. `ink_amounts` of the library's module color reads it as a volume.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/profile.h"

namespace openfab::color {

/// Nodes an axis; INK_NODES of color.fl.
constexpr int kInkTableNodes = 33;

struct BakeOptions {
    Intent intent = Intent::kPerceptual;
    bool black_point = false;
    double limit = 1;  ///< of the sum of all inks
};

class InkTable {
  public:
    static Result<InkTable> bake(const PrinterProfile& profile, const BakeOptions& options);
    /// Reads what format() has made; errors name the file.
    static Result<InkTable> read(const std::filesystem::path& file);

    /// What the profile asked for: the share of colours with more than all voxels, and the most.
    struct Excess {
        double share = 0, most = 0;
    };
    const Excess& excess() const { return excess_; }

    /// Interpolates within tetrahedra: sRGB, encoded 0..1, to inks.
    Inks at(const Rgb& colour) const;
    /// Returns the file. `description` is one line.
    std::string format(const std::string& description) const;

  private:
    explicit InkTable(std::vector<Inks> nodes) : nodes_(std::move(nodes)) {}

    std::vector<Inks> nodes_;
    Excess excess_;
};

}  // namespace openfab::color
