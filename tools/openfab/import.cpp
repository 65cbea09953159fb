// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string_view>
#include <unordered_map>

#include "base/check.h"
#include "base/color.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "texture/nrrd_header.h"
#include "tools/openfab/stock.h"
#include "tools/openfab/up_axis.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostMaterials = 64;

/// Quotes a JSON string. Names come from files and may contain anything.
std::string json_text(std::string_view text) {
    return JsonText().value(text).take();
}

template <typename Things, typename Text>
std::string list_of(const Things& things, const Text& text) {
    std::string out = "[";
    for (const auto& thing : things)
        out += (out.size() > 1 ? ", " : "") + text(thing);
    return out + "]";
}

/// Formats a number with at most 5 decimals.
std::string number(double value) {
    std::string text = fmt::format("{:.5f}", value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text == "-0" ? "0" : text;
}

/// Makes names unique.
class Names {
  public:
    /// Returns the name itself, else with a number appended.
    std::string unique(const std::string& wanted) {
        const std::string base = wanted.empty() ? "unnamed" : wanted;
        std::string name = base;
        // The search for a name continues where the last one ended.
        for (int& i = next_.try_emplace(base, 2).first->second; !taken_.insert(name).second; ++i)
            name = fmt::format("{}_{}", base, i);
        return name;
    }

  private:
    std::set<std::string> taken_;
    std::map<std::string, int> next_;
};

/// Returns a file name of characters that are safe for shells and programs.
std::string plain_name(const std::string& name) {
    std::string out;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
        out += plain ? c : '_';
    }
    return out.empty() || out[0] == '.' ? "picture" + out : out;
}

using Key = std::array<int, 3>;

/// Encodes linear light to sRGB.
Key key_of(const std::array<double, 3>& linear) {
    Key key{};
    for (size_t c = 0; c < 3; ++c) {
        key[c] = linear_to_srgb8(linear[c]);
    }
    return key;
}

std::string hex(const Key& key) {
    return fmt::format("#{:02x}{:02x}{:02x}", key[0], key[1], key[2]);
}

/// Returns a key close to the requested one that no other material has.
Key free_key(Key key, std::vector<Key>* taken) {
    while (std::find(taken->begin(), taken->end(), key) != taken->end()) {
        for (size_t c = 3; c-- > 0;) {
            key[c] = (key[c] + 1) % 256;
            if (key[c] != 0) break;
        }
    }
    taken->push_back(key);
    return key;
}

class Importer {
  public:
    Importer(const mesh::LoadedMesh& mesh, const Appearances& appearances, const std::string& file,
             const ImportOptions& options)
        : mesh_(mesh),
          appearances_(appearances),
          index_by_name_(indices_of(appearances)),
          file_(file),
          options_(options) {
        for (const auto& [name, number] : mesh.groups)
            groups_.push_back(name);
        // A mesh of one unnamed material has no groups.
        if (groups_.empty())
            groups_.push_back(appearances.appearances.size() == 1 ? appearances.appearances[0].name
                                                                  : "");
        for (const Vec3d& p : mesh.mesh.positions)
            box_.add(p);
        if (options.largest_mm) {
            const Vec3d size = box_.size();
            scale_ = *options.largest_mm / std::max({size.x, size.y, size.z});
        }
    }

    Result<Import> run() {
        out_.fablet = options_.fablet.empty() ? fitting_fablet() : options_.fablet;
        if (Result<void> fine = check(); !fine) return fine.error();
        if (Result<void> bound = bind(); !bound) return bound.error();
        std::string source(stock_text(fmt::format("stock_{}.fl", out_.fablet)));
        set_constant("GROUPS", groups_.size(), &source);
        set_constant("MAPS", std::max<size_t>(texture_names_.size(), 1), &source);
        if (!options_.profile.empty()) mix_by_profile(&source);
        out_.files.push_back(
            {source_name(), std::make_shared<const std::string>(std::move(source))});
        out_.world = world();
        if (!options_.y_up && !mesh::format_says_up(file_)) {
            if (const std::string why = y_up_evidence(mesh_.mesh); !why.empty()) {
                out_.notes.push_back(fmt::format(
                    "`{}` may lie on its back: {}. Import it with `--up y` if y is up in it", file_,
                    why));
            }
        }
        if (mesh_.unit_note.starts_with("assumed") && !options_.largest_mm) {
            const Vec3d size = box_.size();
            out_.notes.push_back(fmt::format(
                "`{}` gives no unit: taken as millimetres, {:.4g} x {:.4g} x {:.4g} mm. Import it "
                "with --unit or --size if that is wrong",
                file_, size.x, size.y, size.z));
        }
        return std::move(out_);
    }

  private:
    bool has(const char* attribute, int32_t components) const {
        const mesh::MeshAttribute* a = mesh_.mesh.find(attribute);
        return a != nullptr && !a->is_int && a->components == components;
    }
    bool any_picture() const {
        return !options_.picture.empty() ||
               std::any_of(groups_.begin(), groups_.end(),
                           [&](const std::string& g) { return appearance(g).picture.has_value(); });
    }
    MaterialAppearance appearance(const std::string& group) const {
        const auto found = index_by_name_.find(group);
        return found != index_by_name_.end() ? appearances_.appearances[found->second]
                                             : MaterialAppearance{};
    }

    std::string fitting_fablet() {
        if (!options_.mapping.empty()) return options_.mapping == "uv" ? "textured" : "mapped";
        if (!has("uv", 2) && any_picture()) {
            if (!options_.picture.empty()) return "mapped";
            out_.notes.push_back(fmt::format(
                "`{}` has pictures, but no texture coordinates to place them by: they are left "
                "out. `--mapping box`, `planar` or `triplanar` maps the first one",
                file_));
        }
        if (has("uv", 2) && any_picture()) return "textured";
        return has("color", 3) && groups_.size() == 1 ? "painted" : "solid";
    }

    Result<void> check() const {
        const std::string& f = out_.fablet;
        const auto does_not_go = [&](const char* option, const char* with) {
            return usage_error(
                fmt::format("`{}` is for {}, and the fablet is `{}`", option, with, f));
        };
        const bool by_uv = options_.mapping.empty() || options_.mapping == "uv";
        if (!by_uv && f != "mapped") return does_not_go("--mapping", "the fablet `mapped`");
        if (options_.mapping == "uv" && f == "mapped")
            return does_not_go("--mapping uv", "the fablet `textured`");
        if (!options_.side.empty() && (f != "mapped" || mapping() != kPlanar))
            return usage_error("`--side` is for `--mapping planar`");
        if (options_.picture_mm && f != "mapped")
            return does_not_go("--picture-size", "`--mapping planar`, `box` or `triplanar`");
        if (!options_.picture.empty() && f != "textured" && f != "mapped" && f != "relief")
            return does_not_go("--picture", "the fablets `textured`, `mapped` and `relief`");
        if (!options_.profile.empty() && !has_inks())
            return does_not_go("--profile", "the fablets `textured`, `mapped` and `painted`");
        if ((f == "textured" || f == "relief") && !has("uv", 2)) {
            return user_error(fmt::format(
                "{}: the mesh has no texture coordinates, which `{}` needs; "
                "{}",
                file_, f,
                f == "textured" ? "`--mapping box`, `planar` or `triplanar` does without"
                                : "choose another `--fablet`"));
        }
        if ((f == "relief" || f == "mapped") && !any_picture())
            return user_error(fmt::format(
                "{}: the mesh has no picture, which `{}` needs; give one with `--picture FILE`",
                file_, f));
        if (f == "painted" && !has("color", 3))
            return user_error(
                fmt::format("{}: the mesh's vertices have no colours, which `painted` "
                            "needs; choose another `--fablet`",
                            file_));
        return {};
    }

    /// Whether the fablet mixes inks of colours.
    bool has_inks() const {
        return out_.fablet == "textured" || out_.fablet == "mapped" || out_.fablet == "painted";
    }

    /// Replaces the formula of the stock fablets by the look-up of a table.
    static void mix_by_profile(std::string* source) {
        const auto replace = [&](const std::string& from, const std::string& until,
                                 const std::string& by) {
            const size_t begin = source->find(from);
            OPENFAB_CHECK_NE(begin, std::string::npos);
            const size_t end = source->find(until, begin);
            OPENFAB_CHECK_NE(end, std::string::npos);
            source->replace(begin, end + until.size() - begin, by);
        };
        replace(
            "float density", ";",
            "ImageTexture3D profile [[ string help = \"inks by colour, a table of `openfab color "
            "bake`\" ]];");
        replace("ink_limit(rgb_to_cmyk(rgb", ", 1)", "ink_amounts(profile, rgb)");
    }

    /// Adds the table of inks to the world.
    Result<void> bind_profile() {
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
        const std::string name = texture_files_.unique("inks");
        textures_.push_back(fmt::format("        {}: {{\"file\": {}}}", json_text(name),
                                        json_text(name + ".nrrd")));
        out_.files.push_back(
            {name + ".nrrd", std::make_shared<const std::string>(std::move(*bytes))});
        uniform("profile", json_text(name));
        return {};
    }

    std::string source_name() const { return fmt::format("stock_{}.fl", out_.fablet); }
    std::string object_name() const { return fs::path(file_).stem().string(); }

    static void set_constant(const std::string& name, size_t value, std::string* source) {
        const std::string from = fmt::format("const int {} = 1;", name);
        const size_t at = source->find(from);
        if (at != std::string::npos)
            source->replace(at, from.size(), fmt::format("const int {} = {};", name, value));
    }

    std::string add_material(const std::string& name, const std::array<double, 3>& linear) {
        const Key key = key_of(linear);
        // Pictures have a white ground, on which white would not show.
        constexpr Key kPaper{255, 255, 255}, kOffWhite{244, 242, 236};
        std::string unique_name = material_names_.unique(name);
        materials_.push_back(fmt::format("        {}: {{\"key\": \"{}\", \"preview\": \"{}ff\"}}",
                                         json_text(unique_name), hex(free_key(key, &keys_)),
                                         hex(key == kPaper ? kOffWhite : key)));
        return unique_name;
    }

    void uniform(const std::string& name, const std::string& value) {
        uniforms_.push_back(fmt::format("                {}: {}", json_text(name), value));
    }
    void material(const std::string& uniform_name, const std::string& name,
                  const std::array<double, 3>& linear) {
        uniform(uniform_name, json_text(add_material(name, linear)));
    }

    Result<void> bind() {
        const double low = box_.lo.z * scale_, high = box_.hi.z * scale_;
        if (out_.fablet == "solid") return bind_solid();
        if (out_.fablet == "textured") {
            if (Result<void> bound = bind_pictures(); !bound) return bound;
        } else if (out_.fablet == "mapped") {
            if (Result<void> bound = bind_mapped(); !bound) return bound;
        } else if (out_.fablet == "graded") {
            uniform("low", number(low));
            uniform("high", number(high));
            material("bottom", "white", kWhite);
            material("top", "black", kBlack);
        } else if (out_.fablet == "shell") {
            material("skin", "white", kWhite);
            material("core", "black", kBlack);
        } else if (out_.fablet == "lattice") {
            material("material", "white", kWhite);
            uniform("filler", "\"VOID\"");
        } else if (out_.fablet == "infill") {
            const Vec3d middle = (box_.lo + box_.hi) * (scale_ / 2);
            uniform("drain", list_of(std::array{middle.x, middle.y, middle.z}, number));
            material("material", "white", kWhite);
            uniform("filler", "\"VOID\"");
            uniform("barrier", "\"VOID\"");
        } else if (out_.fablet != "painted") {
            return bind_relief();
        }
        if (!options_.profile.empty()) {
            if (Result<void> bound = bind_profile(); !bound) return bound;
        }
        if (has_inks()) {
            material("cyan", "cyan", {0, 0.3, 0.8});
            material("magenta", "magenta", {0.75, 0, 0.2});
            material("yellow", "yellow", {1, 0.8, 0});
            material("black", "black", kBlack);
            material("white", "white", kWhite);
        }
        return {};
    }

    Result<void> bind_solid() {
        if (groups_.size() > kMostMaterials) {
            return user_error(
                fmt::format("{}: the mesh has {} groups, and a world at most {} "
                            "materials; choose another `--fablet`",
                            file_, groups_.size(), kMostMaterials));
        }
        std::vector<std::string> names;
        for (size_t g = 0; g < groups_.size(); ++g) {
            // Without a colour: distinct greys.
            const double grey =
                1 - 0.8 * static_cast<double>(g) / static_cast<double>(groups_.size());
            const std::string name = groups_[g].empty() ? "material" : groups_[g];
            names.push_back(add_material(
                name == "VOID" ? "void" : name,
                appearance(groups_[g]).color.value_or(std::array<double, 3>{grey, grey, grey})));
        }
        uniform("materials", names.size() == 1 ? json_text(names[0]) : list_of(names, json_text));
        return {};
    }

    Result<void> bind_pictures() {
        std::vector<int> map_of;
        std::vector<std::array<double, 3>> tints;
        for (const std::string& group : groups_) {
            const MaterialAppearance of = appearance(group);
            Result<int> texture_index = add_picture(of);
            if (!texture_index) return texture_index.error();
            map_of.push_back(*texture_index);
            const bool white = *texture_index >= 0 && !of.tinted;
            tints.push_back(white ? kWhite : of.color.value_or(kWhite));
        }
        if (textures_.empty())
            return user_error(
                fmt::format("{}: the mesh has no picture, which `textured` needs; give "
                            "one with `--picture FILE`",
                            file_));
        uniform("maps", texture_names_.size() == 1 ? json_text(texture_names_[0])
                                                   : list_of(texture_names_, json_text));
        uniform("map_of", list_of(map_of, [](int i) { return std::to_string(i); }));
        uniform("tints", list_of(tints, [](const auto& t) { return list_of(t, number); }));
        return {};
    }

    enum Mapping { kPlanar = 0, kBox = 1, kTriplanar = 2 };

    Mapping mapping() const {
        return options_.mapping == "planar"      ? kPlanar
               : options_.mapping == "triplanar" ? kTriplanar
                                                 : kBox;
    }

    /// Chooses the side with the largest area of the mesh's box; on ties the top, then the front.
    int planar_side() const {
        for (size_t s = 0; s < kSides.size(); ++s) {
            if (options_.side == kSides[s]) return static_cast<int>(s);
        }
        const Vec3d size = box_.size();
        if (size.z <= std::min(size.x, size.y)) return kTop;
        return size.y <= size.x ? kFront : kRight;
    }

    /// The picture spans the mesh's box on each side, or has a size and repeats.
    Result<void> bind_mapped() {
        if (Result<void> bound = bind_first_picture(!options_.picture_mm); !bound) return bound;
        const Vec3d middle = (box_.lo + box_.hi) * (scale_ / 2), size = box_.size() * scale_;
        const auto numbers = [](const std::array<double, 3>& v) { return list_of(v, number); };
        uniform("mapping", std::to_string(mapping()));
        if (mapping() == kPlanar) uniform("side", std::to_string(planar_side()));
        uniform("center", numbers({middle.x, middle.y, middle.z}));
        const double mm = options_.picture_mm.value_or(0);
        uniform("size", mm > 0 ? numbers({mm, mm, mm}) : numbers({size.x, size.y, size.z}));
        if (options_.mapping.empty() && options_.fablet.empty()) {
            out_.notes.push_back(fmt::format(
                "`{}` has no texture coordinates: the picture is on each of its six sides. "
                "`--mapping planar` or `triplanar` maps it otherwise, `--picture-size` repeats it",
                file_));
        }
        return {};
    }

    /// Returns the picture of the first group that has one.
    Result<void> bind_first_picture(bool clamp) {
        for (const std::string& group : groups_) {
            Result<int> texture_index = add_picture(appearance(group), clamp);
            if (!texture_index) return texture_index.error();
            if (*texture_index >= 0) break;
        }
        uniform("map", json_text(texture_names_[0]));
        return {};
    }

    Result<void> bind_relief() {
        if (Result<void> bound = bind_first_picture(false); !bound) return bound;
        material("material", "white", kWhite);
        return {};
    }

    /// Reads the requested picture, which replaces the mesh's own.
    Result<SharedBytes> own_picture() {
        if (own_picture_ == nullptr) {
            Result<std::string> bytes = read_text_file(
                options_.picture, static_cast<size_t>(std::max<int64_t>(options_.memory_bytes, 0)));
            if (!bytes) return bytes.error();
            own_picture_ = std::make_shared<const std::string>(std::move(*bytes));
        }
        return own_picture_;
    }

    /// Adds a material's picture; returns its index among the textures, -1 if it has none. Shared
    /// pictures are added once.
    Result<int> add_picture(const MaterialAppearance& of, bool clamp = false) {
        Picture picture;
        if (!options_.picture.empty()) {
            const Result<SharedBytes> bytes = own_picture();
            if (!bytes) return bytes.error();
            picture = {fs::path(options_.picture).filename().string(), *bytes, false};
        } else if (of.picture) {
            picture = *of.picture;
        } else {
            return -1;
        }
        picture.clamp = picture.clamp || clamp;
        const auto [shared, first] = shared_.try_emplace({picture.bytes.get(), picture.clamp}, 0);
        if (!first) return shared->second;
        const auto texture_index = static_cast<int>(textures_.size());
        const auto [equal, fresh] =
            pictures_[picture.clamp ? 1 : 0].try_emplace(*picture.bytes, texture_index);
        shared->second = equal->second;
        if (!fresh) return equal->second;
        const fs::path plain = plain_name(picture.name);
        const std::string name = texture_files_.unique(plain.stem().string());
        const std::string file = name + plain.extension().string();
        texture_names_.push_back(name);
        // The height of a relief is proportional to brightness.
        textures_.push_back(fmt::format(
            "        {}: {{\"file\": {}, \"wrap\": \"{}\"{}}}", json_text(name), json_text(file),
            picture.clamp ? "clamp" : "repeat",
            out_.fablet == "relief" ? ", \"space\": \"data\", \"channels\": \"luminance\"" : ""));
        out_.files.push_back({file, picture.bytes});
        return texture_index;
    }

    /// The unit of the file, unless the file states it.
    std::string unit() const {
        if (mesh_.unit_note == "as the file says") return "";
        static const std::map<double, const char*> kNames = {
            {1, "mm"}, {10, "cm"}, {1000, "m"}, {0.001, "um"}, {25.4, "in"}};
        const auto found = kNames.find(mesh_.unit_mm);
        return found == kNames.end() ? "" : fmt::format(", \"unit\": \"{}\"", found->second);
    }

    static std::string lines(const std::vector<std::string>& all) {
        std::string out;
        for (const std::string& line : all)
            out += (out.empty() ? "" : ",\n") + line;
        return out;
    }

    std::string world() const {
        std::string fablet = out_.fablet;
        fablet[0] = static_cast<char>(fablet[0] - 32);
        const std::string name = json_text(object_name());
        const std::string scale = scale_ == 1 ? "" : fmt::format(", \"scale\": {:.9g}", scale_);
        const std::string repair = options_.repair ? "\n            \"repair\": \"winding\"," : "";
        const std::string textures =
            textures_.empty()
                ? ""
                : fmt::format("    \"textures\": {{\n{}\n    }},\n", lines(textures_));
        return fmt::format(R"({{
    "$schema": "fab_world.schema.json",
    "openfab": 1,
    "printer": {},
    "fablets": {{"{}": {{"source": "{}", "fablet": "{}"}}}},
    "materials": {{
{}
    }},
{}    "meshes": {{{}: {{"file": {}{}}}}},
    "objects": {{
        {}: {{
            "mesh": {},
            "fablet": "{}",{}
            "uniforms": {{
{}
            }}
        }}
    }},
    "build": [{{"object": {}{}, "translate_mm": [0, 0]}}]
}}
)",
                           json_text(options_.printer), out_.fablet, source_name(), fablet,
                           lines(materials_), textures, name, json_text(file_),
                           unit() + (options_.y_up ? ", \"up\": \"y\"" : ""), name, name,
                           out_.fablet, repair, lines(uniforms_), name, scale);
    }

    /// Same as in stdlib/mapping.fl.
    static constexpr std::array<const char*, 6> kSides{"front", "right", "back",
                                                       "left",  "top",   "bottom"};
    static constexpr int kFront = 0, kRight = 1, kTop = 4;
    static constexpr std::array<double, 3> kWhite{1, 1, 1};
    static constexpr std::array<double, 3> kBlack{0, 0, 0};

    const mesh::LoadedMesh& mesh_;
    const Appearances& appearances_;
    const std::unordered_map<std::string_view, size_t> index_by_name_;  ///< of appearances by name
    const std::string& file_;
    const ImportOptions& options_;
    std::vector<std::string> groups_;  ///< by the mesh's `face` numbers
    Box3d box_;
    double scale_ = 1;
    std::vector<std::string> materials_, textures_, uniforms_;  ///< lines of the world
    std::vector<std::string> texture_names_;
    Names material_names_, texture_files_;
    std::vector<Key> keys_;
    SharedBytes own_picture_;
    /// Texture indices of repeating and clamped pictures, by their shared bytes.
    std::array<std::unordered_map<std::string_view, int>, 2> pictures_;
    std::map<std::pair<const std::string*, bool>, int> shared_;
    Import out_;
};

}  // namespace

Result<Import> make_import(const mesh::LoadedMesh& mesh, const Appearances& appearances,
                           const std::string& file, const ImportOptions& options) {
    return Importer(mesh, appearances, file, options).run();
}

}  // namespace openfab::tools
