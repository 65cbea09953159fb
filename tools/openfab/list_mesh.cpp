// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/list_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/json_text.h"
#include "base/say.h"
#include "base/text.h"
#include "mesh/load/load_beams.h"
#include "mesh/load/load_mesh.h"
#include "mesh/load/pictures.h"
#include "tools/openfab/import_fields.h"

namespace openfab::tools {

namespace {

using mesh::BodyRole;
using mesh::LoadedBodies;
using mesh::LoadedMesh;
using mesh::Look;

Box3d box_of(const mesh::Mesh& mesh) {
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    return box;
}

const char* role_name(BodyRole role) {
    return role == BodyRole::kPart       ? "part"
           : role == BodyRole::kNegative ? "negative"
                                         : "not printed";
}

std::string hex(const std::array<double, 3>& linear) {
    return fmt::format("#{:02x}{:02x}{:02x}", linear_to_srgb8(linear[0]),
                       linear_to_srgb8(linear[1]), linear_to_srgb8(linear[2]));
}

/// The looks that some body uses, in their order.
std::vector<int32_t> used_looks(const LoadedBodies& loaded) {
    std::vector<int32_t> used;
    for (const LoadedMesh& body : loaded.bodies)
        used.insert(used.end(), body.look_of.begin(), body.look_of.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    if (!used.empty() && used[0] < 0) used.erase(used.begin());
    return used;
}

std::vector<std::pair<const char*, int64_t>> counts_of(const mesh::MeshChecks& checks) {
    std::vector<std::pair<const char*, int64_t>> counts = {
        {"open edges", checks.edges.open},
        {"non-manifold edges", checks.edges.non_manifold},
        {"edges of inconsistent triangles", checks.edges.inconsistent},
        {"triangles with equal corners, left out", checks.equal_corners},
        {"duplicate triangles, left out", checks.duplicates},
        {"triangles without area", checks.without_area},
        {"shells", checks.shells},
        {"shells inside out, flipped", checks.turned},
        {"cavities", checks.cavities},
        {"shells inside others that cut nothing out", checks.nested},
        {"pairs of shells that overlap", checks.overlapping},
        {checks.all_intersections ? "pairs of triangles that cross"
                                  : "or more pairs of triangles that cross",
         checks.intersections}};
    std::erase_if(counts, [](const auto& count) { return count.second <= 0; });
    return counts;
}

/// What a file holds.
struct Listed {
    LoadedBodies loaded;
    std::vector<mesh::LatticeInfo> lattices;
    std::vector<FieldFablet> level_sets;
    std::map<std::string, std::string> unreadable;  ///< pictures by their sources, and why
};

std::string look_text(const Listed& listed, const Look& look) {
    std::string text = look.name.empty() ? "without a name" : printable(look.name);
    if (look.color) text += " " + hex(*look.color);
    if (look.alpha < 1) text += fmt::format(", {:.0f} % opaque", 100 * look.alpha);
    if (look.vertex_colors) text += ", colours of its vertices";
    if (look.picture) {
        text += fmt::format(", picture {}", printable(look.picture->name));
        const auto why = listed.unreadable.find(look.picture->source);
        if (why != listed.unreadable.end())
            text += fmt::format(" (left out: {})", printable(why->second));
    }
    for (const auto& [part, share] : look.mixture)
        text += fmt::format(", {:.3g} % of look {}", 100 * share, part);
    return text;
}

void show_size(const Box3d& box, const std::string& indent) {
    if (box.empty()) return;
    const Vec3d size = box.size();
    show(fmt::format("{}size       {:.4g} x {:.4g} x {:.4g} mm, from {:.4g} {:.4g} {:.4g}\n",
                     indent, size.x, size.y, size.z, box.lo.x, box.lo.y, box.lo.z));
}

void show_body(const Listed& listed, const LoadedMesh& body, const std::string& indent) {
    const LoadedBodies& loaded = listed.loaded;
    show(fmt::format("{}triangles  {}, vertices {}\n", indent, body.mesh.triangles.size(),
                     body.mesh.positions.size()));
    show_size(box_of(body.mesh), indent);
    if (body.role != BodyRole::kPart)
        show(fmt::format("{}role       {}\n", indent, role_name(body.role)));
    if (body.depth > 0) show(fmt::format("{}inside     {} of the others\n", indent, body.depth));
    for (const mesh::MeshAttribute& attribute : body.mesh.attributes) {
        show(fmt::format("{}attribute  {}: {} {}\n", indent, printable(attribute.name),
                         attribute.components, attribute.is_int ? "int a face" : "float a corner"));
    }
    for (const auto& [name, number] : body.groups)
        show(fmt::format("{}group      {}: face {}\n", indent, printable(name), number));
    if (body.groups.empty() && !body.look_of.empty() && body.look_of[0] >= 0) {
        show(fmt::format("{}look       {}\n", indent,
                         look_text(listed, loaded.looks[static_cast<size_t>(body.look_of[0])])));
    }
    for (const auto& [what, count] : counts_of(body.checks))
        show(fmt::format("{}check      {} {}\n", indent, count, what));
    show(fmt::format("{}printable  {}\n", indent,
                     body.refusal.empty() ? "yes" : "no: " + printable(body.refusal)));
}

void show_others(const Listed& listed) {
    for (const mesh::LatticeInfo& lattice : listed.lattices) {
        show(fmt::format("lattice    {}: {} beams and balls\n", printable(lattice.name),
                         lattice.beams));
        show_size(lattice.box_mm, "  ");
        for (const std::string& set : lattice.sets)
            show(fmt::format("  set        {}\n", printable(set)));
    }
    for (const FieldFablet& set : listed.level_sets) {
        show(fmt::format("level set  {}\n", printable(set.name)));
        if (set.box_mm) show_size(*set.box_mm, "  ");
    }
}

void show_text(const std::string& name, const Listed& listed) {
    const LoadedBodies& loaded = listed.loaded;
    show(fmt::format("mesh       {}\n", printable(name)));
    show(fmt::format("unit       {:.6g} mm, {}\n", loaded.unit_mm, printable(loaded.unit_note)));
    show_others(listed);
    if (loaded.bodies.size() == 1) {
        show_body(listed, loaded.bodies[0], "");
    } else if (!loaded.bodies.empty()) {
        Box3d box;
        for (const LoadedMesh& body : loaded.bodies)
            box.add(box_of(body.mesh));
        show_size(box, "");
        show(fmt::format("bodies     {}\n", loaded.bodies.size()));
        for (const LoadedMesh& body : loaded.bodies) {
            show(fmt::format("body       {}\n", printable(body.body)));
            show_body(listed, body, "  ");
        }
    }
    for (const int32_t look : used_looks(loaded))
        show(fmt::format("look       {}: {}\n", look,
                         look_text(listed, loaded.looks[static_cast<size_t>(look)])));
    for (const auto& [a, b] : loaded.overlaps) {
        show(fmt::format("overlap    {} and {} share volume\n",
                         printable(loaded.bodies[static_cast<size_t>(a)].body),
                         printable(loaded.bodies[static_cast<size_t>(b)].body)));
    }
    for (const mesh::LeftOut& left : loaded.left_out)
        show(fmt::format("left out   {}\n", printable(mesh::describe(left))));
}

void json_box(const Box3d& box, JsonText* out) {
    const Vec3d size = box.empty() ? Vec3d{} : box.size();
    out->key("size_mm").begin_array().value(size.x).value(size.y).value(size.z).end_array();
    const Vec3d lo = box.empty() ? Vec3d{} : box.lo;
    out->key("from_mm").begin_array().value(lo.x).value(lo.y).value(lo.z).end_array();
}

void json_look(const Listed& listed, const Look& look, int32_t index, JsonText* out) {
    out->begin_object().member("index", index).member("name", look.name);
    if (look.color) out->member("color", hex(*look.color));
    out->member("opacity", look.alpha).member("vertex_colors", look.vertex_colors);
    if (look.picture) {
        out->member("picture", look.picture->name);
        const auto why = listed.unreadable.find(look.picture->source);
        if (why != listed.unreadable.end()) out->member("picture_left_out", why->second);
    }
    if (!look.mixture.empty()) {
        out->key("mixture").begin_array();
        for (const auto& [part, share] : look.mixture)
            out->begin_object().member("look", part).member("share", share).end_object();
        out->end_array();
    }
    out->end_object();
}

void json_body(const LoadedMesh& body, JsonText* out) {
    out->begin_object().member("name", body.body).member("role", role_name(body.role));
    out->member("triangles", static_cast<int64_t>(body.mesh.triangles.size()));
    out->member("vertices", static_cast<int64_t>(body.mesh.positions.size()));
    json_box(box_of(body.mesh), out);
    out->member("inside", body.depth);
    out->key("attributes").begin_array();
    for (const mesh::MeshAttribute& a : body.mesh.attributes)
        out->value(a.name);
    out->end_array().key("groups").begin_array();
    for (const auto& [name, number] : body.groups)
        out->begin_object().member("name", name).member("face", number).end_object();
    out->end_array().key("looks").begin_array();
    for (const int32_t look : body.look_of)
        out->value(look);
    out->end_array().key("checks").begin_object();
    for (const auto& [what, count] : counts_of(body.checks))
        out->member(what, count);
    out->end_object().member("printable", body.refusal.empty());
    if (!body.refusal.empty()) out->member("refusal", body.refusal);
    out->key("warnings").begin_array();
    for (const std::string& warning : body.warnings)
        out->value(warning);
    out->end_array().end_object();
}

void json_others(const Listed& listed, JsonText* out) {
    out->key("lattices").begin_array();
    for (const mesh::LatticeInfo& lattice : listed.lattices) {
        out->begin_object().member("name", lattice.name).member("beams", lattice.beams);
        json_box(lattice.box_mm, out);
        out->end_object();
    }
    out->end_array().key("level_sets").begin_array();
    for (const FieldFablet& set : listed.level_sets) {
        out->begin_object().member("name", set.name);
        if (set.box_mm) json_box(*set.box_mm, out);
        out->end_object();
    }
    out->end_array();
}

void show_json(const std::string& name, const Listed& listed) {
    const LoadedBodies& loaded = listed.loaded;
    JsonText out;
    out.begin_object().member("mesh", name).member("unit_mm", loaded.unit_mm);
    out.member("unit_from", loaded.unit_note).key("bodies").begin_array();
    for (const LoadedMesh& body : loaded.bodies)
        json_body(body, &out);
    out.end_array();
    json_others(listed, &out);
    out.key("looks").begin_array();
    for (const int32_t look : used_looks(loaded))
        json_look(listed, loaded.looks[static_cast<size_t>(look)], look, &out);
    out.end_array().key("overlaps").begin_array();
    for (const auto& [a, b] : loaded.overlaps) {
        out.begin_array().value(loaded.bodies[static_cast<size_t>(a)].body);
        out.value(loaded.bodies[static_cast<size_t>(b)].body).end_array();
    }
    out.end_array().key("left_out").begin_array();
    for (const mesh::LeftOut& left : loaded.left_out) {
        out.begin_object().member("what", left.what).member("count", left.count);
        out.member("place", left.place).member("remedy", left.remedy).end_object();
    }
    out.end_array().key("warnings").begin_array();
    for (const std::string& warning : loaded.warnings)
        out.value(warning);
    out.end_array().end_object();
    show(out.take() + "\n");
}

/// Finds the lattices and level sets of a file, which may be all that it has.
Result<void> add_others(const std::filesystem::path& file, const mesh::MeshOptions& load,
                        Result<LoadedBodies> loaded, Listed* out) {
    Result<mesh::LoadedLattices> lattices = mesh::load_lattices(
        file, {.unit_mm = load.unit_mm, .body = {}, .memory_bytes = load.memory_bytes});
    if (lattices && (loaded || !lattices->has_meshes))
        out->lattices = std::move(lattices->lattices);
    Result<ImportedFields> fields = load_fields(file, load, loaded ? &*loaded : nullptr);
    if (fields && (loaded || !fields->has_meshes)) out->level_sets = std::move(fields->level_sets);
    const bool others = !out->lattices.empty() || !out->level_sets.empty();
    if (!loaded && !others) return loaded.error();
    if (loaded) {
        out->loaded = std::move(*loaded);
    } else {
        out->loaded.unit_mm =
            lattices && !out->lattices.empty() ? lattices->unit_mm : fields->unit_mm;
        out->loaded.unit_note = load.unit_mm ? "given" : "as the file says";
    }
    // They are listed themselves.
    std::erase_if(out->loaded.left_out, [&](const mesh::LeftOut& one) {
        return (one.kind == mesh::LeftOutKind::kLattices && !out->lattices.empty()) ||
               (one.kind == mesh::LeftOutKind::kLevelSets && !out->level_sets.empty());
    });
    return {};
}

/// Finds the pictures that an import would leave out.
void look_for_pictures(const std::filesystem::path& file, int64_t memory_bytes, Listed* out) {
    std::set<std::string> named;
    for (const Look& look : out->loaded.looks) {
        if (look.picture) named.insert(look.picture->source);
    }
    const std::vector<std::string> sources(named.begin(), named.end());
    if (sources.empty()) return;
    const Result<void> read = mesh::read_pictures(
        file, sources, memory_bytes, [&](size_t i, const Result<std::string>& bytes) {
            if (!bytes) out->unreadable[sources[i]] = bytes.error().text();
        });
    if (!read) {
        for (const std::string& source : sources)
            out->unreadable[source] = read.error().text();
    }
}

}  // namespace

Result<void> list_mesh(const std::filesystem::path& file, const ListOptions& options) {
    mesh::MeshOptions load;
    load.name = file.stem().string();
    load.unit_mm = options.unit_mm;
    load.y_up = options.y_up;
    load.repair = options.repair;
    load.memory_bytes = options.memory_bytes;
    Listed listed;
    if (Result<void> added = add_others(file, load, mesh::read_bodies(file, load), &listed); !added)
        return added;
    look_for_pictures(file, load.memory_bytes, &listed);
    if (options.json) {
        show_json(load.name, listed);
        return {};
    }
    show_text(load.name, listed);
    for (const std::string& warning : listed.loaded.warnings)
        warn(warning);
    for (const LoadedMesh& body : listed.loaded.bodies) {
        for (const std::string& warning : body.warnings)
            warn(warning);
    }
    return {};
}

}  // namespace openfab::tools
