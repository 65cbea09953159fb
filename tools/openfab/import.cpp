// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>

#include "base/input_file.h"
#include "base/json.h"
#include "texture/nrrd_header.h"
#include "tools/openfab/import_choice.h"
#include "tools/openfab/import_lists.h"
#include "tools/openfab/import_looks.h"
#include "tools/openfab/import_materials.h"
#include "tools/openfab/import_notes.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using mesh::BodyRole;

constexpr size_t kMostMaterials = 254;
constexpr LinearColor kWhite{1, 1, 1};

/// The alpha of a picture from which on it covers; -1: as much as its alpha. Of an opaque one that
/// ends there is nothing beyond its edge, which only its alpha tells.
double cutoff_of(const std::optional<mesh::PictureUse>& use) {
    if (!use || use->alpha == mesh::PictureUse::Alpha::kBlend) return -1;
    if (use->alpha == mesh::PictureUse::Alpha::kMask) return use->mask_from;
    const bool ends =
        use->wrap[0] == mesh::PictureWrap::kNone || use->wrap[1] == mesh::PictureWrap::kNone;
    return ends ? -1 : 0;
}

class Importer {
  public:
    Importer(const mesh::LoadedBodies& loaded, const Pictures& pictures, const std::string& file,
             const ImportOptions& options)
        : loaded_(loaded),
          file_(file),
          options_(options),
          materials_(loaded.looks),
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

    Result<Import> run() {
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
            object.name =
                object_names_.unique(alone() ? fs::path(file_).stem().string() : field.name);
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
                fmt::format("`{}` has {} bodies, more than a world has materials: those without "
                            "one of their own share one",
                            file_, loaded_.bodies.size()));
        }
        add_notes(loaded_, file_, {options_.y_up, options_.largest_mm.has_value()}, &out_.notes);
        return std::move(out_);
    }

  private:
    bool is_part(size_t b) const { return loaded_.bodies[b].role == BodyRole::kPart; }
    bool alone() const {
        return loaded_.bodies.size() + options_.lattices.size() +
                   options_.fields.level_sets.size() ==
               1;
    }
    /// The file, and the body where there are several, for messages.
    std::string what(const mesh::LoadedMesh& body) const {
        return alone() ? file_ : fmt::format("{}: body `{}`", file_, body.body);
    }

    // --- what is bound -------------------------------------------------------------------------

    Result<void> bind_body(size_t b) {
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

    /// The fablet of a body's volumetric data, or null.
    const FieldFablet* field_of(size_t b) const {
        const ImportedFields& fields = options_.fields;
        if (b >= fields.volume_of.size() || fields.volume_of[b] < 0) return nullptr;
        return &fields.volumes[static_cast<size_t>(fields.volume_of[b])];
    }

    Result<void> bind_field(const FieldFablet& field, ObjectText* object) {
        std::vector<ObjectText> helpers;
        if (Result<void> bound = fields_.bind(field, object, &helpers); !bound) return bound;
        objects_.push_back(std::move(*object));
        for (ObjectText& helper : helpers)
            objects_.push_back(std::move(helper));
        out_.notes.insert(out_.notes.end(), field.notes.begin(), field.notes.end());
        return {};
    }

    /// One material, or one for each beam set and for beams in none.
    void bind_lattice(const mesh::LatticeInfo& lattice) {
        ObjectText object;
        object.name =
            object_names_.unique(alone() ? fs::path(file_).stem().string() : lattice.name);
        object.mesh = fmt::format("{{\"beams\": {}", json_text(file_));
        if (options_.lattices.size() > 1)
            object.mesh += fmt::format(", \"body\": {}", json_text(lattice.name));
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

    int32_t most_depth() const {
        int32_t most = 0;
        for (const mesh::LoadedMesh& body : loaded_.bodies)
            most = std::max(most, body.depth);
        return most;
    }

    void uniform(const std::string& name, const std::string& value) {
        uniforms_->emplace_back(name, value);
    }
    void material(const char* name, const char* wanted, const LinearColor& color) {
        uniform(name, json_text(materials_.of(wanted, wanted, color)));
    }

    Result<void> bind_void() {
        bind_materials("solid", {"VOID"});
        return {};
    }

    /// Binds the uniforms of a stock fablet: one function a row of the table of them.
    using Bind = Result<void> (Importer::*)(const mesh::LoadedMesh&, BodyLook*);
    static const std::array<Bind, std::size(kStockFablets)> kBinds;

    Result<void> bind_fablet(const mesh::LoadedMesh& body, BodyLook* look) {
        const std::string& f = look->fablet;
        lists_.use(f);
        const StockFablet& stock = *find_stock_fablet(f);
        const Bind bind = kBinds[static_cast<size_t>(&stock - kStockFablets)];
        if (Result<void> bound = (this->*bind)(body, look); !bound) return bound;
        if (!stock.inks) return {};
        if (!profile_.empty()) uniform("profile", json_text(profile_));
        bind_inks(&materials_, uniforms_);
        return {};
    }

    /// Of a body in part space.
    Box3d box_of(const mesh::LoadedMesh& body) const {
        Box3d box;
        for (const Vec3d& p : body.mesh.positions)
            box.add(p);
        box.lo = box.lo * scale_, box.hi = box.hi * scale_;
        return box;
    }

    std::string material_of(const mesh::LoadedMesh& body, const GroupLook& group) {
        if (options_.one_material) return materials_.of("one", "material", kWhite);
        if (group.look >= 0) return materials_.of_look(group.look);
        // One material of its own, where there are that many.
        if (loaded_.bodies.size() + loaded_.looks.size() > kMostMaterials) {
            shares_one_ = true;
            return materials_.of("none", "material", kWhite);
        }
        const std::string name = alone() ? "material" : body.body;
        const auto [known, fresh] = own_.try_emplace(&body);
        if (fresh) known->second = materials_.grey(name);
        return known->second;
    }

    Result<void> bind_solid(const mesh::LoadedMesh& body, BodyLook* look) {
        std::vector<std::string> names;
        for (const GroupLook& group : look->groups)
            names.push_back(material_of(body, group));
        if (options_.one_material) names.resize(1);
        bind_materials("solid", names);
        return {};
    }

    Result<void> bind_graded(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
        const Box3d box = box_of(body);
        uniform("low", number(box.lo.z));
        uniform("high", number(box.hi.z));
        material("bottom", "white", kWhite);
        material("top", "black", {});
        return {};
    }

    Result<void> bind_shell(const mesh::LoadedMesh& /*body*/, BodyLook* /*look*/) {
        material("skin", "white", kWhite);
        material("core", "black", {});
        return {};
    }

    Result<void> bind_lattice(const mesh::LoadedMesh& /*body*/, BodyLook* /*look*/) {
        material("material", "white", kWhite);
        uniform("filler", "\"VOID\"");
        return {};
    }

    Result<void> bind_infill(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
        const Vec3d middle = box_of(body).center();
        uniform("drain", list_of(std::array{middle.x, middle.y, middle.z}, number));
        material("material", "white", kWhite);
        uniform("filler", "\"VOID\"");
        uniform("barrier", "\"VOID\"");
        return {};
    }

    Result<void> bind_relief(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
        if (Result<void> bound = bind_first_picture(body, false, true); !bound) return bound;
        material("material", "white", kWhite);
        return {};
    }

    Result<void> bind_mixed(const mesh::LoadedMesh& body, BodyLook* look) {
        ImportLists::Mixture mixture;
        for (const GroupLook& group : look->groups) {
            mixture.emplace_back();
            if (group.mixture.empty()) mixture.back().emplace_back(material_of(body, group), 1);
            for (const auto& [part, share] : group.mixture)
                mixture.back().emplace_back(materials_.of_look(part), share);
        }
        lists_.add_mixture(objects_.size(), std::move(mixture));
        return {};
    }

    /// Textured or painted.
    Result<void> bind_skins(const mesh::LoadedMesh& body, BodyLook* look) {
        const std::string& f = look->fablet;
        materials_.add_inks();  // before others, for their names and keys
        std::vector<std::string> bases, maps;
        std::map<std::string, int> places;  // in maps
        std::vector<std::array<double, 4>> tints;
        std::vector<int> map_of, multiply;
        std::vector<double> cutoff;
        for (GroupLook& group : look->groups) {
            const Result<std::string> texture = texture_of(group);
            if (!texture) return texture.error();
            int map = -1;
            if (!texture->empty()) {
                const auto [known, fresh] =
                    places.try_emplace(*texture, static_cast<int>(maps.size()));
                map = known->second;
                if (fresh) maps.push_back(*texture);
            } else if (group.picture || group.own_picture) {
                // It cannot be read: the colour alone.
                group.picture.reset();
                group.own_picture = group.multiply = false;
            }
            const bool own = group.look >= 0 && (!group.has_skin() || group.has_material);
            bases.push_back(own ? material_of(body, group) : white());
            tints.push_back({group.tint[0], group.tint[1], group.tint[2], group.cover});
            if (group.cover == 0) tints.back() = {1, 1, 1, 0};
            map_of.push_back(map);
            multiply.push_back(map >= 0 && group.multiply ? 1 : 0);
            cutoff.push_back(cutoff_of(group.picture));
        }
        bind_materials(f, bases);
        const auto unless = [&](const char* name, const auto& values, const auto& usual,
                                const auto& text) {
            if (std::all_of(values.begin(), values.end(),
                            [&](const auto& v) { return v == usual; }))
                return;
            std::vector<std::string> texts;
            for (const auto& value : values)
                texts.push_back(text(value));
            lists_.add(objects_.size(), f, name, std::move(texts));
        };
        const auto integer = [](int i) { return std::to_string(i); };
        unless("tints", tints, std::array<double, 4>{1, 1, 1, 1},
               [](const auto& t) { return list_of(t, number); });
        if (f == "textured") {
            if (maps.empty()) return no_picture(body);
            lists_.add_maps(objects_.size(), maps);
            unless("map_of", map_of, 0, integer);
            unless("multiply", multiply, 0, integer);
            unless("cutoff", cutoff, -1.0, number);
        }
        return {};
    }

    std::string white() { return materials_.of("white", "white", kWhite); }

    Error no_picture(const mesh::LoadedMesh& body) const {
        return user_error(
            fmt::format("{}: the mesh has no picture, which `textured` needs; give "
                        "one with `--picture FILE`",
                        what(body)));
    }

    /// The texture of a group; empty where it has none.
    Result<std::string> texture_of(const GroupLook& group) {
        if (group.own_picture) return own_picture(false, false);
        if (!group.picture) return std::string();
        return pictures_.add(*group.picture, false, &out_.notes);
    }

    /// Chooses the side with the largest area of the mesh's box; on ties the top, then the front.
    int planar_side(const Vec3d& size) const {
        for (size_t s = 0; s < kSides.size(); ++s) {
            if (options_.side == kSides[s]) return static_cast<int>(s);
        }
        if (size.z <= std::min(size.x, size.y)) return kTop;
        return size.y <= size.x ? kFront : kRight;
    }

    /// The picture spans the mesh's box on each side, or has a size and repeats.
    Result<void> bind_mapped(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
        const Box3d box = box_of(body);
        if (Result<void> bound = bind_first_picture(body, !options_.picture_mm, false); !bound)
            return bound;
        const Vec3d middle = box.center(), size = box.size();
        const auto numbers = [](const std::array<double, 3>& v) { return list_of(v, number); };
        uniform("mapping", std::to_string(static_cast<int>(mapping_of(options_))));
        if (mapping_of(options_) == Mapping::kPlanar)
            uniform("side", std::to_string(planar_side(size)));
        uniform("center", numbers({middle.x, middle.y, middle.z}));
        const double mm = options_.picture_mm.value_or(0);
        uniform("size", mm > 0 ? numbers({mm, mm, mm}) : numbers({size.x, size.y, size.z}));
        if (options_.mapping.empty() && options_.fablet.empty() && !mapping_told_) {
            mapping_told_ = true;
            out_.notes.push_back(fmt::format(
                "`{}` has no texture coordinates: the picture is on each of its six sides. "
                "`--mapping planar` or `triplanar` maps it otherwise, `--picture-size` repeats it",
                file_));
        }
        return {};
    }

    /// Binds the picture of the first group that has one.
    Result<void> bind_first_picture(const mesh::LoadedMesh& body, bool clamp, bool luminance) {
        if (!options_.picture.empty()) {
            const Result<std::string> texture = own_picture(clamp, luminance);
            if (!texture) return texture.error();
            uniform("map", json_text(*texture));
            return {};
        }
        for (const int32_t look : body.look_of) {
            if (look < 0 || !loaded_.looks[static_cast<size_t>(look)].picture) continue;
            mesh::PictureUse use = *loaded_.looks[static_cast<size_t>(look)].picture;
            if (clamp) use.wrap = {mesh::PictureWrap::kClamp, mesh::PictureWrap::kClamp};
            const std::string texture = pictures_.add(use, luminance, &out_.notes);
            if (texture.empty()) continue;
            uniform("map", json_text(texture));
            return {};
        }
        return no_picture(body);
    }

    /// The requested picture, which replaces the mesh's own.
    Result<std::string> own_picture(bool clamp, bool luminance) {
        if (own_picture_ == nullptr) {
            Result<std::string> bytes = read_text_file(
                options_.picture, static_cast<size_t>(std::max<int64_t>(options_.memory_bytes, 0)));
            if (!bytes) return bytes.error();
            own_picture_ = std::make_shared<const std::string>(std::move(*bytes));
        }
        const mesh::PictureWrap wrap =
            clamp ? mesh::PictureWrap::kClamp : mesh::PictureWrap::kRepeat;
        return pictures_.add(fs::path(options_.picture).filename().string(), own_picture_,
                             {wrap, wrap}, luminance);
    }

    /// Adds the table of inks to the world.
    Result<void> bind_profile() {
        if (options_.profile.empty()) return {};
        const auto bad = [&](const Error& error) {
            return with_context(error, fmt::format("cannot read {}: ", options_.profile));
        };
        const Result<InputFile> file = InputFile::open(options_.profile);
        if (!file) return bad(file.error());
        // INK_NODES of stdlib/color.fl along each axis.
        constexpr const char* kSizes = "4 33 33 33";
        const Result<texture::NrrdHeader> header = texture::read_nrrd_header(*file);
        if (!header || header->field("sizes") != kSizes || !header->data_file().empty()) {
            return bad(user_error("it is no table of inks over colours",
                                  "`openfab color bake` makes one of a printer's profile"));
        }
        Result<std::string> bytes = file->read_all(options_.memory_bytes);
        if (!bytes) return bad(bytes.error());
        profile_ = pictures_.add_file("inks", ".nrrd",
                                      std::make_shared<const std::string>(std::move(*bytes)));
        return {};
    }

    // --- the text ------------------------------------------------------------------------------

    /// A list of materials by group.
    void bind_materials(const std::string& fablet, const std::vector<std::string>& names) {
        std::vector<std::string> texts;
        for (const std::string& name : names)
            texts.push_back(json_text(name));
        lists_.add(objects_.size(), fablet, "materials", std::move(texts));
    }

    std::string source_of(const std::string& fablet) const {
        const ImportLists::Counts& counts = lists_.fablets().at(fablet);
        std::string source(stock_text(fmt::format("stock_{}.fl", fablet)));
        set_stock_constant("GROUPS", counts.groups, &source);
        set_stock_constant("MAPS", counts.maps, &source);
        set_stock_constant("PARTS", counts.parts, &source);
        if (!options_.profile.empty() && find_stock_fablet(fablet)->inks) mix_by_profile(&source);
        return source;
    }

    std::string unit_text() const {
        if (loaded_.unit_note == "as the file says") return {};
        static const std::map<double, const char*> kNames = {
            {1, "mm"}, {10, "cm"}, {1000, "m"}, {0.001, "um"}, {25.4, "in"}};
        const auto found = kNames.find(loaded_.unit_mm);
        return found != kNames.end() ? fmt::format(", \"unit\": \"{}\"", found->second) : "";
    }

    std::string mesh_text(const mesh::LoadedMesh& body) const {
        std::string text = fmt::format("{{\"file\": {}", json_text(file_));
        if (!alone()) text += fmt::format(", \"body\": {}", json_text(body.body));
        text += unit_text();
        if (options_.y_up) text += ", \"up\": \"y\"";
        const Vec3d& at = loaded_.origin_mm;
        if (at != Vec3d{})
            text +=
                fmt::format(", \"origin_mm\": {}", list_of(std::array{at.x, at.y, at.z}, number));
        return text + "}";
    }

    std::string world() {
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

    // --- what is told --------------------------------------------------------------------------

    Error too_many_materials() const {
        return user_error(fmt::format(
            "{}: it has {} materials, and a world at most {}; `--one-material` makes all of one, "
            "`--fablet painted` makes their colours a skin of inks, and other fablets do without",
            file_, materials_.lines().size(), kMostMaterials));
    }

    /// Same as in stdlib/mapping.fl.
    static constexpr std::array<const char*, 6> kSides{"front", "right", "back",
                                                       "left",  "top",   "bottom"};
    static constexpr int kFront = 0, kRight = 1, kTop = 4;

    const mesh::LoadedBodies& loaded_;
    const std::string& file_;
    const ImportOptions& options_;
    Box3d box_, negative_box_;
    double scale_ = 1;
    std::vector<BodyLook> looks_;  ///< by body
    ImportMaterials materials_;
    ImportPictures pictures_;
    Names object_names_;
    std::vector<ObjectText> objects_;
    UniformTexts* uniforms_ = nullptr;  ///< of the object that is bound
    ImportLists lists_;
    std::map<const mesh::LoadedMesh*, std::string> own_;  ///< materials of bodies
    SharedBytes own_picture_;
    std::string profile_;
    bool shares_one_ = false, mapping_told_ = false;
    Import out_;
    WorldText text_;
    FieldBinder fields_{&materials_, &pictures_, &object_names_, &out_.files, &text_};
};

const std::array<Importer::Bind, std::size(kStockFablets)> Importer::kBinds = {
    &Importer::bind_solid,  &Importer::bind_mixed, &Importer::bind_skins,  // solid, mixed, textured
    &Importer::bind_mapped, &Importer::bind_skins,                         // mapped, painted
    &Importer::bind_graded, &Importer::bind_shell, &Importer::bind_lattice,
    &Importer::bind_infill, &Importer::bind_relief};

}  // namespace

Result<Import> make_import(const mesh::LoadedBodies& loaded, const Pictures& pictures,
                           const std::string& file, const ImportOptions& options) {
    return Importer(loaded, pictures, file, options).run();
}

}  // namespace openfab::tools
