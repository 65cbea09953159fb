// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/extents.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "base/json.h"
#include "base/own_folder.h"
#include "base/polar.h"
#include "base/start_program.h"
#include "base/talking_program.h"
#include "client/child.h"
#include "mesh/model/primitives.h"
#include "tools/openfab/messages.h"
#include "world/placed_box.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostExtents = 1 << 28;  // bytes

/// Returns what the world's print program writes.
Result<JsonValue> ask(const std::string& file, const WorldOptions& options) {
    const Result<fs::path> programs = program_folder();
    if (!programs) return programs.error();
    const auto folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const fs::path out = (*folder)->path() / "extents.json";
    std::vector<std::string> argv{(*programs / "openfab").string(),
                                  "print",
                                  file,
                                  "--extents",
                                  out.string(),
                                  "--progress",
                                  "plain"};
    if (!options.memory.empty()) argv.insert(argv.end(), {"--memory", options.memory});
    for (const std::string& one : options.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& one : options.settings)
        argv.push_back("--set=" + one);
    const Result<void> done =
        client::run(argv, (*folder)->path() / "extents.out", (*folder)->path() / "extents.err");
    if (!done) return done.error();
    const Result<std::string> text = read_text_file(out, kMostExtents);
    if (!text) return text.error();
    return parse_json(*text, out.string());
}

Vec3d corner_of(const JsonValue& value) {
    Vec3d out;
    for (size_t a = 0; a < 3 && a < value.items.size(); ++a)
        out[static_cast<int>(a)] = value.items[a].number;
    return out;
}

Box3d box_member(const JsonValue& one, const char* key) {
    const JsonMember* found = one.find(key);
    if (found == nullptr || found->value.items.size() != 2) return {};
    return {corner_of(found->value.items[0]), corner_of(found->value.items[1])};
}

mesh::Mesh box_mesh(const Box3d& box) {
    mesh::Mesh out = mesh::make_box(box.size());
    const Vec3d middle{(box.lo.x + box.hi.x) / 2, (box.lo.y + box.hi.y) / 2, box.lo.z};
    for (Vec3d& p : out.positions)
        p = p + middle;
    return out;
}

}  // namespace

Result<void> find_extents(const std::string& file, const WorldOptions& options,
                          world::World* world) {
    const bool any = std::any_of(
        world->build.begin(), world->build.end(),
        [&](const world::Placement& placed) { return world::asks_solid(*world, placed); });
    if (!any && options.settings.empty()) return {};
    const Result<JsonValue> told = ask(file, options);
    if (!told) return told.error();
    if (told->items.size() != world->build.size())
        return internal_error(
            fmt::format(messages::kExtentsOfOthers, told->items.size(), world->build.size()));
    std::map<int32_t, Box3d> of_mesh;  // by object, in its own space
    for (size_t i = 0; i < world->build.size(); ++i) {
        const JsonValue& one = told->items[i];
        const JsonMember* at = one.find("at_mm");
        if (!one.is(JsonValue::Kind::kObject) || at == nullptr) continue;
        world::Placement& placed = world->build[i];
        placed.transform.t = corner_of(at->value);
        placed.extent = box_member(one, "extent_mm");
        placed.own_extent = box_member(one, "own_mm");
        const Result<PolarFactors> polar = polar_factors(placed.transform.m);
        if (!polar || placed.piece >= 0) continue;
        // Shapes are scaled along their axes alone.
        const std::array<double, 9>& s = polar->s;
        const Box3d& own = *placed.own_extent;
        of_mesh[placed.object].add(Box3d{{own.lo.x / s[0], own.lo.y / s[4], own.lo.z / s[8]},
                                         {own.hi.x / s[0], own.hi.y / s[4], own.hi.z / s[8]}});
    }
    for (const auto& [object, box] : of_mesh) {
        world->objects[static_cast<size_t>(object)].mesh =
            static_cast<int32_t>(world->meshes.size());
        world->meshes.push_back(box_mesh(box));
    }
    return {};
}

}  // namespace openfab::tools
