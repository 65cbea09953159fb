// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tools/viewer/live.h"

namespace openfab::viewer {

Result<std::string> Live::graph(const std::string& method, int32_t fablet, const std::string& text,
                                const JsonValue* action) {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    return graphs_.ask("openfl/" + method, of->path, text, action);
}

Result<std::string> Live::look(int32_t fablet, const std::string& text, const JsonValue& action) {
    const Result<Source> source = source_of(fablet);
    if (!source) return source.error();
    const Session::Prints prints = session_->prints();
    if (prints.list.empty()) return user_error("there is no print yet");
    Look of;
    of.world = options_.file;
    of.source = source->path;
    of.allow = options_.allow;
    of.print = prints.list[0]->file().info();
    {
        const std::lock_guard lock(mutex_);
        of.sources = read_.sources;
        of.settings = shown_settings_;
    }
    const JsonValue* surface = member_of(action, "surface");
    of.is_surface = surface != nullptr && surface->boolean;
    const JsonValue* slice = member_of(action, "slice");
    if (slice != nullptr && slice->is(JsonValue::Kind::kNumber))
        of.slice = static_cast<int32_t>(std::clamp(slice->number, 0.0, of.print.size.z - 1.0));
    if (const JsonValue* point = member_of(action, "point_mm"); point != nullptr) {
        const bool fits =
            point->items.size() == 3 &&
            std::all_of(point->items.begin(), point->items.end(), [](const JsonValue& one) {
                return one.is(JsonValue::Kind::kNumber) && std::isfinite(one.number);
            });
        if (!fits) return user_error("`point_mm` is three numbers");
        of.point_mm = {point->items[0].number, point->items[1].number, point->items[2].number};
    }
    const Result<std::string> printed = graphs_.ask("openfl/look", of.source, text, &action);
    if (!printed) return printed.error();
    const Result<JsonValue> json = parse_json(*printed, "openflc");
    if (!json) return json.error();
    return looker_.look(of, *json);
}

}  // namespace openfab::viewer
