// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Placements of the pieces of objects.

#include <fmt/format.h>

#include "base/near_miss.h"
#include "world/build_reader.h"
#include "world/messages.h"
#include "world/transforms_file.h"

namespace openfab::world {

/// One piece of the object, or all of them, moved apart by `explode_mm`.
std::vector<Placement> BuildReader::with_pieces(const JsonValue& value, const std::string& what,
                                                Placement placement) {
    const JsonMember* piece = value.find("piece");
    const JsonMember* explode = value.find("explode_mm");
    if (piece == nullptr) {
        if (explode != nullptr) {
            json_.fail_at(explode->line, explode->column,
                          fmt::format(messages::kExplodeWithoutPiece, what),
                          messages::kExplodeWithoutPieceHelp);
        }
        return {std::move(placement)};
    }
    const std::string name = json_.string(piece->value, fmt::format("`piece` of {}", what));
    if (!json_.ok()) return {};
    const Object& object = world_.objects[placement.object];
    if (object.pieces == nullptr) {
        json_.fail(piece->value, fmt::format(messages::kPieceOfUncutObject, object.name, name),
                   messages::kPieceOfUncutObjectHelp);
        return {};
    }
    double gap = 0;
    if (explode != nullptr)
        gap =
            json_.number(explode->value, fmt::format("`explode_mm` of {}", what), 0, kFarthest_mm);
    std::vector<Placement> out;
    std::vector<std::string> names;
    const std::vector<pieces::Region>& regions = object.pieces->regions;
    for (size_t i = 0; i < regions.size(); ++i) {
        names.push_back(regions[i].name);
        // A dowel without a material of its own may be one that is bought.
        const bool bought = regions[i].shapes_only && regions[i].filled.empty();
        if (regions[i].name != name && (name != "all" || bought)) continue;
        out.push_back(placement);
        out.back().piece = static_cast<int32_t>(i);
        out.back().transform.t = pieces::apart(regions[i], gap);
    }
    if (out.empty()) {
        json_.fail(piece->value, fmt::format(messages::kNoSuchPiece, object.name, name),
                   suggest(name, names) + messages::kAllAreAllOfThem);
    }
    return memory_for(value, out, 1) ? out : std::vector<Placement>{};
}

}  // namespace openfab::world
