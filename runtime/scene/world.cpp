// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/base/near_miss.h"
#include "runtime/scene/json.h"
#include "runtime/scene/json_reader.h"
#include "runtime/scene/load_mesh.h"
#include "runtime/scene/part_mesh.h"
#include "runtime/scene/primitives.h"
#include "runtime/scene/rotation.h"
#include "runtime/texture/volume.h"

namespace openfab::scene {
namespace {

using Kind = JsonValue::Kind;
namespace fs = std::filesystem;

constexpr size_t kLargestWorld = 256'000'000;
constexpr size_t kMostMaterials = 64;
constexpr size_t kMostPlacements = 100'000;
constexpr double kFarthest_mm = 1e6;
constexpr double kLargestPrimitive_mm = 1e5;
constexpr double kLargestScale = 1e6;

template <typename T>
std::vector<std::string> names_of(const std::vector<T>& things) {
    std::vector<std::string> names;
    for (const T& thing : things)
        names.push_back(thing.name);
    return names;
}

class WorldReader {
  public:
    explicit WorldReader(const fs::path& file) : file_(file), json_(file.string()) {
        world_.file = file;
        world_.files.push_back(file);
    }

    Result<World> read() {
        const Result<std::string> text = read_text_file(file_, kLargestWorld);
        if (!text) return text.error();
        const Result<JsonValue> root = parse_json(*text, file_.string());
        if (!root) return root.error();
        // In the order in which one refers to another; in the file they may stand in any.
        if (json_.object(*root, world_keys("world"), "the world")) {
            version(root->find("openfab")->value);
            if (const JsonMember* m = root->find("$schema")) json_.string(m->value, "`$schema`");
            if (const JsonMember* m = root->find("printer")) printer(m->value);
            section(*root, "fablets", &WorldReader::fablet);
            section(*root, "materials", &WorldReader::material);
            section(*root, "textures", &WorldReader::texture);
            section(*root, "meshes", &WorldReader::mesh);
            section(*root, "objects", &WorldReader::object);
            build(root->find("build")->value);
        }
        if (!json_.ok()) return json_.error();
        return std::move(world_);
    }

  private:
    void version(const JsonValue& value) {
        const double version = json_.number(value, "`openfab`", 0, 1e9);
        if (json_.ok() && version != 1) {
            json_.fail(value,
                       fmt::format("the world's version is {:.6g}; this program reads version 1",
                                   version));
        }
    }

    /// A profile's name, or a file's path, which counts from the world's folder as all do.
    void printer(const JsonValue& value) {
        world_.printer = json_.string(value, "`printer`");
        if (world_.printer.ends_with(".json")) {
            world_.printer = existing(value, "the printer").string();
        }
    }

    void section(const JsonValue& root, const char* key,
                 void (WorldReader::*read_one)(const JsonMember&)) {
        const JsonMember* found = root.find(key);
        if (found == nullptr || !json_.named_things(found->value, key)) return;
        for (const JsonMember& member : found->value.members) {
            if (!json_.ok()) return;
            (this->*read_one)(member);
        }
    }

    fs::path path_of(const JsonValue& value, const std::string& what) {
        const std::string text = json_.string(value, what);
        if (json_.ok() && (text.empty() || text.find('\0') != std::string::npos)) {
            json_.fail(value, fmt::format("{} is no file name", what));
        }
        return file_.parent_path() / text;
    }

    /// A path that must name a file.
    fs::path existing(const JsonValue& value, const std::string& what) {
        fs::path path = path_of(value, what);
        std::error_code ignored;
        if (json_.ok() && !fs::is_regular_file(path, ignored)) {
            json_.fail(
                value,
                fmt::format("{} `{}` {}; paths count from the world's folder", what, path.string(),
                            fs::exists(path, ignored) ? "is not a file" : "does not exist"));
        }
        world_.files.push_back(path);
        return path;
    }

    /// One file, or the slices of a volume: a folder, or a pattern that names some.
    fs::path image_files(const JsonValue& value, const std::string& what) {
        const fs::path path = path_of(value, what);
        std::error_code ignored;
        const bool many = fs::is_directory(path, ignored) ||
                          path.filename().string().find_first_of("*#%") != std::string::npos;
        if (!json_.ok() || !many || fs::is_regular_file(path, ignored))
            return existing(value, what);
        const Result<std::vector<fs::path>> slices = texture::volume_files(path);
        if (!slices) {
            json_.fail(value,
                       fmt::format("{} `{}` names no file; paths count from the world's folder",
                                   what, path.string()));
            return path;
        }
        world_.files.insert(world_.files.end(), slices->begin(), slices->end());
        return path;
    }

    static std::optional<std::array<double, 3>> three(const std::vector<double>& v) {
        if (v.size() != 3) return std::nullopt;
        return std::array<double, 3>{v[0], v[1], v[2]};
    }

    /// A number for all axes, or one each.
    std::optional<std::array<double, 3>> spacing(const JsonValue& value, const std::string& what) {
        std::vector<double> sizes;
        if (value.is(JsonValue::Kind::kArray)) {
            sizes = json_.numbers(value, what, 3, 1e6);
        } else {
            sizes.assign(3, json_.number(value, what, 1e-6, 1e6));
        }
        for (const double size : sizes) {
            if (json_.ok() && !(size >= 1e-6)) json_.fail(value, what + " must be above 0");
        }
        return three(sizes);
    }

    void fablet(const JsonMember& m) {
        const std::string what = fmt::format("fablet `{}`", m.key);
        if (!json_.object(m.value, world_keys("fablet"), what)) return;
        FabletRef ref;
        ref.source = path_of(m.value.find("source")->value, "the source of " + what);
        ref.fablet = json_.string(m.value.find("fablet")->value, "`fablet` of " + what);
        ref.place = json_.place(m.value);
        world_.fablets.emplace(m.key, std::move(ref));
    }

    Rgba8 color(const JsonValue& value, const std::string& what, bool alpha) {
        Rgba8 out{0, 0, 0, 255};
        const std::string text = json_.string(value, what);
        if (!json_.ok()) return out;
        const bool length_fits = text.size() == 7 || (alpha && text.size() == 9);
        const bool digits =
            length_fits && text[0] == '#' &&
            text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
        if (!digits) {
            json_.fail(value,
                       fmt::format("{} is `{}`; write it as {}", what, text,
                                   alpha ? "#rrggbb or #rrggbbaa" : "#rrggbb (it is opaque)"));
            return out;
        }
        for (size_t i = 0; i * 2 + 1 < text.size(); ++i) {
            out[i] = static_cast<uint8_t>(std::stoi(text.substr(1 + i * 2, 2), nullptr, 16));
        }
        return out;
    }

    void material(const JsonMember& m) {
        const std::string what = fmt::format("material `{}`", m.key);
        if (!json_.object(m.value, world_keys("material"), what)) return;
        Material material;
        material.name = m.key;
        const JsonValue& key = m.value.find("key")->value;
        material.key = material.preview = color(key, "`key` of " + what, false);
        for (const Material& other : world_.materials) {
            if (other.key == material.key) {
                json_.fail(key, fmt::format("{} has the key colour of material `{}`; keys tell "
                                            "materials apart in slices "
                                            "and must differ",
                                            what, other.name));
            }
        }
        if (const JsonMember* p = m.value.find("preview")) {
            material.preview = color(p->value, "`preview` of " + what, true);
        }
        if (const JsonMember* p = m.value.find("density_g_cm3")) {
            material.density_g_cm3 =
                json_.number(p->value, "`density_g_cm3` of " + what, 0.001, 30);
        }
        if (const JsonMember* p = m.value.find("channel")) {
            material.channel = json_.string(p->value, "`channel` of " + what);
        }
        material.place = json_.place(m.value);
        if (world_.materials.size() == kMostMaterials) {
            json_.fail(m.value, fmt::format("more than {} materials; a world has at most that many",
                                            kMostMaterials));
        }
        world_.materials.push_back(std::move(material));
    }

    void texture(const JsonMember& m) {
        const std::string what = fmt::format("texture `{}`", m.key);
        if (!json_.object(m.value, world_keys("texture"), what)) return;
        Texture texture;
        texture.name = m.key;
        texture.file = image_files(m.value.find("file")->value, "the file of " + what);
        const auto choice = [&](const char* key, const std::vector<std::string>& choices,
                                size_t otherwise) {
            const JsonMember* p = m.value.find(key);
            return p == nullptr
                       ? otherwise
                       : json_.choice(p->value, fmt::format("`{}` of {}", key, what), choices);
        };
        texture.wrap = static_cast<Wrap>(choice("wrap", {"clamp", "repeat", "mirror", "black"}, 1));
        texture.filter =
            static_cast<Filter>(choice("filter", {"trilinear", "anisotropic", "nearest"}, 1));
        texture.space = static_cast<Space>(choice("space", {"auto", "srgb", "linear", "data"}, 0));
        texture.luminance = choice("channels", {"all", "luminance"}, 0) == 1;
        if (const JsonMember* p = m.value.find("origin_mm"))
            texture.origin_mm = three(json_.numbers(p->value, "`origin_mm` of " + what, 3, 1e6));
        if (const JsonMember* p = m.value.find("spacing_mm"))
            texture.spacing_mm = spacing(p->value, "`spacing_mm` of " + what);
        texture.place = json_.place(m.value);
        world_.textures.push_back(std::move(texture));
    }

    double unit_mm(const JsonValue& value, const std::string& what) {
        static const std::vector<std::string> kNames = {"mm", "cm", "m", "um", "in"};
        static constexpr double kSizes[] = {1, 10, 1000, 0.001, 25.4};
        return kSizes[json_.choice(value, "`unit` of " + what, kNames)];
    }

    void mesh(const JsonMember& m) {
        const std::string what = fmt::format("mesh `{}`", m.key);
        if (!json_.object(m.value, world_keys("mesh"), what)) return;
        const JsonMember* source = nullptr;
        for (const char* key : {"file", "box", "sphere", "cylinder", "plane"}) {
            const JsonMember* p = m.value.find(key);
            if (p == nullptr) continue;
            if (source != nullptr) {
                return json_.fail_at(
                    p->line, p->column,
                    fmt::format("{} has `{}` and `{}`; it is one of them", what, source->key, key));
            }
            source = p;
        }
        if (source == nullptr) {
            return json_.fail(
                m.value,
                fmt::format("{} has no `file`; give one, or a `box`, `sphere`, `cylinder` or "
                            "`plane` in mm",
                            what));
        }
        if (source->key == "file") {
            mesh_file(m, source->value, what);
        } else {
            for (const char* key : {"unit", "groups", "groups_attribute"}) {
                if (const JsonMember* p = m.value.find(key)) {
                    return json_.fail_at(
                        p->line, p->column,
                        fmt::format("`{}` of {} goes with a `file`; a {} is in mm and has its own "
                                    "`face` numbers",
                                    key, what, source->key));
                }
            }
            primitive(*source, what);
        }
        if (json_.ok()) world_.meshes.back().name = m.key;
    }

    void primitive(const JsonMember& source, const std::string& what) {
        const std::string name = fmt::format("`{}` of {}", source.key, what);
        const auto sizes = [&](size_t count) {
            std::vector<double> out =
                json_.numbers(source.value, name, count, kLargestPrimitive_mm);
            for (size_t i = 0; i < count && json_.ok(); ++i) {
                if (!(out[i] > 0))
                    json_.fail(source.value.items[i], name + " has a size that is not above 0 mm");
            }
            return out;
        };
        Mesh mesh;
        if (source.key == "box") {
            const std::vector<double> s = sizes(3);
            mesh = make_box({s[0], s[1], s[2]});
        } else if (source.key == "sphere") {
            mesh = make_sphere(json_.number(source.value, name, 1e-6, kLargestPrimitive_mm));
        } else if (source.key == "cylinder") {
            const std::vector<double> s = sizes(2);
            mesh = make_cylinder(s[0], s[1]);
        } else {
            const std::vector<double> s = sizes(2);
            mesh = make_plane(s[0], s[1]);
        }
        world_.meshes.push_back(std::move(mesh));
    }

    void mesh_file(const JsonMember& m, const JsonValue& value, const std::string& what) {
        const fs::path file = existing(value, "the file of " + what);
        if (json_.ok() && !is_mesh_file(file)) {
            json_.fail(value,
                       fmt::format("{} is `{}`, which is no mesh by its extension; meshes are {}",
                                   what, file.filename().string(), mesh_formats()));
        }
        MeshOptions options;
        options.name = m.key;
        if (const JsonMember* p = m.value.find("unit")) options.unit_mm = unit_mm(p->value, what);
        if (const JsonMember* p = m.value.find("groups_attribute")) {
            options.groups_attribute = json_.string(p->value, "`groups_attribute` of " + what);
            const std::string& name = options.groups_attribute;
            if (json_.ok() && (name.empty() || name == "uv" || name == "n" || name == "color")) {
                json_.fail(
                    p->value,
                    fmt::format(
                        "`groups_attribute` of {} is `{}`, a name that is taken; choose another",
                        what, name));
            }
        }
        if (const JsonMember* p = m.value.find("groups")) {
            options.groups.emplace();
            if (!json_.named_things(p->value, "groups")) return;
            for (const JsonMember& group : p->value.members) {
                (*options.groups)[group.key] =
                    json_.integer(group.value, fmt::format("group `{}` of {}", group.key, what),
                                  INT32_MIN, INT32_MAX);
            }
        }
        if (!json_.ok()) return;
        Result<LoadedMesh> loaded = load_mesh(file, options);
        if (!loaded) return json_.fail_with(loaded.error());
        world_.files.insert(world_.files.end(), loaded->files.begin(), loaded->files.end());
        for (std::string& warning : loaded->warnings)
            world_.warnings.push_back(std::move(warning));
        world_.meshes.push_back(std::move(loaded->mesh));
    }

    /// The place of a thing by the name that `value` gives; -1 after an error.
    int32_t reference(const JsonValue& value, const std::string& what, const char* kind,
                      const std::vector<std::string>& names) {
        const std::string name = json_.string(value, what);
        if (!json_.ok()) return -1;
        const auto it = std::find(names.begin(), names.end(), name);
        if (it != names.end()) return static_cast<int32_t>(it - names.begin());
        json_.fail(value,
                   fmt::format("no {} is called `{}`; {}", kind, name, suggest(name, names)));
        return -1;
    }

    void object(const JsonMember& m) {
        const std::string what = fmt::format("object `{}`", m.key);
        if (!json_.object(m.value, world_keys("object"), what)) return;
        Object object;
        object.name = m.key;
        object.mesh = reference(m.value.find("mesh")->value, "`mesh` of " + what, "mesh",
                                names_of(world_.meshes));
        std::vector<std::string> fablets;
        for (const auto& [name, ref] : world_.fablets)
            fablets.push_back(name);
        const JsonValue& fablet = m.value.find("fablet")->value;
        if (reference(fablet, "`fablet` of " + what, "fablet", fablets) >= 0)
            object.fablet = fablet.text;
        if (const JsonMember* p = m.value.find("priority")) {
            object.priority =
                json_.integer(p->value, "`priority` of " + what, -1'000'000, 1'000'000);
        }
        if (const JsonMember* p = m.value.find("max_displacement_mm")) {
            object.max_displacement_mm =
                json_.number(p->value, "`max_displacement_mm` of " + what, 0, 1e4);
        }
        if (const JsonMember* p = m.value.find("uniforms"))
            object.uniforms = uniforms(p->value, what);
        if (const JsonMember* p = m.value.find("support")) {
            if (json_.boolean(p->value, "`support` of " + what)) {
                json_.fail(
                    p->value,
                    fmt::format(
                        "support for {} is not supported yet; leave it out, the printer's front "
                        "end can make it",
                        what));
            }
        }
        if (const JsonMember* p = m.value.find("repair")) {
            json_.choice(p->value, "`repair` of " + what, {"winding"});
            json_.fail(
                p->value,
                fmt::format("`repair` of {} is not supported yet; close the mesh, and leave it out",
                            what));
        }
        object.place = json_.place(m.value);
        world_.objects.push_back(std::move(object));
    }

    UniformBindings uniforms(const JsonValue& value, const std::string& what) {
        UniformBindings out;
        if (!json_.named_things(value, "uniforms")) return out;
        for (const JsonMember& m : value.members) {
            Result<UniformBinding> binding = uniform_binding(
                m.value, json_.place(m.value), fmt::format("uniform `{}` of {}", m.key, what));
            if (!binding) {
                json_.fail_with(binding.error());
                return out;
            }
            out.emplace(m.key, std::move(*binding));
        }
        return out;
    }

    void build(const JsonValue& value) {
        if (!json_.ok()) return;
        if (!value.is(Kind::kArray) || value.items.empty()) {
            return json_.fail(
                value, fmt::format("`build` is {}; it must be an array of one or more placements",
                                   value.is(Kind::kArray) ? "empty" : value.kind_name()));
        }
        if (value.items.size() > kMostPlacements) {
            return json_.fail(value,
                              fmt::format("`build` has {} placements; at most {} are possible",
                                          value.items.size(), kMostPlacements));
        }
        for (size_t i = 0; i < world_.objects.size(); ++i) {
            object_index_[world_.objects[i].name] = static_cast<int32_t>(i);
        }
        for (size_t i = 0; i < value.items.size() && json_.ok(); ++i) {
            placement(value.items[i], fmt::format("build[{}]", i));
        }
    }

    void placement(const JsonValue& value, const std::string& what) {
        if (!json_.object(value, world_keys("placement"), what)) return;
        Placement placement;
        const JsonValue& object = value.find("object")->value;
        const auto found = object_index_.find(object.text);
        placement.object =
            found != object_index_.end()
                ? found->second
                : reference(object, "`object` of " + what, "object", names_of(world_.objects));
        placement.place = json_.place(value);
        transform(value, what, &placement);
        if (const JsonMember* p = value.find("uniforms"))
            placement.overrides = uniforms(p->value, what);
        world_.build.push_back(std::move(placement));
    }

    void transform(const JsonValue& value, const std::string& what, Placement* placement) {
        const JsonMember* matrix = value.find("matrix");
        const JsonValue* culprit = &value;
        Vec3d scale{1, 1, 1};
        Vec3d rotate;
        Vec3d translate;
        for (const char* key : {"scale", "rotate_deg", "translate_mm"}) {
            const JsonMember* p = value.find(key);
            if (p == nullptr) continue;
            if (matrix != nullptr) {
                return json_.fail_at(
                    p->line, p->column,
                    fmt::format("{} has `matrix` and `{}`; it is one or the other", what, key));
            }
            const std::string name = fmt::format("`{}` of {}", key, what);
            if (p->key == "scale" && p->value.is(Kind::kNumber)) {
                const double s = json_.number(p->value, name, 0 - kLargestScale, kLargestScale);
                scale = {s, s, s};
            } else {
                const std::vector<double> n = json_.numbers(p->value, name, 3, kFarthest_mm);
                (p->key == "scale"        ? scale
                 : p->key == "rotate_deg" ? rotate
                                          : translate) = {n[0], n[1], n[2]};
            }
            if (p->key == "scale") culprit = &p->value;
        }
        if (matrix != nullptr) {
            culprit = &matrix->value;
            placement->transform = read_matrix(matrix->value, "`matrix` of " + what);
        } else {
            placement->transform = placement_transform(scale, rotate, translate);
        }
        if (!json_.ok()) return;
        if (const Result<PolarFactors> polar = polar_factors(placement->transform.m); !polar) {
            json_.fail(*culprit, polar.error().message);
        }
    }

    /// 12 numbers, or 3 rows of 4.
    Affine3d read_matrix(const JsonValue& value, const std::string& what) {
        std::vector<double> n;
        if (value.is(Kind::kArray) && value.items.size() == 3) {
            for (size_t row = 0; row < 3; ++row) {
                for (double v : json_.numbers(value.items[row], fmt::format("{}[{}]", what, row), 4,
                                              kFarthest_mm)) {
                    n.push_back(v);
                }
            }
        } else {
            n = json_.numbers(value, what + " (3 rows of 4, or 12 numbers row by row)", 12,
                              kFarthest_mm);
        }
        return {{n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]}, {n[3], n[7], n[11]}};
    }

    fs::path file_;
    JsonReader json_;
    World world_;
    std::map<std::string, int32_t>
        object_index_;  ///< worlds may have a hundred thousand placements
};

/// Flattens numbers, booleans or strings; arrays may hold arrays (of the same) one level down.
bool flatten(const JsonValue& value, int depth, UniformBinding* out, bool* first, Kind* kind,
             const JsonValue** culprit) {
    if (value.is(Kind::kArray) && depth < 2) {
        for (const JsonValue& item : value.items) {
            if (!flatten(item, depth + 1, out, first, kind, culprit)) return false;
        }
        return true;
    }
    const bool allowed =
        value.is(Kind::kNumber) || value.is(Kind::kBool) || value.is(Kind::kString);
    if (!allowed || (!*first && value.kind != *kind)) {
        *culprit = &value;
        return false;
    }
    if (*first) {
        *first = false;
        *kind = value.kind;
        out->boolean = value.is(Kind::kBool);
        if (value.is(Kind::kString)) out->value = std::vector<std::string>();
    }
    if (value.is(Kind::kString)) {
        std::get<std::vector<std::string>>(out->value).push_back(value.text);
    } else {
        std::get<std::vector<double>>(out->value)
            .push_back(value.is(Kind::kBool) ? (value.boolean ? 1 : 0) : value.number);
    }
    return true;
}

}  // namespace

std::string Place::str() const {
    if (line <= 0) return file;
    return fmt::format("{}:{}:{}", file, line, column);
}

Result<UniformBinding> uniform_binding(const JsonValue& value, const Place& place,
                                       const std::string& what) {
    UniformBinding out;
    out.place = place;
    bool first = true;
    Kind kind = Kind::kNull;
    const JsonValue* culprit = nullptr;
    if (!flatten(value, 0, &out, &first, &kind, &culprit)) {
        const bool mixed = !first && culprit->kind != kind && !culprit->is(Kind::kArray) &&
                           !culprit->is(Kind::kObject);
        return user_error(fmt::format(
            "{}: {} {}; it must be a number, a boolean, the name of a texture or material, or an "
            "array of these",
            Place{place.file, culprit->line, culprit->column}.str(), what,
            mixed ? "mixes kinds of values" : fmt::format("holds {}", culprit->kind_name())));
    }
    if (first)
        return user_error(
            fmt::format("{}: {} is an empty array; give its values", place.str(), what));
    return out;
}

Result<World> load_world(const fs::path& file) {
    return WorldReader(file).read();
}

}  // namespace openfab::scene
