// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "tools/viewer/graph_places.h"
#include "tools/viewer/live.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/texture_look.h"

namespace openfab::viewer {

namespace {

/// Reads "over" and, but for the surface, "point_mm" and "axis".
Result<void> read_place(const JsonValue& action, Look* of) {
    constexpr std::pair<std::string_view, LookOver> kOver[] = {{"slice", LookOver::kSlice},
                                                               {"line", LookOver::kLine},
                                                               {"voxel", LookOver::kVoxel},
                                                               {"surface", LookOver::kSurface}};
    const JsonValue* over = member_of(action, "over");
    const auto* found = std::find_if(std::begin(kOver), std::end(kOver), [&](const auto& one) {
        return over != nullptr && over->text == one.first;
    });
    if (found == std::end(kOver)) return user_error(messages::kOverIsOneOf);
    of->over = found->second;
    if (of->over == LookOver::kSurface) return {};
    const JsonValue* point = member_of(action, "point_mm");
    const bool fits =
        point != nullptr && point->items.size() == 3 &&
        std::all_of(point->items.begin(), point->items.end(), [](const JsonValue& one) {
            return one.is(JsonValue::Kind::kNumber) && std::isfinite(one.number);
        });
    if (!fits) return user_error(messages::kPointIsThreeNumbers);
    of->point_mm = {point->items[0].number, point->items[1].number, point->items[2].number};
    const JsonValue* axis = member_of(action, "axis");
    if (axis == nullptr) return {};
    if (!axis->is(JsonValue::Kind::kNumber) ||
        (axis->number != 0 && axis->number != 1 && axis->number != 2))
        return user_error(messages::kAxisIs);
    of->axis = static_cast<int>(axis->number);
    return {};
}

JsonValue number_value(double number) {
    JsonValue value;
    value.kind = JsonValue::Kind::kNumber;
    value.number = number;
    return value;
}

/// An action that says, too, which voxels print (compiler/graph/look.h).
JsonValue with_where(JsonValue action, const LookGrid& grid) {
    action.members.push_back({"shell_mm", 0, 0, number_value(grid.shell_mm)});
    JsonValue within;
    within.kind = JsonValue::Kind::kArray;
    for (const auto& limits : grid.within_mm) {
        JsonValue pair;
        pair.kind = limits ? JsonValue::Kind::kArray : JsonValue::Kind::kNull;
        if (limits) pair.items = {number_value(limits->first), number_value(limits->second)};
        within.items.push_back(pair);
    }
    action.members.push_back({"within_mm", 0, 0, within});
    return action;
}

}  // namespace

Result<std::string> Live::graph(const std::string& method, int32_t fablet, const std::string& text,
                                const JsonValue* action) {
    const Result<FabletSource> of = world_.now()->source_of(fablet);
    if (!of) return of.error();
    return graphs_.ask("openfl/" + method, of->path, text, action);
}

Result<std::string> Live::places(int32_t fablet) const {
    const Result<FabletSource> of = world_.now()->source_of(fablet);
    if (!of) return of.error();
    return graph_places(of->path, of->roots);
}

Result<void> Live::keep_places(int32_t fablet, const JsonValue& places) const {
    const Result<FabletSource> of = world_.now()->source_of(fablet);
    if (!of) return of.error();
    return keep_graph_places(of->path, of->roots, places);
}

Result<std::string> Live::look(int32_t fablet, const std::string& text, const JsonValue& action) {
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const Result<FabletSource> source = reading->source_of(fablet);
    if (!source) return source.error();
    const Session::Prints prints = session_->prints();
    if (prints.list.empty()) return user_error(messages::kNoPrintYet);
    Look of;
    of.world = options_.file;
    of.source = source->path;
    of.allow = options_.allow;
    of.print = prints.list[0]->file().info();
    of.sources = reading->sources;
    of.settings = view_.settings();
    if (Result<void> fine = read_place(action, &of); !fine) return fine.error();
    const JsonValue asked = with_where(action, grid_of(of));
    const Result<std::string> printed = graphs_.ask("openfl/look", of.source, text, &asked);
    if (!printed) return printed.error();
    const Result<JsonValue> json = parse_json(*printed, "openflc");
    if (!json) return json.error();
    return looker_.look(of, *json);
}

Result<std::vector<uint8_t>> Live::texture(const std::string& name, bool is_volume) const {
    const std::shared_ptr<const world::World> world = world_.now()->world;
    if (world != nullptr) {
        for (const world::Texture& one : world->textures) {
            if (one.name == name) return texture_look(one, is_volume, world->roots);
        }
    }
    return user_error(fmt::format(messages::kNoSuchTexture, name));
}

}  // namespace openfab::viewer
