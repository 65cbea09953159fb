// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/part_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/affine.h"
#include "tools/viewer/messages.h"
#include "world/edit/world_edit.h"
#include "world/printer.h"

namespace openfab::viewer {

namespace {

constexpr size_t kMostEdits = 1000;
constexpr size_t kMostHistorySteps = 100;
constexpr size_t kMostPathNames = 6;

/// What may be changed: `*` is any name, and `#` the number of an item; a last `*` also all that is below.
constexpr std::array<std::string_view, 11> kPlaces{
    "printer",       "materials/*",        "materials/*/key",     "materials/*/preview",
    "meshes/*/unit", "meshes/*/up",        "objects/*/repair",    "objects/*/uniforms/*",
    "build/#/scale", "build/#/rotate_deg", "build/#/translate_mm"};
constexpr std::string_view kGrid = "build/#/grid";

bool fits(std::string_view place, const std::vector<std::string>& path) {
    size_t i = 0;
    for (size_t at = 0; at <= place.size(); ++i) {
        const size_t end = std::min(place.find('/', at), place.size());
        const std::string_view name = place.substr(at, end - at);
        at = end + 1;
        if (i >= path.size()) return false;
        const bool digits =
            !path[i].empty() && path[i].find_first_not_of("0123456789") == std::string::npos;
        if (name == "#" ? !digits : name != "*" && name != path[i]) return false;
    }
    return i == path.size();
}

Result<std::vector<std::string>> path_of(const JsonValue& edit) {
    const JsonValue* path = member_of(edit, "path");
    std::vector<std::string> out;
    if (path != nullptr) {
        for (const JsonValue& one : path->items) {
            const bool whole = one.is(JsonValue::Kind::kNumber) && one.number >= 0 &&
                               one.number < 1e6 && one.number == std::floor(one.number);
            out.push_back(whole ? fmt::format("{}", static_cast<int>(one.number)) : one.text);
        }
    }
    const bool may =
        out.size() <= kMostPathNames &&
        (fits(kGrid, out) || std::any_of(kPlaces.begin(), kPlaces.end(),
                                         [&](std::string_view place) { return fits(place, out); }));
    if (!may) return user_error(messages::kNotOfThePart);
    return out;
}

/// Spaced as people write it.
std::string spaced(const JsonValue& value) {
    std::string out;
    if (value.is(JsonValue::Kind::kObject)) {
        for (const JsonMember& member : value.members) {
            out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", json_string(member.key),
                               spaced(member.value));
        }
        return "{" + out + "}";
    }
    if (value.is(JsonValue::Kind::kArray)) {
        for (const JsonValue& item : value.items)
            out += (out.empty() ? "" : ", ") + spaced(item);
        return "[" + out + "]";
    }
    JsonText text;
    text.value(value);
    return text.take();
}

/// The box of a placement in the build, and the middle of its mesh in part space, which is scaled but not turned.
std::pair<Box3d, Vec3d> extent_of(const world::World& world, const world::Placement& placement) {
    Box3d box;
    Box3d own;
    const world::Object& object = world.objects[static_cast<size_t>(placement.object)];
    for (const Vec3d& p : world.meshes[static_cast<size_t>(object.mesh)].positions) {
        box.add(placement.transform.apply(p));
        own.add(p);
    }
    if (placement.extent) box = *placement.extent;
    Vec3d middle = own.empty() ? Vec3d{} : own.center();
    for (size_t a = 0; a < 3; ++a) {
        const auto& m = placement.transform.m;
        middle[static_cast<int>(a)] *= std::hypot(m[a], m[3 + a], m[6 + a]);
    }
    return {box, middle};
}

}  // namespace

Result<std::string> part_edited(const std::string& text, const std::string& name,
                                const JsonValue& edits) {
    if (!edits.is(JsonValue::Kind::kArray) || edits.items.empty() ||
        edits.items.size() > kMostEdits)
        return user_error(messages::kNotOfThePart);
    Result<world::WorldEdit> world = world::WorldEdit::of_text(text, name);
    if (!world) return world.error();
    for (const JsonValue& edit : edits.items) {
        const Result<std::vector<std::string>> path = path_of(edit);
        if (!path) return path.error();
        const JsonValue* value = member_of(edit, "value");
        const std::vector<std::string> printers = world::printer_names();
        if (path->front() == "printer" &&
            (value == nullptr ||
             std::find(printers.begin(), printers.end(), value->text) == printers.end()))
            return user_error(messages::kNoSuchPrinter);
        const Result<void> done =
            value == nullptr ? world->remove_at(*path) : world->set_at(*path, spaced(*value));
        if (!done) return done.error();
    }
    return world->text();
}

void describe_part(const std::string& text, const world::World* world, JsonText* out) {
    out->begin_object().key("printers").begin_array();
    for (const std::string& printer : world::printer_names())
        out->value(printer);
    out->end_array();
    const Result<JsonValue> tree = parse_json(text, "world");
    if (!tree) {
        out->end_object();
        return;
    }
    for (const char* key : {"printer", "materials", "meshes", "objects", "build"}) {
        if (const JsonValue* found = member_of(*tree, key)) out->key(key).value(*found);
    }
    out->key("sizes_mm").begin_array();
    std::vector<Vec3d> middles;
    const JsonValue* build = member_of(*tree, "build");
    for (size_t i = 0; build != nullptr && world != nullptr && i < build->items.size(); ++i) {
        // The placements of an item are in its order; the first is as large as its copies.
        const auto of = std::find_if(world->build.begin(), world->build.end(),
                                     [&](const world::Placement& one) {
                                         return one.location.line == build->items[i].line &&
                                                one.location.column == build->items[i].column;
                                     });
        const JsonValue* object = member_of(build->items[i], "object");
        const auto [box, middle] = of == world->build.end() || object == nullptr
                                       ? std::pair<Box3d, Vec3d>()
                                       : extent_of(*world, *of);
        middles.push_back(middle);
        if (box.empty()) {
            out->null();
            continue;
        }
        const Vec3d size = box.size();
        out->begin_array().value(size.x).value(size.y).value(size.z).end_array();
    }
    out->end_array().key("middles_mm").begin_array();
    for (const Vec3d& middle : middles)
        out->begin_array().value(middle.x).value(middle.y).value(middle.z).end_array();
    out->end_array().end_object();
}

void PartHistory::record(std::string before, std::string after) {
    steps_.resize(done_);
    steps_.push_back({std::move(before), std::move(after)});
    if (steps_.size() > kMostHistorySteps) steps_.erase(steps_.begin());
    done_ = steps_.size();
}

bool PartHistory::can_step(const std::string& now, bool forward) const {
    if (forward) return done_ < steps_.size() && steps_[done_].before == now;
    return done_ > 0 && steps_[done_ - 1].after == now;
}

std::optional<std::string> PartHistory::step(const std::string& now, bool forward) {
    if (!can_step(now, forward)) return {};
    if (forward) return steps_[done_++].after;
    return steps_[--done_].before;
}

}  // namespace openfab::viewer
