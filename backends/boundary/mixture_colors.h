// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The colours of mixtures, from the previews of their materials.
//
// Amounts of material filter light one after the other, after Beer and Lambert, as the inks of `stdlib/color.fl` do: the
// linear light of a mixture is the product of those of its materials, each to the power of its share. A
// material takes a density of 1.2 at most, that of the skins of imported meshes; one that is alone has its preview's colour.
// Without libm, so that a file is the same on every machine.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <utility>
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

/// Keeps what is made of the mixtures of slices until it is asked for.
template <typename Value>
class MixturePlanes : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override {
        info_ = info;
        materials_ = static_cast<size_t>(materials);
        return {};
    }
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override {
        if (std::all_of(fractions.begin(), fractions.end(), [](float f) { return !(f > 0); }))
            return;
        const auto width = static_cast<size_t>(info_.size.x);
        Value* to = nullptr;
        {
            const std::lock_guard lock(mutex_);
            std::vector<Value>& plane = planes_[z];
            if (plane.empty()) plane.resize(width * static_cast<size_t>(info_.size.y));
            to = plane.data() + static_cast<size_t>(y) * width + static_cast<size_t>(first_x);
        }
        std::span<const float> last;
        Value value = 0;
        for (size_t at = 0; at + materials_ <= fractions.size(); at += materials_) {
            const std::span<const float> voxel = fractions.subspan(at, materials_);
            if (last.empty() || !std::equal(voxel.begin(), voxel.end(), last.begin()))
                value = value_of(voxel);
            *to++ = value;
            last = voxel;
        }
    }
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    /// Returns the values of a slice, x first, 0 where nothing came, and forgets them; empty: none came. To be
    /// called once all of the slice were written.
    std::vector<Value> take(int32_t z) {
        const std::lock_guard lock(mutex_);
        auto node = planes_.extract(z);
        return node.empty() ? std::vector<Value>() : std::move(node.mapped());
    }

  protected:
    /// Called by several threads.
    virtual Value value_of(std::span<const float> fractions) const = 0;

  private:
    pipeline::PrintInfo info_;
    size_t materials_ = 0;
    std::mutex mutex_;  ///< for which planes there are
    std::map<int32_t, std::vector<Value>> planes_;
};

/// Keeps the colours of slices.
class ColorPlanes : public MixturePlanes<Rgba> {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override {
        colors_.assign(1, MixtureColors(info.materials));
        return MixturePlanes::begin(info, materials);
    }

  protected:
    Rgba value_of(std::span<const float> fractions) const override {
        return colors_.front().of(fractions);
    }

  private:
    std::vector<MixtureColors> colors_;  ///< one, once it has begun
};

}  // namespace openfab::boundary
