// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "backends/common/output_file.h"
#include "base/input_file.h"
#include "base/json.h"
#include "mechanics/messages.h"
#include "mechanics/model/absolute_paths.h"
#include "mechanics/model/print_world.h"

namespace openfab::mechanics {

namespace fs = std::filesystem;

void write_absolute(const JsonValue& value, const fs::path& folder, JsonText* out) {
    if (value.is(JsonValue::Kind::kArray)) {
        out->begin_array();
        for (const JsonValue& one : value.items)
            write_absolute(one, folder, out);
        out->end_array();
    } else if (value.is(JsonValue::Kind::kObject)) {
        out->begin_object();
        for (const JsonMember& one : value.members) {
            out->key(one.key);
            const bool path = one.key == "file" || one.key == "source" || one.key == "transforms" ||
                              one.key == "beams" || one.key == "polygons";
            if (path && one.value.is(JsonValue::Kind::kString))
                out->value((folder / one.value.text).string());
            else
                write_absolute(one.value, folder, out);
        }
        out->end_object();
    } else {
        out->value(value);
    }
}

namespace {

constexpr size_t kMostObjectWorldBytes = 16 << 20;
constexpr const char* kSolidFablet = R"(fablet OpenfabSolid {
    @uniform { Material stuff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(stuff, 1);
        return mc;
    }
}
)";

/// Placements of one object in a world with groups in groups.
class Placements {
  public:
    Placements(const JsonValue& world, const std::string& object, const fs::path& folder)
        : object_(object), folder_(folder) {
        const JsonMember* groups = world.find("groups");
        if (!groups) return;
        // Until nothing is found any more: a group may name one that stands behind it.
        for (bool more = true; more;) {
            more = false;
            for (const JsonMember& m : groups->value.members)
                if (!groups_.contains(m.key) &&
                    std::ranges::any_of(m.value.items, [&](auto& one) { return has(one); })) {
                    groups_.insert(m.key);
                    more = true;
                }
        }
    }
    bool has(const JsonValue& item) const {
        const JsonMember* object = item.find("object");
        const JsonMember* group = item.find("group");
        return (object && object->value.text == object_) ||
               (group && groups_.contains(group->value.text));
    }
    bool in_group(const std::string& name) const { return groups_.contains(name); }
    void write(const JsonValue& items, JsonText* out) const {
        out->begin_array();
        for (const JsonValue& item : items.items) {
            if (!has(item)) continue;
            out->begin_object();
            for (const JsonMember& m : item.members) {
                if (m.key == "uniforms") continue;
                out->key(m.key);
                JsonValue one;
                // A path stands in it, so that it is made absolute with its key.
                if (m.key == "transforms" && m.value.is(JsonValue::Kind::kString))
                    out->value((folder_ / m.value.text).string());
                else
                    write_absolute(m.value, folder_, out);
            }
            out->end_object();
        }
        out->end_array();
    }

  private:
    std::string object_;
    fs::path folder_;
    std::set<std::string> groups_;
};

}  // namespace

Result<std::string> object_world(const fs::path& input, const std::string& object,
                                 const fs::path& scratch) {
    const Result<std::string> text = read_text_file(input, kMostObjectWorldBytes);
    if (!text) return text.error();
    const Result<JsonValue> world = parse_json(*text, input.string());
    if (!world) return world.error();
    const JsonMember* objects = world->find("objects");
    const JsonMember* materials = world->find("materials");
    const JsonMember* build = world->find("build");
    if (!objects || !build || !materials || materials->value.members.empty())
        return user_error(fmt::format(messages::kNoObjectsOrMaterials, input.string()));
    if (!objects->value.find(object)) {
        std::string names;
        for (const JsonMember& m : objects->value.members)
            names += (names.empty() ? "" : ", ") + m.key;
        return user_error(fmt::format(messages::kNoSuchObject, object, names));
    }
    if (world->find("arrange"))
        return user_error(fmt::format(messages::kArrangedBuild, object),
                          messages::kArrangedBuildHelp);
    const fs::path folder = fs::absolute(input).parent_path();
    const fs::path solid = scratch / "openfab_solid.fl";
    if (Result<void> done = backends::write_whole_file(solid, std::string(kSolidFablet)); !done)
        return done.error();
    const Placements placements(*world, object, folder);
    JsonText out;
    out.begin_object();
    for (const JsonMember& one : world->members) {
        if (one.key == "objects" || one.key == "build" || one.key == "groups" ||
            one.key == "fablets" || one.key == "$schema" || one.key == "cases" ||
            one.key == "support" || one.key == "tray")
            continue;
        out.key(one.key);
        write_absolute(one.value, folder, &out);
    }
    out.key("fablets").begin_object();
    if (const JsonMember* fablets = world->find("fablets"))
        for (const JsonMember& one : fablets->value.members) {
            out.key(one.key);
            write_absolute(one.value, folder, &out);
        }
    out.key("openfab_solid").begin_object();
    out.member("source", solid.string()).member("fablet", "OpenfabSolid");
    out.end_object().end_object();
    out.key("objects").begin_object();
    for (const JsonMember& one : objects->value.members) {
        if (one.key != object) continue;
        out.key(one.key).begin_object();
        for (const JsonMember& m : one.value.members) {
            if (m.key != "mesh" && m.key != "pieces" && m.key != "repair") continue;
            out.key(m.key);
            write_absolute(m.value, folder, &out);
        }
        out.member("fablet", "openfab_solid").key("uniforms").begin_object();
        out.member("stuff", materials->value.members[0].key).end_object().end_object();
    }
    out.end_object();
    bool placed = false;
    for (const JsonValue& item : build->value.items)
        placed = placed || placements.has(item);
    if (const JsonMember* groups = world->find("groups"); groups && placed) {
        out.key("groups").begin_object();
        for (const JsonMember& m : groups->value.members)
            if (placements.in_group(m.key)) {
                out.key(m.key);
                placements.write(m.value, &out);
            }
        out.end_object();
    }
    out.key("build");
    if (placed)
        placements.write(build->value, &out);
    else
        out.begin_array().begin_object().member("object", object).end_object().end_array();
    out.end_object();
    return out.take();
}

}  // namespace openfab::mechanics
