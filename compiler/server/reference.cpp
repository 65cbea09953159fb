// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/reference.h"

#include <algorithm>
#include <iterator>

#include "compiler/check/signatures.h"

namespace openfab::server {

namespace {

struct Marker {
    std::string_view name;
    std::string_view text;
};
constexpr Marker kMarkers[] = {
    {"uniform",
     "Values that the world binds once for an object: numbers, textures, materials, objects."},
    {"Surface",
     "The surface stage: runs on the vertices of the surface and returns the displacement, a "
     "`float3` in mm."},
    {"Volume", "The volume stage: runs for each voxel and returns its `MaterialComposition`."},
    {"Dither",
     "The dither rule: runs for each voxel that is a mixture and returns the number of the "
     "fraction "
     "that it becomes; 0 is void."},
    {"Shape",
     "The shape stage: a solid as a function. Runs at any point of part space and returns a "
     "`float`, "
     "negative inside."},
    {"Grow",
     "The grow stage: a rule. Makes a node, a struct, of the one that it grows from, when a slab "
     "reaches it."},
    {"varying",
     "What a stage reads: a point in a shape stage, the node before in a grow stage, the mesh's "
     "attributes in a surface stage, "
     "those of the nearest surface "
     "point in a volume stage, the voxel's in a dither rule."},
    {"nearest", "A varying of the volume stage: its value at the nearest point of the surface."},
    {"bound", "The most trips of the loop that follows, a constant."},
};

}  // namespace

std::vector<ReferenceEntry> reference_of(std::string_view name) {
    std::vector<ReferenceEntry> out;
    for (const check::Signature& one : check::signatures_of(name))
        out.push_back({std::string(one.form), std::string(one.text)});
    return out;
}

std::string_view marker_text(std::string_view name) {
    const auto found = std::find_if(std::begin(kMarkers), std::end(kMarkers),
                                    [&](const Marker& m) { return m.name == name; });
    return found == std::end(kMarkers) ? std::string_view() : found->text;
}

std::vector<std::string_view> markers() {
    std::vector<std::string_view> out;
    for (const Marker& marker : kMarkers)
        out.push_back(marker.name);
    return out;
}

}  // namespace openfab::server
