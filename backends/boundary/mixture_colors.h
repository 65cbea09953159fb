// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The colours of mixtures, from the previews of their materials.
//
// Amounts of material filter light one after the other, after Beer and Lambert, as the inks of `stdlib/color.fl` do: the
// linear light of a mixture is the product of those of its materials, each to the power of its share. A
// material takes a density of 1.2 at most, that of the skins of imported meshes; one that is alone has its preview's colour.
// Without libm, so that a file is the same on every machine.

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "runtime/pipeline/fraction_sink.h"

namespace openfab::boundary {

/// Red, green, blue and alpha of 8 bits, red in the highest; 0 where nothing is.
using Rgba = uint32_t;

class MixtureColors {
  public:
    explicit MixtureColors(const std::vector<pipeline::SliceMaterial>& materials);

    /// Returns the colour of a mixture of the first materials; void among it does not count.
    Rgba of(std::span<const float> fractions) const;
    /// Returns the colour of a material, by its code from 1.
    Rgba of_code(uint8_t code) const { return pure_[code - 1u]; }

  private:
    static constexpr int32_t kBits = 16;  ///< of a share
    struct Powers {
        /// Light to the powers 1/2, 1/4, … of a share's bits, from the highest.
        std::array<std::array<double, kBits>, 3> of;
        double alpha = 1;
    };
    std::vector<Powers> powers_;
    std::vector<Rgba> pure_;
};

/// Keeps the colours of slices until they are asked for.
class ColorPlanes : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override;
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override;
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    /// Returns the colours of a slice, x first, 0 where nothing came, and forgets them; empty: none came. To be
    /// called once all of the slice were written.
    std::vector<Rgba> take(int32_t z);

  private:
    pipeline::PrintInfo info_;
    size_t materials_ = 0;
    std::vector<MixtureColors> colors_;  ///< one, once it has begun
    std::mutex mutex_;                   ///< for which planes there are
    std::map<int32_t, std::vector<Rgba>> planes_;
};

}  // namespace openfab::boundary
