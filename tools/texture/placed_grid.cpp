// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/placed_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "base/units.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

/// Of a step's length: what a file's rounding of direction cosines may leave along other axes, however many
/// steps there are.
constexpr double kRounding = 1e-7;
/// Of a texel: how far rounding may move any texel of the grid.
constexpr double kStraight = 1e-4;

/// The axis that a step runs along most.
int axis_of(const Vec3d& step) {
    const Vec3d way{std::abs(step.x), std::abs(step.y), std::abs(step.z)};
    return way.x >= way.y && way.x >= way.z ? 0 : way.y >= way.z ? 1 : 2;
}

/// Axes mirrored or exchanged.
class OrderedReader final : public VolumeReader {
  public:
    std::vector<float> values;
    std::array<int64_t, 3> strides{};  ///< of x, y and z, in texels
    int64_t begin = 0;                 ///< the texel at the lowest corner

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const int64_t texel = begin + x * strides[0] + y * strides[1] + z * strides[2];
                out = std::copy_n(values.data() + texel * channels, channels, out);
            }
            wrote(4 * row_floats());
        }
        return {};
    }
};

class TurnedReader final : public VolumeReader {
  public:
    std::vector<float> values;
    Vec3i from_size;
    ResampledBox box;
    Vec3d first;
    std::array<Vec3d, 3> rows;      ///< of the inverse of the steps
    std::array<double, 3> reach{};  ///< of a texel of `box`, in steps
    std::array<float, 4> beyond{};

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                sample(box.center(x, y, z) - first, out);
                out += channels;
            }
            wrote(4 * row_floats());
        }
        return {};
    }

  private:
    void sample(const Vec3d& at, float* out) const {
        constexpr double kHalfTexel = 0.5 + 1e-9;
        std::array<int64_t, 3> low{};
        std::array<double, 3> part{};
        for (int a = 0; a < 3; ++a) {
            const double index = dot(rows[static_cast<size_t>(a)], at), last = from_size[a] - 1;
            // A look-up within the grid mixes texels as far as one beside it: they continue the border.
            const double aside = kHalfTexel + reach[static_cast<size_t>(a)];
            if (!(index >= -aside && index <= last + aside)) {
                std::copy_n(beyond.begin(), channels, out);
                return;
            }
            const double inside = std::clamp(index, 0.0, last);
            const double cell = std::min(std::floor(inside), std::max(last - 1, 0.0));
            low[static_cast<size_t>(a)] = static_cast<int64_t>(cell);
            part[static_cast<size_t>(a)] = inside - cell;
        }
        for (int32_t c = 0; c < channels; ++c) {
            double sum = 0;
            for (unsigned corner = 0; corner < 8; ++corner) {
                double weight = 1;
                std::array<int64_t, 3> index = low;
                for (unsigned a = 0; a < 3; ++a) {
                    const bool high = (corner >> a & 1) != 0;
                    weight *= high ? part[a] : 1 - part[a];
                    index[a] += high ? 1 : 0;
                }
                if (weight == 0) continue;
                const int64_t texel = (index[2] * from_size.y + index[1]) * from_size.x + index[0];
                sum +=
                    weight * static_cast<double>(values[static_cast<size_t>(texel * channels + c)]);
            }
            out[c] = static_cast<float>(sum);
        }
    }
};

MadeReader ordered(const Vec3i& size, int32_t channels, std::vector<float> values,
                   const GridFrame& frame) {
    auto reader = std::make_unique<OrderedReader>();
    reader->channels = channels;
    reader->values = std::move(values);
    reader->origin.emplace();
    reader->spacing.emplace();
    const std::array<int64_t, 3> strides{1, size.x, int64_t{size.x} * size.y};
    for (int from = 0; from < 3; ++from) {
        const auto index = static_cast<size_t>(from);
        const int axis = axis_of(frame.steps[index]);
        const auto to = static_cast<size_t>(axis);
        const double step = frame.steps[index][axis];
        const int64_t last = size[from] - 1;
        reader->size[axis] = size[from];
        reader->strides[to] = step < 0 ? -strides[index] : strides[index];
        if (step < 0) reader->begin += last * strides[index];
        const double low =
            std::min(frame.first[axis], frame.first[axis] + step * static_cast<double>(last));
        (*reader->spacing)[to] = std::abs(step);
        (*reader->origin)[to] = low - std::abs(step) / 2;
    }
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace

bool is_along_axes(const GridFrame& frame, const Vec3i& size) {
    Vec3d moved, texel;  // along x, y and z
    for (int k = 0; k < 3; ++k) {
        const Vec3d& step = frame.steps[static_cast<size_t>(k)];
        const int axis = axis_of(step);
        if (texel[axis] != 0 || !(length(step) > 0)) return false;
        texel[axis] = std::abs(step[axis]);
        for (int a = 0; a < 3; ++a) {
            if (a == axis) continue;
            const double aside = std::abs(step[a]) <= kRounding * length(step) ? 0 : step[a];
            moved[a] += std::abs(aside) * (size[k] - 1);
        }
    }
    for (int a = 0; a < 3; ++a) {
        if (!(moved[a] <= kStraight * texel[a])) return false;
    }
    return true;
}

MadeReader place_reader(std::unique_ptr<VolumeReader> reader, const GridFrame& frame,
                        const texture::VolumeOptions& options, const texture::ReadLimits& limits) {
    const auto& [a, b, c] = frame.steps;
    const bool in_order = axis_of(a) == 0 && axis_of(b) == 1 && axis_of(c) == 2;
    if (in_order && is_along_axes(frame, reader->size) && a.x > 0 && b.y > 0 && c.z > 0) {
        reader->spacing = {a.x, b.y, c.z};
        reader->origin = {frame.first.x - a.x / 2, frame.first.y - b.y / 2,
                          frame.first.z - c.z / 2};
        return reader;
    }
    const int64_t count = reader->slice_floats() * reader->size.z;
    if (Result<void> fits = check_memory(4 * count, limits.memory_bytes / 2); !fits)
        return fits.error();
    std::vector<float> values(static_cast<size_t>(count));
    for (int32_t z = 0; z < reader->size.z; ++z) {
        float* const slice = values.data() + z * reader->slice_floats();
        if (Result<void> read = reader->read_slice(z, slice, [](int64_t) {}); !read)
            return read.error();
    }
    if (options.outside) {
        const auto outside = static_cast<float>(*options.outside);
        std::replace_if(
            values.begin(), values.end(), [](float x) { return std::isnan(x); }, outside);
    }
    MadeReader placed = open_placed_grid(reader->size, reader->channels, std::move(values), frame,
                                         options, reader->beyond);
    if (!placed) return placed;
    (*placed)->rounded = reader->rounded;
    (*placed)->no_nan = reader->no_nan && !(*placed)->resampled;
    return placed;
}

double unit_mm(const texture::VolumeOptions& options) {
    if (options.unit.empty()) return 1;
    const Result<double> size = parse_length_mm("1" + options.unit);
    return size ? *size : 1;
}

void ResampledBox::place(VolumeReader* reader) const {
    reader->size = size;
    reader->origin = {origin.x, origin.y, origin.z};
    reader->spacing = {pitch_mm, pitch_mm, pitch_mm};
    reader->resampled = true;
}

Result<ResampledBox> resampled_box(const Box3d& box, double pitch_mm) {
    ResampledBox out{box.lo, pitch_mm, {}};
    for (int a = 0; a < 3; ++a) {
        // Rounding must not add a layer of texels.
        constexpr double kRounding = 1e-6;
        const double count = std::max(1.0, std::ceil(box.size()[a] / pitch_mm - kRounding));
        constexpr double kMost = 16384;
        if (!(count <= kMost)) {
            return user_error(
                fmt::format(messages::kResampledTooLarge, pitch_mm, count, "xyz"[a], kMost));
        }
        out.size[a] = static_cast<int32_t>(count);
    }
    return out;
}

MadeReader open_placed_grid(const Vec3i& size, int32_t channels, std::vector<float> values,
                            const GridFrame& frame, const texture::VolumeOptions& options,
                            std::array<float, 4> beyond) {
    if (is_along_axes(frame, size)) return ordered(size, channels, std::move(values), frame);
    const auto& [a, b, c] = frame.steps;
    const double volume = dot(a, cross(b, c));
    const double least = std::min({length(a), length(b), length(c)});
    constexpr double kFlat = 1e-9;
    if (!(std::abs(volume) > kFlat * length(a) * length(b) * length(c)) || !(least > 0))
        return user_error(messages::kAxesInAPlane);
    auto reader = std::make_unique<TurnedReader>();
    reader->channels = channels;
    reader->values = std::move(values);
    reader->from_size = size;
    reader->first = frame.first;
    reader->rows = {cross(b, c) * (1 / volume), cross(c, a) * (1 / volume),
                    cross(a, b) * (1 / volume)};
    if (options.outside) beyond.fill(static_cast<float>(*options.outside));
    reader->beyond = beyond;
    Box3d bounds;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3d at = frame.first;
        for (int k = 0; k < 3; ++k) {
            const bool high = (corner >> k & 1) != 0;
            at = at + frame.steps[static_cast<size_t>(k)] * (high ? size[k] - 0.5 : -0.5);
        }
        bounds.add(at);
    }
    Result<ResampledBox> box =
        resampled_box(bounds, options.pitch_mm > 0 ? options.pitch_mm : least);
    if (!box) return box.error();
    reader->box = *box;
    for (size_t k = 0; k < 3; ++k) {
        const Vec3d& row = reader->rows[k];
        reader->reach[k] = box->pitch_mm * (std::abs(row.x) + std::abs(row.y) + std::abs(row.z));
    }
    box->place(reader.get());
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
