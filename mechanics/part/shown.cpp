// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/shown.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/ofr/ofr_sink.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::mechanics {

Colour Shown::colour(double value) const {
    const double t = std::clamp((value - least) / (most - least), 0.0, 1.0);
    return scale_colour(low_is_bad ? 1 - t : t);
}

std::string short_number(double v) {
    return v != 0 && (std::abs(v) < 0.01 || std::abs(v) >= 10000) ? fmt::format("{:.1e}", v)
                                                                  : fmt::format("{:.3g}", v);
}

Shown shown_of(const PartProblem& problem, const PartFields& fields,
               const Field<double, kElastic>& moved, const std::string& what) {
    const Grid& g = problem.grid;
    const std::vector<uint8_t>& kind = problem.elements.kind;
    Shown out;
    out.name = what;
    out.unit = "MPa";
    if (what == "displacement") {
        out.unit = "mm";
        out.values.resize(kind.size());
        for (int64_t e = 0; e < g.element_count(); ++e) {
            if (kind[static_cast<size_t>(e)] != kSolid) continue;
            Vec3 mean{};
            for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
                for (const int64_t node : nodes_of(g, {e, d})) {
                    const Vec3 u = moved_at(moved, node);
                    for (size_t a = 0; a < 3; ++a)
                        mean[a] += u[a] / 8;
                }
            out.values[static_cast<size_t>(e)] =
                static_cast<float>(std::hypot(mean[0], mean[1], mean[2]));
        }
    } else {
        out.values = what == "safety"        ? fields.safety
                     : what == "tension"     ? fields.tension_MPa
                     : what == "compression" ? fields.compression_MPa
                                             : fields.von_mises_MPa;
    }
    std::vector<float> all;
    for (size_t e = 0; e < kind.size(); ++e)
        if (kind[e] == kSolid) all.push_back(out.values[e]);
    std::ranges::sort(all);
    if (all.empty()) return out;
    const size_t last = all.size() - 1;
    const size_t beyond = what == "displacement" ? 0 : last / 500;
    out.least = std::min(0.0, static_cast<double>(all[beyond]));
    out.most = std::max(0.0, static_cast<double>(all[last - beyond]));
    if (what == "von-mises" || what == "displacement") out.least = 0;
    if (what == "compression") {
        out.most = 0;
        out.low_is_bad = true;
    }
    if (what == "safety") {
        constexpr double kSafe = 4;
        out.unit = "";
        out.least = 0;
        out.most = kSafe;
        out.low_is_bad = true;
    }
    if (!(out.most > out.least)) out.most = out.least + 1;
    return out;
}

Result<void> write_bands(const std::filesystem::path& file, const Grid& g, const Vec3& origin,
                         const std::vector<uint8_t>& kind, const Shown& shown) {
    constexpr int kBands = 20;
    pipeline::PrintInfo info;
    info.size = {g.elements[0], g.elements[1], g.elements[2]};
    info.pitch_mm = {g.pitch_mm[0], g.pitch_mm[1], g.pitch_mm[2]};
    info.origin_mm = {origin[0], origin[1], origin[2]};
    info.slice_end = g.elements[2];
    info.bits = 8;
    info.printer = "openfab mechanics";
    info.title = shown.name;
    const double step = (shown.most - shown.least) / kBands;
    const std::string unit = shown.unit.empty() ? "" : " " + shown.unit;
    for (int k = 0; k < kBands; ++k) {
        const double low = shown.least + k * step, high = low + step;
        const Colour c = shown.colour((low + high) / 2);
        // The first and the last hold what is beyond the scale.
        const bool below = k == 0 && shown.least < 0, above = k + 1 == kBands && shown.most > 0;
        pipeline::SliceMaterial band;
        // Short, for lists of materials are narrow: what it is of is the print's title.
        band.name = below ? fmt::format("below {}{}", short_number(high), unit)
                    : above
                        ? fmt::format("above {}{}", short_number(low), unit)
                        : fmt::format("{} to {}{}", short_number(low), short_number(high), unit);
        band.key = band.preview = {c[0], c[1], c[2], 255};
        info.materials.push_back(std::move(band));
    }
    Result<std::unique_ptr<pipeline::SliceSink>> opened = ofr::OfrSink::create(file.string());
    if (!opened) return opened.error();
    pipeline::SliceSink& sink = **opened;
    if (Result<void> done = sink.begin(info); !done) return done;
    pipeline::PrintTotals totals;
    totals.voxels_by_code.resize(kBands + 1);
    const size_t plane = static_cast<size_t>(g.elements[0]) * static_cast<size_t>(g.elements[1]);
    std::vector<uint8_t> codes(plane);
    for (int32_t z = 0; z < g.elements[2]; ++z) {
        for (size_t i = 0; i < plane; ++i) {
            const size_t e = static_cast<size_t>(z) * plane + i;
            uint8_t code = 0;
            if (kind[e] == kSolid) {
                const double band = (static_cast<double>(shown.values[e]) - shown.least) / step;
                code = static_cast<uint8_t>(1 + std::clamp(std::floor(band), 0.0, kBands - 1.0));
                const auto x = static_cast<int32_t>(i % static_cast<size_t>(g.elements[0]));
                const auto y = static_cast<int32_t>(i / static_cast<size_t>(g.elements[0]));
                totals.tight.add(Box3i{{x, y, z}, {x + 1, y + 1, z + 1}});
                ++totals.voxels_solid;
            }
            codes[i] = code;
            ++totals.voxels_by_code[code];
        }
        const pipeline::SliceView view{z, codes.data(), static_cast<size_t>(g.elements[0]),
                                       g.elements[0], g.elements[1]};
        totals.hash += pipeline::slice_hash(z, view.data, view.row_bytes, view.height);
        if (Result<void> done = sink.commit(z, sink.encode(view)); !done) return done;
    }
    totals.complete = true;
    return sink.finish(totals);
}

}  // namespace openfab::mechanics
