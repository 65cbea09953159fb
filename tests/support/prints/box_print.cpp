// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/prints/box_print.h"

#include <algorithm>
#include <cmath>

#include "mesh/model/primitives.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/prints/test_fablets.h"
#include "tests/support/reference/dither.h"

namespace openfab::testing {

Result<void> MemorySink::begin(const pipeline::PrintInfo& print_info) {
    info = print_info;
    return {};
}

std::vector<uint8_t> MemorySink::encode(const pipeline::SliceView& slice) const {
    return {slice.data, slice.data + slice.row_bytes * static_cast<size_t>(slice.height)};
}

Result<void> MemorySink::commit(int32_t slice_z, std::vector<uint8_t> bytes) {
    if (slice_z == fail_at) return outside_error("the disk is full");
    z.push_back(slice_z);
    slices.push_back(bytes);
    return {};
}

Result<void> MemorySink::finish(const pipeline::PrintTotals& print_totals) {
    totals = print_totals;
    ++finished;
    return {};
}

std::vector<uint8_t> MemorySink::codes() const {
    std::vector<uint8_t> out;
    for (const std::vector<uint8_t>& slice : slices) {
        pipeline::SliceView view;
        view.data = slice.data();
        view.row_bytes = static_cast<size_t>((info.size.x * info.bits + 7) / 8);
        for (int32_t y = 0; y < info.size.y; ++y) {
            for (int32_t x = 0; x < info.size.x; ++x)
                out.push_back(view.code(x, y, info.bits));
        }
    }
    return out;
}

pipeline::PrintInput make_input(const std::vector<BoxPart>& boxes, const Vec3d& pitch_mm,
                                size_t materials) {
    pipeline::PrintInput input;
    input.pitch_mm = pitch_mm;
    for (size_t m = 0; m < materials; ++m) {
        input.materials.emplace_back();
        input.materials.back().name = m == 0 ? "white" : m == 1 ? "black" : std::to_string(m);
    }
    for (const BoxPart& box : boxes) {
        testing::PartOptions options;
        // The primitive stands centred on z = 0.
        options.transform.t = {box.corner_mm.x + box.size_mm.x / 2,
                               box.corner_mm.y + box.size_mm.y / 2, box.corner_mm.z};
        options.slot_material = box.slot_material;
        options.priority = box.priority;
        options.instance = static_cast<int32_t>(input.parts.size());
        input.parts.push_back(
            testing::make_part(*box.fablet, mesh::make_box(box.size_mm), options));
    }
    return input;
}

namespace {

/// Distance to the nearest side of the box from inside, and that side's `face`; false outside.
bool inside_box(const BoxPart& box, const Vec3d& p, double* distance, int32_t* face) {
    constexpr int32_t kFaces[3][2] = {{5, 3}, {2, 4}, {1, 0}};
    *distance = 1e30;
    for (int a = 0; a < 3; ++a) {
        const double sides[2] = {p[a] - box.corner_mm[a], box.corner_mm[a] + box.size_mm[a] - p[a]};
        for (int s = 0; s < 2; ++s) {
            if (sides[s] <= 0) return false;
            if (sides[s] >= *distance) continue;
            *distance = sides[s];
            *face = kFaces[a][s];
        }
    }
    return true;
}

Weights weights_at(const BoxPart& box, const Vec3d& p, double distance, int32_t face) {
    const auto d = static_cast<float>(distance);
    if (box.fablet == &skin_fablet()) return skin_weights(d);
    if (box.fablet == &picture_fablet()) {
        return picture_weights(d, face,
                               static_cast<float>((p.x - box.corner_mm.x) / box.size_mm.x));
    }
    if (box.fablet == &tint_fablet()) return {3, 7, 0};
    if (box.fablet == &hole_fablet()) return {0, 0, 1};
    return {1, 0, 0};
}

}  // namespace

std::vector<uint8_t> reference_codes(const std::vector<BoxPart>& boxes,
                                     const pipeline::PrintInfo& info, uint64_t seed,
                                     dither::DitherRule rule) {
    const auto materials = static_cast<int32_t>(info.materials.size());
    reference::FractionField field = reference::make_field(info.size, materials);
    for (int32_t z = 0; z < info.size.z; ++z) {
        for (int32_t y = 0; y < info.size.y; ++y) {
            for (int32_t x = 0; x < info.size.x; ++x) {
                const Vec3d p{info.origin_mm.x + (x + 0.5) * info.pitch_mm.x,
                              info.origin_mm.y + (y + 0.5) * info.pitch_mm.y,
                              info.origin_mm.z + (z + 0.5) * info.pitch_mm.z};
                const BoxPart* owner = nullptr;
                double distance = 0;
                int32_t face = 0;
                for (const BoxPart& box : boxes) {
                    double d;
                    int32_t f;
                    if (!inside_box(box, p, &d, &f)) continue;
                    if (owner != nullptr && box.priority < owner->priority) continue;
                    owner = &box;
                    distance = d;
                    face = f;
                }
                if (owner == nullptr) continue;
                const Weights w = weights_at(*owner, p, distance, face);
                const float amounts[3] = {w.a, w.b, w.empty};
                const int32_t slots[3] = {owner->slot_material[0], owner->slot_material[1],
                                          owner->slot_material[2]};
                const std::vector<uint16_t> fractions =
                    reference::normalise(amounts, slots, materials, nullptr);
                std::copy(fractions.begin(), fractions.end(), field.at(x, y, z));
            }
        }
    }
    return reference::dither(field, seed, rule);
}

Printed print_boxes(const std::vector<BoxPart>& boxes, const pipeline::PrintOptions& options,
                    const Vec3d& pitch_mm, size_t materials) {
    Printed printed;
    auto print = pipeline::PrintJob::create(make_input(boxes, pitch_mm, materials), options);
    if (!print) {
        printed.error = print.error();
        return printed;
    }
    const std::atomic<bool> interrupt{false};
    const Result<void> run = (*print)->run(printed.sink, {}, interrupt, &printed.statistics);
    printed.ok = run.has_value();
    if (!run) printed.error = run.error();
    return printed;
}

}  // namespace openfab::testing
