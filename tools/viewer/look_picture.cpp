// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/look_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace openfab::viewer {

namespace {

constexpr double kMostPixels = 90;  ///< along a side
/// Which axes run right and up in a plane across an axis: those of the page's views.
constexpr std::array<std::array<int, 2>, 3> kAcross{{{1, 2}, {0, 2}, {0, 1}}};

/// Right, up and away.
Vec3d projected(const Vec3d& p, int axis) {
    if (axis < 3)
        return {p[kAcross[static_cast<size_t>(axis)][0]], p[kAcross[static_cast<size_t>(axis)][1]],
                0};
    const double half = std::sqrt(0.5);
    const double back = (p.y - p.x) * half;
    return {(p.x + p.y) * half, 0.8 * p.z + 0.6 * back, 0.8 * back - 0.6 * p.z};
}

const std::vector<float>* numbers_at(const PrintedValue& value, int64_t place) {
    if (place < 0) return nullptr;
    const auto found = value.at.find(static_cast<size_t>(place));
    return found == value.at.end() ? nullptr : &found->second;
}

struct Limits {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();
    bool any() const { return high >= low; }
};

/// Of the numbers of a node at places; written where there are any.
Limits write_limits(const PrintedValue& value, const std::vector<int64_t>& places, JsonText* out) {
    Limits limits;
    for (const int64_t place : places) {
        const std::vector<float>* numbers = numbers_at(value, place);
        if (numbers == nullptr) continue;
        for (const float v : *numbers) {
            if (!std::isfinite(v)) continue;
            limits.low = std::min(limits.low, v);
            limits.high = std::max(limits.high, v);
        }
    }
    if (limits.any()) out->member("low", double{limits.low}).member("high", double{limits.high});
    return limits;
}

}  // namespace

LookPicture::LookPicture(const std::vector<Vec3d>& places, double pixel_mm, int axis)
    : pixel_mm_(pixel_mm) {
    if (places.empty()) return;
    std::vector<Vec3d> at;
    at.reserve(places.size());
    for (const Vec3d& p : places)
        at.push_back(projected(p, axis));
    Vec3d low = at[0];
    Vec3d high = low;
    for (const Vec3d& p : at) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), 0};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), 0};
    }
    // A pitch that is not that of the places must not make a picture without end.
    pixel_mm_ =
        std::max({pixel_mm, (high.x - low.x) / kMostPixels, (high.y - low.y) / kMostPixels});
    width_ = static_cast<int>((high.x - low.x) / pixel_mm_ + 0.5) + 1;
    height_ = static_cast<int>((high.y - low.y) / pixel_mm_ + 0.5) + 1;
    nearest_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), -1);
    for (size_t i = 0; i < at.size(); ++i) {
        const auto x = static_cast<int>((at[i].x - low.x) / pixel_mm_ + 0.5);
        const auto y = static_cast<int>((high.y - at[i].y) / pixel_mm_ + 0.5);
        int64_t& there = nearest_[static_cast<size_t>(std::clamp(y, 0, height_ - 1) * width_ +
                                                      std::clamp(x, 0, width_ - 1))];
        if (there < 0 || at[static_cast<size_t>(there)].z > at[i].z)
            there = static_cast<int64_t>(i);
    }
}

void LookPicture::write_frame(JsonText* out) const {
    out->member("width", width_).member("height", height_).member("pixel_mm", pixel_mm_);
    out->key("inside").begin_array();
    for (const int64_t place : nearest_)
        out->value(place >= 0 ? 1 : 0);
    out->end_array();
}

void LookPicture::write(const PrintedValue& value, JsonText* out) const {
    Limits limits = write_limits(value, nearest_, out);
    const bool any = limits.any();
    if (value.type == "MaterialComposition") limits = {0, 1};
    const auto [low, high] = limits;
    // Halves of each, since the range of floats is larger than a float. What is the same everywhere is grey.
    const double range = high > low ? 0.5 * high - 0.5 * low : 0;
    out->key("values").begin_array();
    for (const int64_t place : nearest_) {
        const std::vector<float>* numbers = numbers_at(value, place);
        for (size_t c = 0; c < value.numbers; ++c) {
            const float v = numbers == nullptr ? 0 : (*numbers)[c];
            const bool shown = any && numbers != nullptr && std::isfinite(v);
            const double share =
                range > 0 ? std::clamp((0.5 * v - 0.5 * low) / range, 0.0, 1.0) : 0.5;
            out->value(shown ? static_cast<int32_t>(std::lround(255 * share)) : -1);
        }
    }
    out->end_array();
}

LookCurve::LookCurve(const std::vector<Vec3d>& places, int axis, double from_mm, double step_mm,
                     int count)
    : axis_(axis),
      from_mm_(from_mm),
      step_mm_(step_mm),
      there_(static_cast<size_t>(std::max(count, 0)), -1) {
    for (size_t i = 0; i < places.size(); ++i) {
        const double at = std::round((places[i][axis] - from_mm) / step_mm);
        if (at >= 0 && at < static_cast<double>(there_.size()))
            there_[static_cast<size_t>(at)] = static_cast<int64_t>(i);
    }
}

void LookCurve::write_frame(JsonText* out) const {
    out->member("axis", axis_).member("from_mm", from_mm_).member("step_mm", step_mm_);
}

void LookCurve::write(const PrintedValue& value, JsonText* out) const {
    write_limits(value, there_, out);
    out->key("values").begin_array();
    for (const int64_t place : there_) {
        const std::vector<float>* numbers = numbers_at(value, place);
        for (size_t c = 0; c < value.numbers; ++c) {
            if (numbers == nullptr || !std::isfinite((*numbers)[c])) {
                out->null();
            } else {
                out->value(double{(*numbers)[c]});
            }
        }
    }
    out->end_array();
}

void write_voxel(const PrintedValue& value, JsonText* out) {
    out->key("values").begin_array();
    for (const float v : value.at.rbegin()->second) {
        if (std::isfinite(v)) {
            out->value(double{v});
        } else {
            out->value(std::isnan(v) ? "nan" : v > 0 ? "inf" : "-inf");
        }
    }
    out->end_array();
}

}  // namespace openfab::viewer
