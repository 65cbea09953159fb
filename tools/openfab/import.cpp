// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "texture/nrrd_header.h"
#include "tools/openfab/import_looks.h"
#include "tools/openfab/import_notes.h"
#include "tools/openfab/importer.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace fs = std::filesystem;
using mesh::BodyRole;

Importer::Importer(const mesh::LoadedBodies& loaded, const Pictures& pictures,
                   const std::string& file, const ImportOptions& options)
    : loaded_(loaded),
      file_(file),
      options_(options),
      materials_(loaded.looks, options.mesh_colors),
      pictures_(pictures) {
    for (const mesh::LoadedMesh& body : loaded.bodies) {
        for (const Vec3d& p : body.mesh.positions)
            (body.role == BodyRole::kPart ? box_ : negative_box_).add(p);
    }
    for (const mesh::LatticeInfo& lattice : options.lattices)
        box_.add(lattice.box_mm);
    for (const FieldFablet& field : options.fields.level_sets) {
        if (field.box_mm) box_.add(*field.box_mm);
    }
    if (options.largest_mm) {
        const Vec3d size = box_.size();
        scale_ = *options.largest_mm / std::max({size.x, size.y, size.z});
    }
}

Result<Import> Importer::run() {
    Result<std::vector<BodyLook>> looks = choose_looks(loaded_, file_, options_, &out_.notes);
    if (!looks) return looks.error();
    looks_ = std::move(*looks);
    if (Result<void> bound = bind_profile(); !bound) return bound.error();
    for (size_t b = 0; b < loaded_.bodies.size(); ++b) {
        if (Result<void> bound = bind_body(b); !bound) return bound.error();
    }
    for (const mesh::LatticeInfo& lattice : options_.lattices)
        bind_lattice(lattice);
    for (const FieldFablet& field : options_.fields.level_sets) {
        ObjectText object;
        object.name = object_names_.unique(alone() ? fs::path(file_).stem().string() : field.name);
        if (Result<void> bound = bind_field(field, &object); !bound) return bound.error();
    }
    if (materials_.lines().size() > kMostMaterials) return too_many_materials();
    for (ImportedFile& file : pictures_.files())
        out_.files.push_back(std::move(file));
    for (const auto& [fablet, counts] : lists_.fablets()) {
        out_.fablets.push_back(fablet);
        out_.files.push_back({fmt::format("stock_{}.fl", fablet),
                              std::make_shared<const std::string>(source_of(fablet))});
    }
    out_.world = world();
    for (const std::string& name : text_.own_fablets)
        out_.fablets.push_back(name);
    if (shares_one_) {
        out_.notes.push_back(
            fmt::format(messages::kBodiesShareMaterial, file_, loaded_.bodies.size()));
    }
    add_notes(loaded_, file_,
              {options_.y_up, options_.largest_mm ? std::optional(scale_) : std::nullopt},
              &out_.notes);
    return std::move(out_);
}

bool Importer::alone() const {
    return loaded_.bodies.size() + options_.lattices.size() + options_.fields.level_sets.size() ==
           1;
}

std::string Importer::what(const mesh::LoadedMesh& body) const {
    return alone() ? file_ : fmt::format(messages::kBodyOf, file_, body.body);
}

Result<void> Importer::bind_body(size_t b) {
    const mesh::LoadedMesh& body = loaded_.bodies[b];
    BodyLook& look = looks_[b];
    ObjectText object;
    object.name = object_names_.unique(alone() ? fs::path(file_).stem().string() : body.body);
    object.mesh = mesh_text(body);
    object.fablet = look.fablet;
    object.repair = options_.repair && is_part(b);
    if (is_part(b)) {
        object.priority = body.depth;
    } else {
        object.priority = most_depth() + 1;
        object.support = false;
    }
    if (const FieldFablet* field = field_of(b)) return bind_field(*field, &object);
    uniforms_ = &object.uniforms;
    Result<void> bound = is_part(b) ? bind_fablet(body, &look) : bind_void();
    if (!bound) return bound;
    objects_.push_back(std::move(object));
    return {};
}

const FieldFablet* Importer::field_of(size_t b) const {
    const ImportedFields& fields = options_.fields;
    if (b >= fields.volume_of.size() || fields.volume_of[b] < 0) return nullptr;
    return &fields.volumes[static_cast<size_t>(fields.volume_of[b])];
}

Result<void> Importer::bind_field(const FieldFablet& field, ObjectText* object) {
    std::vector<ObjectText> helpers;
    if (Result<void> bound = fields_.bind(field, object, &helpers); !bound) return bound;
    objects_.push_back(std::move(*object));
    for (ObjectText& helper : helpers)
        objects_.push_back(std::move(helper));
    out_.notes.insert(out_.notes.end(), field.notes.begin(), field.notes.end());
    return {};
}

void Importer::bind_lattice(const mesh::LatticeInfo& lattice) {
    ObjectText object;
    object.name = object_names_.unique(alone() ? fs::path(file_).stem().string() : lattice.name);
    object.mesh = fmt::format("{{\"beams\": {}", json_string(file_));
    if (options_.lattices.size() > 1)
        object.mesh += fmt::format(", \"body\": {}", json_string(lattice.name));
    object.mesh += unit_text() + "}";
    object.fablet = "beams";
    lists_.use(object.fablet);
    std::vector<std::string> names;
    if (options_.one_material) {
        names.push_back(materials_.of("one", "material", kWhite));
    } else {
        names.push_back(materials_.grey(alone() ? "material" : lattice.name));
        for (const std::string& set : lattice.sets)
            names.push_back(materials_.grey(set.empty() ? "set" : set));
    }
    bind_materials(object.fablet, names);
    objects_.push_back(std::move(object));
}

int32_t Importer::most_depth() const {
    int32_t most = 0;
    for (const mesh::LoadedMesh& body : loaded_.bodies)
        most = std::max(most, body.depth);
    return most;
}

void Importer::uniform(const std::string& name, const std::string& value) {
    uniforms_->emplace_back(name, value);
}

void Importer::material(const char* name, const char* wanted, const LinearColor& color) {
    uniform(name, json_string(materials_.of(wanted, wanted, color)));
}

Result<void> Importer::bind_void() {
    bind_materials("solid", {"VOID"});
    return {};
}

Result<void> Importer::bind_profile() {
    if (options_.profile.empty()) return {};
    const auto bad = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadFile, options_.profile));
    };
    const Result<InputFile> file = InputFile::open(options_.profile);
    if (!file) return bad(file.error());
    // INK_NODES of stdlib/color.fl along each axis.
    constexpr const char* kSizes = "4 33 33 33";
    const Result<texture::NrrdHeader> header = texture::read_nrrd_header(*file);
    if (!header || header->field("sizes") != kSizes || !header->data_file().empty()) {
        return bad(user_error(messages::kNoTableOfInks, messages::kNoTableOfInksHelp));
    }
    Result<std::string> bytes = file->read_all(options_.memory_bytes);
    if (!bytes) return bad(bytes.error());
    profile_ =
        pictures_.add_file("inks", ".nrrd", std::make_shared<const std::string>(std::move(*bytes)));
    return {};
}

void Importer::bind_materials(const std::string& fablet, const std::vector<std::string>& names) {
    std::vector<std::string> texts;
    for (const std::string& name : names)
        texts.push_back(json_string(name));
    lists_.add(objects_.size(), fablet, "materials", std::move(texts));
}

std::string Importer::source_of(const std::string& fablet) const {
    const ImportLists::Counts& counts = lists_.fablets().at(fablet);
    std::string source(stock_text(fmt::format("stock_{}.fl", fablet)));
    set_stock_constant("GROUPS", counts.groups, &source);
    set_stock_constant("MAPS", counts.maps, &source);
    set_stock_constant("PARTS", counts.parts, &source);
    if (!options_.profile.empty() && find_stock_fablet(fablet)->inks) mix_by_profile(&source);
    return source;
}

std::string Importer::unit_text() const {
    if (loaded_.unit_note == "as the file says") return {};
    static const std::map<double, const char*> kNames = {
        {1, "mm"}, {10, "cm"}, {1000, "m"}, {0.001, "um"}, {25.4, "in"}};
    const auto found = kNames.find(loaded_.unit_mm);
    return found != kNames.end() ? fmt::format(", \"unit\": \"{}\"", found->second) : "";
}

std::string Importer::mesh_text(const mesh::LoadedMesh& body) const {
    std::string text = fmt::format("{{\"file\": {}", json_string(file_));
    if (!alone()) text += fmt::format(", \"body\": {}", json_string(body.body));
    text += unit_text();
    if (options_.y_up) text += ", \"up\": \"y\"";
    const Vec3d& at = loaded_.origin_mm;
    if (at != Vec3d{})
        text += fmt::format(", \"origin_mm\": {}", list_of(std::array{at.x, at.y, at.z}, number));
    return text + "}";
}

std::string Importer::world() {
    lists_.write(&objects_);
    WorldText& text = text_;
    text.printer = options_.printer;
    text.fablets = out_.fablets;
    text.materials = materials_.lines();
    text.textures = pictures_.lines();
    text.objects = std::move(objects_);
    text.group = fs::path(file_).stem().string();
    text.scale = scale_;
    // What cuts may reach below what stands on the bed.
    if (!negative_box_.empty())
        text.translate = fmt::format("[0, 0, {}]", number(0 - box_.lo.z * scale_));
    return text.str();
}

Error Importer::too_many_materials() const {
    return user_error(
        fmt::format(messages::kTooManyMaterials, file_, materials_.lines().size(), kMostMaterials));
}

Result<Import> make_import(const mesh::LoadedBodies& loaded, const Pictures& pictures,
                           const std::string& file, const ImportOptions& options) {
    return Importer(loaded, pictures, file, options).run();
}

}  // namespace openfab::tools
