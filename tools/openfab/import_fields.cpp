// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/affine.h"
#include "base/input_file.h"
#include "base/json_text.h"
#include "base/text.h"
#include "mesh/load/jailed.h"
#include "mesh/read/threemf_shapes.h"
#include "tools/fields/function_text.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

// What is read of a 3MF comes out of a jail (base/jail.h); of each type one function for both ends.

void pass(JailLine* line, FieldMaterial* material) {
    pass(line, &material->uniform);
    pass(line, &material->name);
    pass(line, &material->color);
}

void pass(JailLine* line, FieldImage* image) {
    pass(line, &image->uniform);
    pass(line, &image->image);
    pass(line, &image->sheets);
    pass(line, &image->size);
    pass(line, &image->repeats);
    pass(line, &image->nearest);
}

void pass(JailLine* line, FieldMap* map) {
    pass(line, &map->uniform);
    pass(line, &map->source);
    pass(line, &map->wrap);
    pass(line, &map->nearest);
    for (const mesh::PictureWrap wrap : map->wrap)
        if (wrap < mesh::PictureWrap{} || wrap > mesh::PictureWrap::kNone) line->fail();
}

void pass(JailLine* line, FieldMesh* mesh) {
    pass(line, &mesh->uniform);
    pass(line, &mesh->name);
    pass(line, &mesh->obj);
    pass(line, &mesh->is_beams);
}

void pass(JailLine* line, FieldFablet* fablet) {
    pass(line, &fablet->name);
    pass(line, &fablet->fablet);
    pass(line, &fablet->source);
    pass(line, &fablet->box_mm);
    pass(line, &fablet->meshes);
    pass(line, &fablet->materials);
    pass(line, &fablet->inks);
    pass(line, &fablet->images);
    pass(line, &fablet->maps);
    pass(line, &fablet->most_displacement_mm);
    pass(line, &fablet->notes);
}

void pass(JailLine* line, ImportedFields* fields) {
    pass(line, &fields->level_sets);
    pass(line, &fields->volumes);
    pass(line, &fields->volume_of);
    pass(line, &fields->has_meshes);
    pass(line, &fields->unit_mm);
    pass(line, &fields->left_out);
    for (const int32_t volume : fields->volume_of)
        if (volume < -1 || volume >= static_cast<int64_t>(fields->volumes.size())) line->fail();
}

namespace {

namespace fs = std::filesystem;

/// What objects are that functions ask the distance of: void. No stock fablet, since shapes ask nothing that has a
/// `@Surface` stage.
constexpr const char* kAsked = "Asked";
constexpr const char* kAskedSource =
    "// What other objects ask the distance of: void itself.\n"
    "fablet Asked {\n"
    "    @Volume(@varying { VolumeAttributes attr })\n"
    "    {\n"
    "        MaterialComposition mc;\n"
    "        return mc;\n"
    "    }\n"
    "}\n";

/// A name for a fablet and its file.
std::string fablet_name(const std::string& wanted, Names* names) {
    std::string name = openfl_name(wanted);
    name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    return names->unique(name);
}

Affine3d to_part(double unit_mm, bool y_up) {
    Affine3d out;
    for (double& m : out.m)
        m *= unit_mm;
    if (!y_up) return out;
    return {{unit_mm, 0, 0, 0, 0, 0 - unit_mm, 0, unit_mm, 0}, {}};
}

Box3d box_of(const mesh::ThreemfObject& mesh, const Affine3d& map) {
    Box3d box;
    for (const mesh::ThreemfTriangle& t : mesh.triangles) {
        for (const int32_t v : t.vertices)
            box.add(map.apply(mesh.vertices[static_cast<size_t>(v)]));
    }
    return box;
}

/// Reads the functions of a file, and writes their fablets.
Result<ImportedFields> read_fields(const fs::path& file, const mesh::MeshOptions& options,
                                   const mesh::LoadedBodies* bodies) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return with_context(opened.error(), file.string() + ": ");
    const Result<std::string> bytes = opened->read_all(options.memory_bytes);
    if (!bytes) return with_context(bytes.error(), file.string() + ": ");
    Result<mesh::ReadThreemfShapes> read = mesh::parse_threemf_shapes(
        *bytes, file.string(), options.memory_bytes - static_cast<int64_t>(bytes->size()));
    if (!read) return read.error();
    ImportedFields out;
    out.has_meshes = read->has_meshes;
    out.unit_mm = options.unit_mm.value_or(read->root->unit_mm);
    out.left_out = std::move(read->left_out);
    const Affine3d to_mm = to_part(out.unit_mm, options.y_up);
    const std::string shown = file.filename().string();
    Names names;
    names.unique(kAsked);
    for (const mesh::ThreemfPlaced& one : read->level_sets) {
        std::string name = one.name;
        const auto function =
            one.model->fields.functions.find(one.object->level_set->field.function);
        if (name.empty() && read->level_sets.size() > 1 &&
            function != one.model->fields.functions.end())
            name = function->second.name;
        if (name.empty()) name = file.stem().string();
        Result<FieldFablet> made = level_set_fablet(one, to_mm, shown, fablet_name(name, &names));
        if (!made) return made.error();
        made->name = name;
        out.level_sets.push_back(std::move(*made));
    }
    if (bodies == nullptr || read->meshes.empty()) return out;
    // Readers of meshes do not say which object a body is: it lies where that does, and is as large.
    std::vector<Box3d> boxes;
    for (const mesh::ThreemfPlaced& one : read->meshes)
        boxes.push_back(box_of(*one.object, product(to_mm, one.map)));
    std::vector<int32_t> made_of(boxes.size(), -1);
    std::vector<bool> used(boxes.size(), false);
    for (const mesh::LoadedMesh& body : bodies->bodies) {
        out.volume_of.push_back(-1);
        Box3d box;
        for (const Vec3d& p : body.mesh.positions)
            box.add(p);
        const auto close = [&](const Box3d& other) {
            const Vec3d size = other.size();
            const double least = 1e-5 * (1 + std::max({size.x, size.y, size.z}));
            return length(box.lo - other.lo) <= least && length(box.hi - other.hi) <= least;
        };
        const auto found = std::ranges::find_if(boxes, close);
        if (found == boxes.end() || body.role != mesh::BodyRole::kPart) continue;
        const auto index = static_cast<size_t>(found - boxes.begin());
        used[index] = true;
        if (made_of[index] < 0) {
            Result<FieldFablet> made =
                mesh_fablet(read->meshes[index], to_mm, shown, fablet_name(body.body, &names));
            if (!made) return made.error();
            made->name = body.body;
            made_of[index] = static_cast<int32_t>(out.volumes.size());
            out.volumes.push_back(std::move(*made));
        }
        out.volume_of.back() = made_of[index];
    }
    for (size_t i = 0; i < used.size(); ++i) {
        if (!used[i])
            out.left_out.push_back({messages::kFieldsOfSeveralBodies, read->meshes[i].place(),
                                    messages::kFieldsOfSeveralBodiesHelp, 1});
    }
    return out;
}

}  // namespace

void ImportedFields::add_sources(std::set<std::string>* sources) const {
    for (const auto* list : {&level_sets, &volumes}) {
        for (const FieldFablet& field : *list) {
            for (const FieldImage& image : field.images)
                sources->insert(image.sheets.begin(), image.sheets.end());
            for (const FieldMap& map : field.maps)
                sources->insert(map.source);
        }
    }
}

Result<ImportedFields> load_fields(const fs::path& file, const mesh::MeshOptions& options,
                                   const mesh::LoadedBodies* bodies) {
    if (lower_ascii(file.extension().string()) != ".3mf") return ImportedFields();
    return read_in_jail<ImportedFields>(file, mesh::reading_limits(file, options.memory_bytes),
                                        [&] { return read_fields(file, options, bodies); });
}

void without_fields(std::vector<mesh::LeftOut>* left_out) {
    std::erase_if(*left_out, [](const mesh::LeftOut& one) {
        return one.kind == mesh::LeftOutKind::kLevelSets ||
               one.kind == mesh::LeftOutKind::kVolumetricData ||
               one.kind == mesh::LeftOutKind::kDisplacements;
    });
}

void bind_inks(ImportMaterials* materials, UniformTexts* uniforms) {
    materials->add_inks();
    for (const char* ink : {"cyan", "magenta", "yellow", "black"})
        uniforms->emplace_back(ink, json_string(materials->of(std::string("ink ") + ink, ink, {})));
    uniforms->emplace_back("white",
                           json_string(materials->of("white", "white", LinearColor{1, 1, 1})));
}

Result<void> FieldBinder::bind(const FieldFablet& field, ObjectText* object,
                               std::vector<ObjectText>* helpers) {
    object->fablet = field.fablet;
    for (const FieldMaterial& one : field.materials) {
        const std::string name = one.name.empty() ? object->name : one.name;
        object->uniforms.emplace_back(
            one.uniform,
            json_string(one.color ? materials_.of(fmt::format("field {} {}", one.name,
                                                              list_of(*one.color, number)),
                                                  one.name.empty() ? "material" : name, *one.color)
                                  : materials_.grey(name)));
    }
    if (field.inks) bind_inks(&materials_, &object->uniforms);
    for (const FieldImage& image : field.images) {
        const Result<std::string> texture = pictures_.add_volume(image);
        if (!texture) return texture.error();
        object->uniforms.emplace_back(image.uniform, json_string(*texture));
    }
    for (const FieldMap& map : field.maps) {
        const Result<std::string> texture = pictures_.add_map(map);
        if (!texture) return texture.error();
        object->uniforms.emplace_back(map.uniform, json_string(*texture));
    }
    if (field.most_displacement_mm > 0)
        object->most_displacement_mm = 1.0001 * field.most_displacement_mm;
    for (const FieldMesh& mesh : field.meshes) {
        const std::string name = field.fablet + "_" + mesh.name + (mesh.is_beams ? ".txt" : ".obj");
        files_.push_back({name, std::make_shared<const std::string>(mesh.obj)});
        const std::string text =
            mesh.is_beams ? fmt::format("{{\"beams\": {}}}", json_string(name))
                          : fmt::format("{{\"file\": {}, \"unit\": \"mm\"}}", json_string(name));
        if (mesh.uniform.empty()) {
            object->mesh = text;
            continue;
        }
        ObjectText helper;
        helper.name = names_.unique(object->name + " " + mesh.name);
        helper.mesh = text;
        helper.fablet = kAsked;
        helper.priority = object->priority;
        helper.support = false;
        object->uniforms.emplace_back(mesh.uniform, json_string(helper.name));
        helpers->push_back(std::move(helper));
    }
    // What is void takes no voxels from what asks about it.
    if (!helpers->empty()) object->priority += 1;
    if (!helpers->empty() && sources_.insert(kAsked).second) {
        files_.push_back(
            {std::string(kAsked) + ".fl", std::make_shared<const std::string>(kAskedSource)});
        world_.own_fablets.emplace_back(kAsked);
    }
    if (field.box_mm) {
        const auto corner = [](const Vec3d& v) {
            return list_of(std::array{v.x, v.y, v.z}, number);
        };
        object->mesh =
            fmt::format("{{\"shape\": {}, \"box_mm\": [{}, {}]}}", json_string(field.fablet),
                        corner(field.box_mm->lo), corner(field.box_mm->hi));
    }
    if (!sources_.insert(field.fablet).second) return {};
    files_.push_back({field.fablet + ".fl", std::make_shared<const std::string>(field.source)});
    world_.own_fablets.push_back(field.fablet);
    return {};
}

}  // namespace openfab::tools
