// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/attributes.h"

#include <algorithm>
#include <cmath>

namespace openfab::nearest {
namespace {

Vec3d to_double(const float* v) {
    return {v[0], v[1], v[2]};
}

/// Change of the two barycentric weights for a voxel step along i, j, k: [weight][axis].
struct WeightSteps {
    float step[2][3];
};

Vec3f unit_normal(const float* const position[3]) {
    const Vec3d v0 = to_double(position[0]);
    const Vec3d n = cross(to_double(position[1]) - v0, to_double(position[2]) - v0);
    const double length2 = dot(n, n);
    return length2 > 0 ? vec_cast<float>(n * (1.0 / std::sqrt(length2))) : Vec3f{};
}

WeightSteps weight_steps(const float* const position[3], const std::array<float, 9>& steps) {
    const Vec3d v0 = to_double(position[0]);
    const Vec3d e1 = to_double(position[1]) - v0, e2 = to_double(position[2]) - v0;
    const Vec3d n = cross(e1, e2);
    const double n2 = dot(n, n);
    WeightSteps out{};
    if (!(n2 > 0)) return out;
    // grad b1 . e1 = 1, grad b1 . e2 = 0, grad b1 . n = 0, and the same with 1 and 2 swapped.
    const Vec3d grad[2] = {cross(e2, n) * (1.0 / n2), cross(n, e1) * (1.0 / n2)};
    for (int w = 0; w < 2; ++w) {
        for (int a = 0; a < 3; ++a) {
            out.step[w][a] = static_cast<float>(dot(grad[w], to_double(steps.data() + a * 3)));
        }
    }
    return out;
}

/// Makes a patch of zeros that has this triangle.
std::shared_ptr<const surface::MicroMesh> blank(int32_t triangle, size_t floats, size_t ints) {
    const size_t triangles = static_cast<size_t>(triangle) + 1;
    auto mesh = std::make_shared<surface::MicroMesh>();
    mesh->positions.resize(1);
    mesh->triangles.assign(triangles, {0, 0, 0});
    mesh->vertex_attributes.resize(floats);
    mesh->triangle_attributes.resize(triangles * ints);
    return mesh;
}

}  // namespace

AttributeReader::AttributeReader(const surface::Surface& surface,
                                 const std::array<float, OPENFAB_FRAME_COUNT>& frame, bool geometry)
    : surface_(surface),
      float_components_(surface.ranges().float_components),
      int_components_(surface.ranges().int_components) {
    set_steps(frame);
    auto copies = std::make_shared<Copies>();
    copies_ = copies;
    const std::vector<surface::Patch>& patches = surface.patches();
    copies->first.assign(patches.size(), -1);
    if (float_components_ + int_components_ == 0 && !geometry) return;
    const auto floats = static_cast<size_t>(float_components_);
    int32_t triangles = 0;
    for (size_t p = 0; p < patches.size(); ++p) {
        const bool query = (patches[p].use & surface::kForQuery) != 0;
        if (!query || patches[p].kind != surface::PatchKind::kIdentity) continue;
        const auto mesh = surface.micro(static_cast<int32_t>(p));
        copies->first[p] = triangles;
        triangles += static_cast<int32_t>(mesh->triangles.size());
        for (const std::array<int32_t, 3>& corners : mesh->triangles) {
            for (const int32_t corner : corners) {
                const auto c = static_cast<size_t>(corner);
                for (int a = 0; a < 3; ++a)
                    copies->positions.push_back(mesh->positions[c][a]);
                const float* from = mesh->vertex_attributes.data() + c * floats;
                copies->attributes.insert(copies->attributes.end(), from, from + floats);
            }
        }
        copies->flat.insert(copies->flat.end(), mesh->triangle_attributes.begin(),
                            mesh->triangle_attributes.end());
    }
}

AttributeReader::AttributeReader(const AttributeReader& other,
                                 const std::array<float, OPENFAB_FRAME_COUNT>& frame)
    : surface_(other.surface_),
      float_components_(other.float_components_),
      int_components_(other.int_components_),
      copies_(other.copies_) {
    set_steps(frame);
}

void AttributeReader::set_steps(const std::array<float, OPENFAB_FRAME_COUNT>& frame) {
    for (size_t i = 0; i < 9; ++i)
        steps_[i] = frame[OPENFAB_FRAME_STEP_I + i];
}

/// Returns a patch that has this triangle, which stays valid until the next call.
const surface::MicroMesh& AttributeReader::held(int32_t patch, int32_t triangle,
                                                Scratch* scratch) const {
    Scratch::Held& slot = scratch->held_[static_cast<size_t>(patch) % Scratch::kPatches];
    if (slot.patch == patch) return *slot.micro;
    Scratch::Held& large = scratch->large_;
    if (large.patch == patch) return *large.micro;
    std::shared_ptr<const surface::MicroMesh> micro = surface_.micro(patch);
    // A stopped surface has no triangles left; the caller discards the answer.
    const bool stopped = micro->triangles.empty();
    if (stopped) {
        micro = blank(triangle, static_cast<size_t>(float_components_),
                      static_cast<size_t>(int_components_));
    }
    Scratch::Held& into = micro->triangles.size() > Scratch::kSmall ? large : slot;
    into = {stopped ? -1 : patch, std::move(micro)};
    return *into.micro;
}

AttributeReader::Source AttributeReader::find(int32_t patch, int32_t triangle,
                                              Scratch* scratch) const {
    const auto floats = static_cast<size_t>(float_components_);
    const auto ints = static_cast<size_t>(int_components_);
    Source s{};
    const int32_t first = copies_->first[patch];
    if (first >= 0) {
        const auto t = static_cast<size_t>(first + triangle);
        for (size_t k = 0; k < 3; ++k) {
            s.position[k] = copies_->positions.data() + (t * 3 + k) * 3;
            s.attribute[k] = copies_->attributes.data() + (t * 3 + k) * floats;
        }
        s.flat = copies_->flat.data() + t * ints;
        return s;
    }
    const surface::MicroMesh& mesh = held(patch, triangle, scratch);
    const std::array<int32_t, 3>& corners = mesh.triangles[triangle];
    for (size_t k = 0; k < 3; ++k) {
        const auto c = static_cast<size_t>(corners[k]);
        s.position[k] = &mesh.positions[c].x;
        s.attribute[k] = mesh.vertex_attributes.data() + c * floats;
    }
    s.flat = mesh.triangle_attributes.data() + static_cast<size_t>(triangle) * ints;
    return s;
}

void AttributeReader::read(const BlockAnswer& answer, const uint8_t* active,
                           const AttributeTargets& targets, Scratch* scratch) const {
    const auto clear = [](auto* const* arrays, int32_t count) {
        for (int32_t i = 0; arrays != nullptr && i < count; ++i) {
            if (arrays[i] != nullptr) std::fill(arrays[i], arrays[i] + kBlockVoxels, 0);
        }
    };
    clear(targets.values, float_components_);
    clear(targets.gradients, float_components_ * 3);
    clear(targets.flat, int_components_);

    const auto is_active = [&](int32_t v) {
        return answer.item[v] >= 0 && (active == nullptr || (active[v >> 3] >> (v & 7) & 1) != 0);
    };
    // Neighbouring voxels mostly share a triangle, so runs with the same one are read at once.
    for (int32_t begin = 0, end = 0; begin < kBlockVoxels; begin = end) {
        end = begin + 1;
        if (!is_active(begin)) continue;
        const int32_t patch = answer.item[begin], triangle = answer.in_patch.triangle[begin];
        while (end < kBlockVoxels && answer.item[end] == patch &&
               answer.in_patch.triangle[end] == triangle && is_active(end))
            ++end;
        const Source source = find(patch, triangle, scratch);
        const WeightSteps steps =
            targets.gradients != nullptr ? weight_steps(source.position, steps_) : WeightSteps{};
        for (int32_t c = 0; c < float_components_; ++c) {
            const float a0 = source.attribute[0][c];
            const float d1 = source.attribute[1][c] - a0, d2 = source.attribute[2][c] - a0;
            float* const value = targets.values != nullptr ? targets.values[c] : nullptr;
            for (int32_t v = begin; value != nullptr && v < end; ++v)
                value[v] = (a0 + answer.in_patch.bary1[v] * d1) + answer.in_patch.bary2[v] * d2;
            for (int32_t a = 0; targets.gradients != nullptr && a < 3; ++a) {
                float* const out = targets.gradients[c * 3 + a];
                if (out == nullptr) continue;
                std::fill(out + begin, out + end, steps.step[0][a] * d1 + steps.step[1][a] * d2);
            }
        }
        for (int32_t c = 0; targets.flat != nullptr && c < int_components_; ++c) {
            uint32_t* const out = targets.flat[c];
            if (out != nullptr) std::fill(out + begin, out + end, source.flat[c]);
        }
    }
}

void AttributeReader::read_points(const PointAnswer& answer, const PointTargets& targets,
                                  Scratch* scratch) const {
    const bool wants_normal = std::any_of(targets.normal, targets.normal + 3,
                                          [](const float* out) { return out != nullptr; });
    for (size_t l = 0; l < 8; ++l) {
        const bool found = answer.item[l] >= 0;
        const Source source =
            found ? find(answer.item[l], answer.in_patch.triangle[l], scratch) : Source{};
        const float b1 = answer.in_patch.bary1[l], b2 = answer.in_patch.bary2[l];
        const Vec3f normal = found && wants_normal ? unit_normal(source.position) : Vec3f{};
        for (int a = 0; a < 3; ++a) {
            if (targets.normal[a] != nullptr) targets.normal[a][l] = normal[a];
            if (targets.position[a] == nullptr) continue;
            const float v0 = found ? source.position[0][a] : 0.0f;
            const float offset =
                found ? b1 * (source.position[1][a] - v0) + b2 * (source.position[2][a] - v0)
                      : 0.0f;
            targets.position[a][l] = v0 + offset;
        }
        for (int32_t c = 0; targets.values != nullptr && c < float_components_; ++c) {
            if (targets.values[c] == nullptr) continue;
            const float a0 = found ? source.attribute[0][c] : 0.0f;
            const float d1 = found ? source.attribute[1][c] - a0 : 0.0f;
            const float d2 = found ? source.attribute[2][c] - a0 : 0.0f;
            targets.values[c][l] = (a0 + b1 * d1) + b2 * d2;
        }
        for (int32_t c = 0; targets.flat != nullptr && c < int_components_; ++c) {
            if (targets.flat[c] != nullptr) targets.flat[c][l] = found ? source.flat[c] : 0;
        }
    }
}

}  // namespace openfab::nearest
