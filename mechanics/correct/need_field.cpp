// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/correct/need_field.h"

#include <algorithm>
#include <cmath>

#include "backends/common/part_file.h"
#include "backends/raster/npy.h"

namespace openfab::mechanics {

namespace {

/// Replaces each value by f of those up to `reach` away, along one axis after the other.
template <typename F>
void along_axes(const Grid& g, const std::array<int32_t, 3>& reaches, std::vector<float>* values,
                const F& f) {
    const size_t stride[3] = {
        1, static_cast<size_t>(g.elements[0]),
        static_cast<size_t>(g.elements[0]) * static_cast<size_t>(g.elements[1])};
    for (size_t axis = 0; axis < 3; ++axis) {
        const int32_t n = g.elements[axis], reach = reaches[axis];
        const size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
        std::vector<float> line(static_cast<size_t>(n));
        for (int32_t j = 0; j < g.elements[b]; ++j)
            for (int32_t i = 0; i < g.elements[a]; ++i) {
                float* p = values->data() + static_cast<size_t>(i) * stride[a] +
                           static_cast<size_t>(j) * stride[b];
                for (size_t k = 0; k < line.size(); ++k)
                    line[k] = p[k * stride[axis]];
                for (int32_t k = 0; k < n; ++k) {
                    const int32_t low = std::max(0, k - reach), high = std::min(n - 1, k + reach);
                    p[static_cast<size_t>(k) * stride[axis]] = f(std::span(line).subspan(
                        static_cast<size_t>(low), static_cast<size_t>(high - low + 1)));
                }
            }
    }
}

}  // namespace

NeedStep grow(const PartProblem& problem, const PartFields& fields, const NeedRule& rule,
              NeedField* field) {
    const Grid& g = field->grid;
    NeedStep out;
    std::vector<float> want(field->value.size());
    const std::vector<uint8_t> apart = near_holds_and_loads(problem);
    for (size_t e = 0; e < want.size(); ++e) {
        if (!(fields.safety[e] > 0) || apart[e]) continue;
        const double lack = rule.safety / static_cast<double>(fields.safety[e]);
        if (lack > 1) {
            ++out.weak;
            if (static_cast<double>(field->value[e]) > rule.limit * 0.999) ++out.at_limit;
        }
        // From a little above what is wanted, so that it is not reached at the last moment only.
        constexpr double kFrom = 0.95, kLeast = 0.4;
        if (lack > kFrom)
            want[e] =
                static_cast<float>(rule.limit * rule.step * std::clamp(lack - kFrom, kLeast, 1.0));
    }
    std::array<int32_t, 3> reach{}, half{};
    for (size_t a = 0; a < 3; ++a) {
        reach[a] = std::max(1, static_cast<int32_t>(std::lround(rule.reach_mm / g.pitch_mm[a])));
        half[a] = std::max(1, reach[a] / 2);
    }
    along_axes(g, reach, &want,
               [](std::span<const float> v) { return *std::ranges::max_element(v); });
    along_axes(g, half, &want, [](std::span<const float> v) {
        float sum = 0;
        for (const float one : v)
            sum += one;
        return sum / static_cast<float>(v.size());
    });
    for (size_t e = 0; e < want.size(); ++e) {
        const float old = field->value[e];
        field->value[e] = std::min(static_cast<float>(rule.limit), old + want[e]);
        out.most_grown = std::max(out.most_grown, static_cast<double>(field->value[e] - old));
    }
    return out;
}

Result<void> write_field(const std::filesystem::path& file, const NeedField& field) {
    Result<std::unique_ptr<backends::PartFile>> out = backends::PartFile::create(file);
    if (!out) return out.error();
    const int64_t shape[] = {field.grid.elements[2], field.grid.elements[1],
                             field.grid.elements[0]};
    if (Result<void> done = (*out)->write(raster::npy_header("<f4", shape)); !done) return done;
    if (Result<void> done = (*out)->write({reinterpret_cast<const uint8_t*>(field.value.data()),
                                           field.value.size() * sizeof(float)});
        !done)
        return done;
    return (*out)->keep();
}

}  // namespace openfab::mechanics
