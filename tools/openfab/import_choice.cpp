// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace {

using mesh::BodyRole;

class Choice {
  public:
    Choice(const mesh::LoadedBodies& loaded, const std::string& file, const ImportOptions& options)
        : loaded_(loaded), file_(file), options_(options) {}

    Result<std::vector<BodyLook>> run(std::vector<std::string>* notes) const {
        const bool any = any_picture();
        const bool layered =
            lower_ascii(std::filesystem::path(file_).extension().string()) == ".3mf";
        std::vector<BodyLook> looks;
        bool pictures_lost = false;
        for (size_t b = 0; b < loaded_.bodies.size(); ++b) {
            const mesh::LoadedMesh& body = loaded_.bodies[b];
            BodyLook look{group_looks(loaded_, body, layered), "solid"};
            // A picture of the command line replaces those of the file.
            const bool pictured = !options_.picture.empty() && is_part(b) &&
                                  (!any || has_picture(body) || !options_.mapping.empty() ||
                                   !options_.fablet.empty());
            if (is_part(b)) {
                look.fablet = options_.fablet.empty() ? fitting_fablet(body, look, pictured)
                                                      : options_.fablet;
                if (Result<void> fine = check(body, look.fablet, pictured); !fine)
                    return fine.error();
                pictures_lost = pictures_lost || (look.fablet != "mapped" && !has(body, "uv", 2) &&
                                                  has_picture(body));
            }
            if (look.fablet == "textured" && pictured) {
                for (size_t g = 0; g < look.groups.size(); ++g)
                    give_picture(any, body, g, &look.groups[g]);
            } else if (look.fablet != "textured") {
                without_pictures(&look.groups);
            }
            if (options_.fablet == "painted") all_skins(loaded_.looks, &look.groups);
            looks.push_back(std::move(look));
        }
        if (pictures_lost) {
            notes->push_back(fmt::format(messages::kPicturesWithoutCoordinates, file_));
        }
        return looks;
    }

  private:
    bool is_part(size_t b) const { return loaded_.bodies[b].role == BodyRole::kPart; }
    bool alone() const { return loaded_.bodies.size() == 1; }
    static bool has(const mesh::LoadedMesh& body, const char* attribute, int32_t components) {
        const mesh::MeshAttribute* a = body.mesh.find(attribute);
        return a != nullptr && !a->is_int && a->components == components;
    }
    /// The file, and the body where there are several, for messages.
    std::string what(const mesh::LoadedMesh& body) const {
        return alone() ? file_ : fmt::format(messages::kBodyOf, file_, body.body);
    }

    bool has_picture(const mesh::LoadedMesh& body) const {
        return std::any_of(body.look_of.begin(), body.look_of.end(), [&](int32_t look) {
            return look >= 0 && loaded_.looks[static_cast<size_t>(look)].picture;
        });
    }
    bool any_picture() const {
        return std::any_of(loaded_.bodies.begin(), loaded_.bodies.end(),
                           [&](const mesh::LoadedMesh& body) { return has_picture(body); });
    }

    void give_picture(bool any, const mesh::LoadedMesh& body, size_t group, GroupLook* look) const {
        const int32_t index = group < body.look_of.size() ? body.look_of[group] : -1;
        const bool had = index >= 0 && loaded_.looks[static_cast<size_t>(index)].picture;
        if (any && !had && options_.fablet.empty()) return;
        // Where it is transparent, the material of the faces is seen.
        look->picture.reset();
        look->own_picture = true;
        look->multiply = false;
        look->cover = 0;
        look->has_material = look->has_material && index >= 0 && !had &&
                             loaded_.looks[static_cast<size_t>(index)].color.has_value();
        look->mixture.clear();
    }

    std::string fitting_fablet(const mesh::LoadedMesh& body, const BodyLook& look,
                               bool pictured) const {
        if (options_.one_material) return "solid";
        if (!options_.mapping.empty() && (pictured || has_picture(body) || alone()))
            return options_.mapping == "uv" ? "textured" : "mapped";
        const bool uv = has(body, "uv", 2);
        if (pictured && !uv) return "mapped";
        const auto any = [&](const auto& is) {
            return std::any_of(look.groups.begin(), look.groups.end(), is);
        };
        if (uv && (pictured || any([](const GroupLook& g) { return g.picture.has_value(); })))
            return "textured";
        if (any([](const GroupLook& g) { return g.cover > 0; })) return "painted";
        return any([](const GroupLook& g) { return !g.mixture.empty(); }) ? "mixed" : "solid";
    }

    Result<void> check(const mesh::LoadedMesh& body, const std::string& f, bool pictured) const {
        const auto does_not_go = [&](const char* option, const char* with) {
            return usage_error(fmt::format(messages::kIsForFablets, option, with, f));
        };
        const StockFablet& stock = *find_stock_fablet(f);
        const bool forced = !options_.fablet.empty() || alone();
        const bool by_uv = options_.mapping.empty() || options_.mapping == "uv";
        if (!by_uv && f != "mapped" && forced)
            return does_not_go("--mapping", messages::kTheFabletMapped);
        if (options_.mapping == "uv" && f == "mapped")
            return does_not_go("--mapping uv", messages::kTheFabletTextured);
        if (!options_.side.empty() && (f != "mapped" || mapping_of(options_) != Mapping::kPlanar) &&
            forced)
            return usage_error(messages::kSideIsForPlanar);
        if (options_.picture_mm && f != "mapped" && forced)
            return does_not_go("--picture-size", messages::kMappingsWithoutUv);
        if (pictured && !stock.picture)
            return does_not_go("--picture", messages::kFabletsWithPicture);
        if (!options_.profile.empty() && !stock.inks && forced)
            return does_not_go("--profile", messages::kFabletsWithInks);
        if (stock.uv && !has(body, "uv", 2)) {
            return user_error(fmt::format(messages::kNoCoordinates, what(body), f,
                                          f == "textured" ? messages::kNoCoordinatesMappingHelp
                                                          : messages::kNoCoordinatesFabletHelp));
        }
        if (stock.picture && !pictured && (f == "textured" ? !any_picture() : !has_picture(body)))
            return user_error(fmt::format(messages::kNoPictureFor, what(body), f));
        if (stock.colors && !has(body, "color", 3) && !any_color(body))
            return user_error(fmt::format(messages::kNoVertexColours, what(body), f));
        return {};
    }

    bool any_color(const mesh::LoadedMesh& body) const {
        return std::any_of(body.look_of.begin(), body.look_of.end(), [&](int32_t look) {
            return look >= 0 && loaded_.looks[static_cast<size_t>(look)].color;
        });
    }

    const mesh::LoadedBodies& loaded_;
    const std::string& file_;
    const ImportOptions& options_;
};

}  // namespace

Mapping mapping_of(const ImportOptions& options) {
    return options.mapping == "planar"      ? Mapping::kPlanar
           : options.mapping == "triplanar" ? Mapping::kTriplanar
                                            : Mapping::kBox;
}

Result<std::vector<BodyLook>> choose_looks(const mesh::LoadedBodies& loaded,
                                           const std::string& file, const ImportOptions& options,
                                           std::vector<std::string>* notes) {
    return Choice(loaded, file, options).run(notes);
}

}  // namespace openfab::tools
