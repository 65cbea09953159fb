// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Boxes of placements: what puts them on the bed, in grids and in rows.

#include <fmt/format.h>

#include "world/build_reader.h"
#include "world/messages.h"
#include "world/placed_box.h"

namespace openfab::world {

namespace {

/// Limit of the vertices that are transformed to find boxes, over all placements: seconds.
constexpr double kMostLookedAt = 1e9;

/// Returns a text that differs where values do.
std::string text_of(const UniformBindings& bindings) {
    std::string out;
    const auto add = [&](const std::vector<double>& numbers) {
        for (const double n : numbers)
            out += fmt::format(" {:a}", n);
    };
    for (const auto& [name, binding] : bindings) {
        out += fmt::format("; {}{}:", name, binding.boolean ? "?" : "");
        if (const auto* numbers = std::get_if<std::vector<double>>(&binding.value)) add(*numbers);
        if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value)) {
            for (const std::string& text : *names)
                out += fmt::format(" {}:{}", text.size(), text);
        }
        if (const auto* curve = std::get_if<Curve>(&binding.value)) {
            out += curve->interpolation ? interpolation_name(*curve->interpolation) : "-";
            for (const std::vector<double>& key : curve->keys) {
                add(key);
                out += ",";
            }
        }
    }
    return out;
}

}  // namespace

/// Returns the box of the solids as placed, before any displacement.
Box3d BuildReader::box(const JsonValue& value, const std::vector<Placement>& placements) {
    Box3d out;
    for (const Placement& p : placements) {
        if (looked_at_ > kMostLookedAt) {
            json_.fail(value, messages::kTooManyRotatedMeshes, messages::kTooManyRotatedMeshesHelp);
            break;
        }
        const Box3d& turned = turned_box(p);
        if (!json_.ok()) break;
        if (!turned.empty()) out.add(Box3d{turned.lo + p.transform.t, turned.hi + p.transform.t});
    }
    return out.empty() ? Box3d{{}, {}} : out;
}

/// Whether the solid itself has to be asked how far it reaches: a box stands as the mesh of what
/// World::shapes knows, and around beams, which are cut into pieces.
bool BuildReader::has_own_extent(const Placement& placement) const {
    return asks_solid(world_, placement);
}

/// Returns the overrides of a placement in the groups that are read: outer ones win.
UniformBindings BuildReader::overrides_of(const Placement& placement) const {
    UniformBindings out = placement.overrides;
    const std::string before = world_.objects[placement.object].name + ".";
    for (auto outer = outer_overrides_.rbegin(); outer != outer_overrides_.rend(); ++outer) {
        for (const auto& [key, binding] : *outer) {
            const size_t dot = key.rfind('.');
            if (dot + 1 == before.size() && key.starts_with(before))
                out.insert_or_assign(key.substr(dot + 1), binding);
        }
    }
    return out;
}

/// A group may be unused, or used with overrides that make its shapes solid: then it is no error.
void BuildReader::note_no_extent(const Error& error) {
    if (depth_ == 0 || !outer_overrides_.empty()) {
        if (json_.ok()) json_.fail_with(error);
    } else if (!no_extent_) {
        no_extent_ = error;
    }
}

const Box3d& BuildReader::turned_box(const Placement& placement) {
    const Object& object = world_.objects[placement.object];
    const pieces::Region* region =
        placement.piece >= 0 ? &object.pieces->regions[placement.piece] : nullptr;
    const bool own = extent_of_ != nullptr && has_own_extent(placement);
    Placement turned;
    if (own) turned.overrides = overrides_of(placement);
    const auto [known, fresh] =
        boxes_.try_emplace({own ? placement.object : object.mesh, region, placement.transform.m,
                            own ? "shape " + text_of(turned.overrides) : ""});
    if (!fresh) return known->second;
    const Affine3d turn{placement.transform.m, {}};
    if (own) {
        turned.object = placement.object;
        turned.piece = placement.piece;
        turned.location = placement.location;
        turned.transform = turn;
        const Result<Box3d> found = extent_of_(world_, turned);
        if (found) {
            known->second = *found;
        } else {
            note_no_extent(found.error());
        }
        return known->second;
    }
    looked_at_ += static_cast<double>(points_of(world_, object));
    known->second = placed_box(world_, object, placement.piece, turn);
    return known->second;
}

}  // namespace openfab::world
