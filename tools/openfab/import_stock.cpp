// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What an import binds to the uniforms of stock fablets.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>

#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "tools/openfab/import_looks.h"
#include "tools/openfab/importer.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace fs = std::filesystem;

namespace {

/// The alpha of a picture from which on it covers; -1: as much as its alpha. Of an opaque one that
/// ends there is nothing beyond its edge, which only its alpha tells.
double cutoff_of(const std::optional<mesh::PictureUse>& use) {
    if (!use || use->alpha == mesh::PictureUse::Alpha::kBlend) return -1;
    if (use->alpha == mesh::PictureUse::Alpha::kMask) return use->mask_from;
    const bool ends =
        use->wrap[0] == mesh::PictureWrap::kNone || use->wrap[1] == mesh::PictureWrap::kNone;
    return ends ? -1 : 0;
}

}  // namespace

const std::array<Importer::Bind, std::size(kStockFablets)> Importer::kBinds = {
    &Importer::bind_solid,  &Importer::bind_mixed, &Importer::bind_skins,  // solid, mixed, textured
    &Importer::bind_mapped, &Importer::bind_skins,                         // mapped, painted
    &Importer::bind_graded, &Importer::bind_shell, &Importer::bind_lattice,
    &Importer::bind_infill, &Importer::bind_relief};

Result<void> Importer::bind_fablet(const mesh::LoadedMesh& body, BodyLook* look) {
    const std::string& f = look->fablet;
    lists_.use(f);
    const StockFablet& stock = *find_stock_fablet(f);
    const Bind bind = kBinds[static_cast<size_t>(&stock - kStockFablets)];
    if (Result<void> bound = (this->*bind)(body, look); !bound) return bound;
    if (!stock.inks) return {};
    if (!profile_.empty()) uniform("profile", json_string(profile_));
    bind_inks(&materials_, uniforms_);
    return {};
}

Box3d Importer::box_of(const mesh::LoadedMesh& body) const {
    Box3d box;
    for (const Vec3d& p : body.mesh.positions)
        box.add(p);
    box.lo = box.lo * scale_, box.hi = box.hi * scale_;
    return box;
}

std::string Importer::material_of(const mesh::LoadedMesh& body, const GroupLook& group) {
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

Result<void> Importer::bind_solid(const mesh::LoadedMesh& body, BodyLook* look) {
    std::vector<std::string> names;
    for (const GroupLook& group : look->groups)
        names.push_back(material_of(body, group));
    if (options_.one_material) names.resize(1);
    bind_materials("solid", names);
    return {};
}

Result<void> Importer::bind_graded(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
    const Box3d box = box_of(body);
    uniform("low", number(box.lo.z));
    uniform("high", number(box.hi.z));
    material("bottom", "white", kWhite);
    material("top", "black", {});
    return {};
}

Result<void> Importer::bind_shell(const mesh::LoadedMesh& /*body*/, BodyLook* /*look*/) {
    material("skin", "white", kWhite);
    material("core", "black", {});
    return {};
}

Result<void> Importer::bind_lattice(const mesh::LoadedMesh& /*body*/, BodyLook* /*look*/) {
    material("material", "white", kWhite);
    uniform("filler", "\"VOID\"");
    return {};
}

Result<void> Importer::bind_infill(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
    const Vec3d middle = box_of(body).center();
    uniform("drain", list_of(std::array{middle.x, middle.y, middle.z}, number));
    material("material", "white", kWhite);
    uniform("filler", "\"VOID\"");
    uniform("barrier", "\"VOID\"");
    return {};
}

Result<void> Importer::bind_relief(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
    if (Result<void> bound = bind_first_picture(body, false, true); !bound) return bound;
    material("material", "white", kWhite);
    return {};
}

Result<void> Importer::bind_mixed(const mesh::LoadedMesh& body, BodyLook* look) {
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

Result<void> Importer::bind_skins(const mesh::LoadedMesh& body, BodyLook* look) {
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
            const auto [known, fresh] = places.try_emplace(*texture, static_cast<int>(maps.size()));
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
        if (std::all_of(values.begin(), values.end(), [&](const auto& v) { return v == usual; }))
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

Error Importer::no_picture(const mesh::LoadedMesh& body) const {
    return user_error(fmt::format(messages::kNoPictureFor, what(body), "textured"));
}

Result<std::string> Importer::texture_of(const GroupLook& group) {
    if (group.own_picture) return own_picture(false, false);
    if (!group.picture) return std::string();
    return pictures_.add(*group.picture, false, &out_.notes);
}

int Importer::planar_side(const Vec3d& size) const {
    for (size_t s = 0; s < kSides.size(); ++s) {
        if (options_.side == kSides[s]) return static_cast<int>(s);
    }
    if (size.z <= std::min(size.x, size.y)) return kTop;
    return size.y <= size.x ? kFront : kRight;
}

Result<void> Importer::bind_mapped(const mesh::LoadedMesh& body, BodyLook* /*look*/) {
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
        out_.notes.push_back(fmt::format(messages::kOnSixSides, file_));
    }
    return {};
}

Result<void> Importer::bind_first_picture(const mesh::LoadedMesh& body, bool clamp,
                                          bool luminance) {
    if (!options_.picture.empty()) {
        const Result<std::string> texture = own_picture(clamp, luminance);
        if (!texture) return texture.error();
        uniform("map", json_string(*texture));
        return {};
    }
    for (const int32_t look : body.look_of) {
        if (look < 0 || !loaded_.looks[static_cast<size_t>(look)].picture) continue;
        mesh::PictureUse use = *loaded_.looks[static_cast<size_t>(look)].picture;
        if (clamp) use.wrap = {mesh::PictureWrap::kClamp, mesh::PictureWrap::kClamp};
        const std::string texture = pictures_.add(use, luminance, &out_.notes);
        if (texture.empty()) continue;
        uniform("map", json_string(texture));
        return {};
    }
    return no_picture(body);
}

Result<std::string> Importer::own_picture(bool clamp, bool luminance) {
    if (own_picture_ == nullptr) {
        Result<std::string> bytes = read_text_file(
            options_.picture, static_cast<size_t>(std::max<int64_t>(options_.memory_bytes, 0)));
        if (!bytes) return bytes.error();
        own_picture_ = std::make_shared<const std::string>(std::move(*bytes));
    }
    const mesh::PictureWrap wrap = clamp ? mesh::PictureWrap::kClamp : mesh::PictureWrap::kRepeat;
    return pictures_.add(fs::path(options_.picture).filename().string(), own_picture_, {wrap, wrap},
                         luminance);
}

}  // namespace openfab::tools
