// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>
#include <unordered_map>

#include "base/json.h"
#include "base/near_miss.h"
#include "base/talking_program.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/primitives.h"
#include "world/beams_reader.h"
#include "world/build_reader.h"
#include "world/dither_ref.h"
#include "world/json_reader.h"
#include "world/messages.h"
#include "world/nearly_equal_stretch.h"
#include "world/pieces_reader.h"
#include "world/primitive_reader.h"
#include "world/program_reader.h"
#include "world/uniform_values.h"
#include "world/world_files.h"

namespace openfab::world {
namespace {

using Kind = JsonValue::Kind;
namespace fs = std::filesystem;

/// As many as slices have codes for.
constexpr size_t kMostMaterials = 254;
/// Each placement searches them linearly.
constexpr size_t kMostTextures = 4096;
/// The names of units of length in files.
const std::vector<std::string> kUnits = {"mm", "cm", "m", "um", "in"};

class WorldReader {
  public:
    WorldReader(const fs::path& file, const FileRules& rules, MeshFiles mesh_files)
        : file_(file),
          skips_mesh_files_(mesh_files == MeshFiles::kSkip),
          json_(file.string()),
          files_(file, rules, &json_),
          memory_left_(rules.memory_bytes) {
        world_.file = file;
        world_.programs_allowed = rules.programs;
    }

    Result<World> read() {
        Result<std::string> text = read_text_file(file_, kLargestWorld);
        if (!text) return text.error();
        const Result<JsonValue> root = parse_json(*text, file_.string(), memory_left_);
        if (!root) return root.error();
        text = std::string();
        memory_left_ -= json_bytes(*root);
        root_ = &*root;
        // In the order of references; a file may have them in any order.
        if (json_.object(*root, world_keys("world"), "the world")) {
            version(root->find("openfab")->value);
            if (const JsonMember* m = root->find("$schema")) json_.string(m->value, "`$schema`");
            if (const JsonMember* m = root->find("printer")) printer(m->value);
            if (const JsonMember* m = root->find("tray"))
                world_.tray = static_cast<Tray>(
                    json_.choice(m->value, "`tray`", {"anywhere", "corner", "center"}));
            section(*root, "fablets", &WorldReader::fablet);
            if (const JsonMember* m = root->find("dither"))
                world_.dither = read_dither(m->value, &json_, &files_);
            section(*root, "materials", &WorldReader::material);
            if (const JsonMember* m = root->find("support")) support(m->value);
            section(*root, "textures", &WorldReader::texture);
            section(*root, "meshes", &WorldReader::mesh);
            if (!skips_mesh_files_) load_meshes();
            section(*root, "objects", &WorldReader::object);
            const JsonMember* groups = root->find("groups");
            const JsonMember* arrange = root->find("arrange");
            BuildReader(&json_, &files_, &world_, memory_left_)
                .read(groups != nullptr ? &groups->value : nullptr, root->find("build")->value,
                      arrange != nullptr ? &arrange->value : nullptr);
        }
        if (!json_.ok()) return json_.error();
        if (const size_t changed = equalise_stretches(&world_); changed > 0) {
            world_.warnings.push_back(
                fmt::format(messages::kTransformsAlikeToSix, changed, world_.build.size()));
        }
        world_.files = files_.take();
        world_.roots = files_.roots();
        return std::move(world_);
    }

  private:
    void version(const JsonValue& value) {
        const double version = json_.number(value, "`openfab`", 0, 1e9);
        if (json_.ok() && version != 1) {
            json_.fail(value, fmt::format(messages::kWorldVersion, version),
                       messages::kWorldVersionHelp);
        }
    }

    /// Reads a profile's name, or a file's path, relative to the world's folder.
    void printer(const JsonValue& value) {
        world_.printer = json_.string(value, "`printer`");
        if (world_.printer.ends_with(".json")) {
            world_.printer = files_.existing(value, "the printer").string();
        }
    }

    /// Reads true, false, or the support material, which enables support.
    void support(const JsonValue& value) {
        world_.support.location = json_.location(value);
        if (value.is(Kind::kString)) {
            world_.support.on = true;
            std::unordered_map<std::string, int32_t> materials;
            for (const Material& material : world_.materials)
                materials.emplace(material.name, static_cast<int32_t>(materials.size()));
            if (reference(value, "`support`", "material", materials) >= 0)
                world_.support.material = value.text;
        } else if (value.is(Kind::kBool)) {
            world_.support.on = json_.boolean(value, "`support`");
        } else {
            json_.fail(value, messages::kSupportNeither);
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

    static std::optional<std::array<double, 3>> three(const std::vector<double>& v) {
        if (v.size() != 3) return std::nullopt;
        return std::array<double, 3>{v[0], v[1], v[2]};
    }

    /// Reads one number for all axes, or one for each.
    std::optional<std::array<double, 3>> spacing(const JsonValue& value, const std::string& what) {
        std::vector<double> sizes;
        if (value.is(JsonValue::Kind::kArray)) {
            sizes = json_.numbers(value, what, 3, 1e6);
        } else {
            sizes.assign(3, json_.number(value, what, 1e-6, 1e6));
        }
        for (const double size : sizes) {
            if (json_.ok() && !(size >= 1e-6)) json_.fail(value, what + messages::kMustBeAboveZero);
        }
        return three(sizes);
    }

    void fablet(const JsonMember& m) {
        const std::string what = fmt::format("fablet `{}`", m.key);
        if (!json_.object(m.value, world_keys("fablet"), what)) return;
        FabletRef ref;
        ref.source = files_.path(m.value.find("source")->value, "the source of " + what);
        ref.fablet = json_.string(m.value.find("fablet")->value, "`fablet` of " + what);
        ref.location = json_.location(m.value.find("fablet")->value);
        ref.source_location = json_.location(m.value.find("source")->value);
        if (const JsonMember* p = m.value.find("uniforms"))
            ref.uniforms = read_uniforms(p->value, what, &json_);
        fablet_places_.emplace(m.key, static_cast<int32_t>(fablet_places_.size()));
        world_.fablets.emplace(m.key, std::move(ref));
    }

    void material(const JsonMember& m) {
        const std::string what = fmt::format("material `{}`", m.key);
        if (!json_.object(m.value, world_keys("material"), what)) return;
        Material material;
        material.name = m.key;
        const JsonValue& key = m.value.find("key")->value;
        material.key = material.preview = json_.color(key, "`key` of " + what, false);
        for (const Material& other : world_.materials) {
            if (other.key == material.key) {
                json_.fail(key, fmt::format(messages::kSameKeyColour, what, other.name),
                           messages::kSameKeyColourHelp);
            }
        }
        if (const JsonMember* p = m.value.find("preview")) {
            material.preview = json_.color(p->value, "`preview` of " + what, true);
        }
        if (const JsonMember* p = m.value.find("density_g_cm3")) {
            material.density_g_cm3 =
                json_.number(p->value, "`density_g_cm3` of " + what, 0.001, 30);
        }
        if (const JsonMember* p = m.value.find("channel")) {
            material.channel = json_.string(p->value, "`channel` of " + what);
        }
        material.location = json_.location(m.value);
        if (world_.materials.size() == kMostMaterials) {
            json_.fail(m.value, fmt::format(messages::kTooManyMaterials, kMostMaterials),
                       messages::kTooManyMaterialsHelp);
        }
        world_.materials.push_back(std::move(material));
    }

    void texture(const JsonMember& m) {
        const std::string what = fmt::format("texture `{}`", m.key);
        if (!json_.object(m.value, world_keys("texture"), what)) return;
        Texture texture;
        texture.name = m.key;
        if (const JsonMember* p = m.value.find("time"))
            texture.time = json_.number(p->value, "`time` of " + what, -1e30, 1e30);
        texture.file =
            files_.images(m.value.find("file")->value, "the file of " + what, texture.time);
        const auto choice = [&](const char* key, const std::vector<std::string>& choices,
                                size_t otherwise) {
            const JsonMember* p = m.value.find(key);
            return p == nullptr
                       ? otherwise
                       : json_.choice(p->value, fmt::format("`{}` of {}", key, what), choices);
        };
        if (const JsonMember* p = m.value.find("wrap"))
            wrap(p->value, "`wrap` of " + what, &texture);
        texture.filter =
            static_cast<Filter>(choice("filter", {"trilinear", "anisotropic", "nearest"}, 1));
        texture.space = static_cast<Space>(choice("space", {"auto", "srgb", "linear", "data"}, 0));
        const auto channels = choice("channels", {"all", "luminance", "opaque"}, 0);
        texture.luminance = channels == 1;
        texture.opaque = channels == 2;
        if (const JsonMember* p = m.value.find("origin_mm"))
            texture.origin_mm = three(json_.numbers(p->value, "`origin_mm` of " + what, 3, 1e6));
        if (const JsonMember* p = m.value.find("spacing_mm"))
            texture.spacing_mm = spacing(p->value, "`spacing_mm` of " + what);
        if (const JsonMember* p = m.value.find("field"))
            texture.field = json_.string(p->value, "`field` of " + what);
        if (const JsonMember* p = m.value.find("unit"))
            texture.unit = kUnits[json_.choice(p->value, "`unit` of " + what, kUnits)];
        if (const JsonMember* p = m.value.find("pitch_mm"))
            texture.pitch_mm = json_.number(p->value, "`pitch_mm` of " + what, 1e-4, 1e6);
        if (const JsonMember* p = m.value.find("outside"))
            texture.outside = json_.number(p->value, "`outside` of " + what, -1e30, 1e30);
        texture.location = json_.location(m.value.find("file")->value);
        if (world_.textures.size() == kMostTextures) {
            json_.fail(m.value, fmt::format(messages::kTooManyTextures, kMostTextures));
        }
        world_.textures.push_back(std::move(texture));
    }

    /// One mode, or one along u and one along v.
    void wrap(const JsonValue& value, const std::string& what, Texture* texture) {
        static const std::vector<std::string> kModes = {"clamp", "repeat", "mirror", "black"};
        if (!value.is(JsonValue::Kind::kArray)) {
            texture->wrap = texture->wrap_v = static_cast<Wrap>(json_.choice(value, what, kModes));
            return;
        }
        if (value.items.size() != 2) {
            json_.fail(value,
                       value.items.size() == 1
                           ? what + messages::kOneMode
                           : fmt::format(messages::kWrongModes, what, value.items.size()),
                       messages::kWrongModesHelp);
            return;
        }
        texture->wrap = static_cast<Wrap>(json_.choice(value.items[0], what, kModes));
        texture->wrap_v = static_cast<Wrap>(json_.choice(value.items[1], what, kModes));
    }

    double unit_mm(const JsonValue& value, const std::string& what) {
        static constexpr double kSizes[] = {1, 10, 1000, 0.001, 25.4};
        return kSizes[json_.choice(value, "`unit` of " + what, kUnits)];
    }

    void mesh(const JsonMember& m) {
        const std::string what = fmt::format("mesh `{}`", m.key);
        if (!json_.object(m.value, world_keys("mesh"), what)) return;
        const JsonMember* source = nullptr;
        std::vector<std::string> sources = primitive_keys();
        sources.insert(sources.begin(), {"file", "beams", "shape", "grow", "program"});
        for (const std::string& key : sources) {
            const JsonMember* p = m.value.find(key);
            if (p == nullptr) continue;
            if (source != nullptr) {
                return json_.fail_at(p->line, p->column,
                                     fmt::format(messages::kBothKeys, what, source->key, key),
                                     messages::kBothKeysHelp);
            }
            source = p;
        }
        if (source == nullptr) {
            return json_.fail(
                m.value, fmt::format(messages::kNoFile, what),
                fmt::format(messages::kNoFileHelp, fmt::join(primitive_keys(), "`, `")));
        }
        const JsonMember* box = m.value.find("box_mm");
        const bool is_program = source->key == "program";
        const bool is_function = is_program || source->key == "shape" || source->key == "grow";
        if (box != nullptr && !is_function) {
            return json_.fail_at(box->line, box->column,
                                 fmt::format(messages::kBoxWithoutShape, what),
                                 messages::kBoxWithoutShapeHelp);
        }
        for (const char* key : kProgramKeys) {
            const JsonMember* p = m.value.find(key);
            if (p == nullptr || is_program) continue;
            return json_.fail_at(p->line, p->column,
                                 fmt::format(messages::kGoesWithProgram, key, what));
        }
        if (source->key == "file") {
            mesh_file(m, source->value, what);
        } else {
            for (const char* key :
                 {"body", "unit", "up", "origin_mm", "groups", "groups_attribute"}) {
                const std::string_view of = key;
                if (source->key == "beams" && (of == "unit" || of == "body")) continue;
                if (const JsonMember* p = m.value.find(key)) {
                    return json_.fail_at(p->line, p->column,
                                         fmt::format(messages::kGoesWithFile, key, what),
                                         fmt::format(messages::kGoesWithFileHelp, source->key));
                }
            }
            if (source->key == "beams") {
                beams(m, source->value, what);
            } else if (is_program) {
                shape(*source, box, what);
                if (!json_.ok()) return;
                ShapeRef& shape = world_.shapes.rbegin()->second;
                shape.program = read_program(m.value, source->value, what, &json_, &files_);
            } else if (is_function) {
                shape(*source, box, what);
            } else {
                primitive(*source, what);
            }
        }
        if (json_.ok()) {
            world_.meshes.back().name = m.key;
            mesh_places_.emplace(m.key, static_cast<int32_t>(world_.meshes.size() - 1));
        }
    }

    bool take_memory(const JsonValue& value, int64_t bytes) {
        memory_left_ -= bytes;
        if (memory_left_ >= 0) return true;
        json_.fail(value, messages::kMeshesTakeTooMuch, messages::kAllowMoreMemory);
        return false;
    }

    void primitive(const JsonMember& source, const std::string& what) {
        std::optional<mesh::Mesh> mesh =
            read_primitive(source, fmt::format("`{}` of {}", source.key, what), &json_);
        if (!mesh || !take_memory(source.value, mesh::mesh_bytes(mesh::counts_of(*mesh)))) return;
        world_.meshes.push_back(std::move(*mesh));
    }

    void beams(const JsonMember& m, const JsonValue& value, const std::string& what) {
        const fs::path file = files_.existing(value, "`beams` of " + what);
        mesh::BeamOptions options;
        options.memory_bytes = memory_left_;
        if (const JsonMember* p = m.value.find("unit")) options.unit_mm = unit_mm(p->value, what);
        if (const JsonMember* p = m.value.find("body"))
            options.body = json_.string(p->value, "`body` of " + what);
        if (!json_.ok()) return;
        if (skips_mesh_files_) {
            world_.meshes.emplace_back();
        } else {
            take_memory(value, add_beams(file, options, m.key, &json_, &world_));
        }
    }

    /// A shape, or what a rule grows or a program makes, stands in the world as its box.
    void shape(const JsonMember& source, const JsonMember* box, const std::string& what) {
        if (source.key != "program" &&
            reference(source.value, fmt::format("`{}` of {}", source.key, what), "fablet",
                      fablet_places_) < 0)
            return;
        if (box == nullptr) {
            return json_.fail(source.value, fmt::format(messages::kNoBox, what),
                              messages::kNoBoxHelp);
        }
        const std::string name = "`box_mm` of " + what;
        if (box->value.kind != JsonValue::Kind::kArray || box->value.items.size() != 2)
            return json_.fail(box->value, name + messages::kNotTwoCorners,
                              "write [[x, y, z], [x, y, z]]");
        std::array<std::vector<double>, 2> corners;
        for (size_t i = 0; i < 2; ++i) {
            corners[i] = json_.numbers(box->value.items[i], "a corner of " + name, 3, 1e5);
            if (!json_.ok()) return;
        }
        Vec3d low, size;
        for (int a = 0; a < 3; ++a) {
            const auto k = static_cast<size_t>(a);
            low[a] = corners[0][k];
            size[a] = corners[1][k] - corners[0][k];
            if (size[a] > 0) continue;
            return json_.fail(
                box->value,
                fmt::format(messages::kBoxTurned, name, corners[0][k], corners[1][k], "xyz"[k]),
                messages::kBoxTurnedHelp);
        }
        mesh::Mesh mesh = mesh::make_box(size);
        const Vec3d shift = low + Vec3d{size.x / 2, size.y / 2, 0};  // from where a box stands
        for (Vec3d& p : mesh.positions)
            p = p + shift;
        world_.shapes[static_cast<int32_t>(world_.meshes.size())] = {source.value.text,
                                                                     json_.location(source.value)};
        world_.meshes.push_back(std::move(mesh));
    }

    /// Objects are read after the meshes; a mesh that one of them repairs is repaired for all.
    bool any_object_repairs(const std::string& mesh) {
        const JsonMember* objects = root_->find("objects");
        if (objects == nullptr) return false;
        if (!repaired_) {
            repaired_.emplace();
            for (const JsonMember& object : objects->value.members) {
                const JsonMember* of = object.value.find("mesh");
                const JsonMember* repair = object.value.find("repair");
                if (of != nullptr && repair != nullptr && repair->value.text == "winding")
                    repaired_->insert(of->value.text);
            }
        }
        return repaired_->count(mesh) != 0;
    }

    void mesh_file(const JsonMember& m, const JsonValue& value, const std::string& what) {
        const bool of_whole = m.value.find("body") == nullptr;
        const fs::path file = files_.existing(value, "the file of " + what, of_whole);
        if (json_.ok() && !mesh::is_mesh_file(file)) {
            json_.fail(value,
                       fmt::format(messages::kNoMeshExtension, what, file.filename().string()),
                       fmt::format("supported: {}", mesh::mesh_formats()));
        }
        mesh::MeshOptions options;
        options.name = m.key;
        options.repair = any_object_repairs(m.key);
        if (const JsonMember* p = m.value.find("body")) {
            options.body = json_.string(p->value, "`body` of " + what);
            if (json_.ok() && options.body.empty())
                json_.fail(p->value, fmt::format(messages::kBodyEmpty, what),
                           messages::kBodyEmptyHelp);
        }
        if (const JsonMember* p = m.value.find("origin_mm")) {
            if (const auto at = three(json_.numbers(p->value, "`origin_mm` of " + what, 3, 1e9)))
                options.origin_mm = {(*at)[0], (*at)[1], (*at)[2]};
        }
        if (const JsonMember* p = m.value.find("unit")) options.unit_mm = unit_mm(p->value, what);
        if (const JsonMember* p = m.value.find("up")) {
            options.y_up = json_.choice(p->value, "`up` of " + what, {"z", "y"}) == 1;
            if (json_.ok() && mesh::format_says_up(file)) {
                json_.fail(p->value, fmt::format(messages::kGltfIsYUp, what),
                           messages::kLeaveItOut);
            }
        }
        if (const JsonMember* p = m.value.find("groups_attribute")) {
            options.groups_attribute = json_.string(p->value, "`groups_attribute` of " + what);
            const std::string& name = options.groups_attribute;
            if (json_.ok() && (name.empty() || name == "uv" || name == "n" || name == "color")) {
                json_.fail(p->value, fmt::format(messages::kGroupsAttributeTaken, what, name),
                           messages::kGroupsAttributeTakenHelp);
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
        mesh_files_.push_back({world_.meshes.size(), file, std::move(options), &value});
        world_.meshes.emplace_back();
    }

    /// The meshes of one file, which is read once: with one unit, and either all of bodies, or one of
    /// the whole.
    struct MeshLoad {
        std::vector<size_t> meshes;  ///< indices in mesh_files_
        uintmax_t file_bytes = 0;
    };
    std::vector<MeshLoad> mesh_loads() const {
        std::vector<MeshLoad> loads;
        std::map<std::pair<std::string, double>, size_t> known;
        for (size_t i = 0; i < mesh_files_.size(); ++i) {
            const MeshFile& mesh = mesh_files_[i];
            const bool of_bodies = !mesh.options.body.empty();
            const auto [it, fresh] = known.try_emplace(
                {mesh.file.string(), mesh.options.unit_mm.value_or(0)}, loads.size());
            if (fresh || !of_bodies) {
                std::error_code unknown;
                loads.push_back({{}, fs::file_size(mesh.file, unknown)});
                loads.back().meshes.push_back(i);
                // The whole of a file stands alone.
                if (fresh && !of_bodies) known.erase(it);
            } else {
                loads[it->second].meshes.push_back(i);
            }
        }
        return loads;
    }

    /// Loads all files of `meshes` in parallel; warnings and errors keep the order of the file.
    void load_meshes() {
        if (!json_.ok()) return;
        std::vector<std::optional<Result<mesh::LoadedMesh>>> loaded(mesh_files_.size());
        const std::vector<MeshLoad> loads = mesh_loads();
        // The largest first, for load balance.
        std::vector<std::pair<uintmax_t, size_t>> order;
        for (size_t i = 0; i < loads.size(); ++i)
            order.emplace_back(loads[i].file_bytes, i);
        std::sort(order.rbegin(), order.rend());
        std::atomic<size_t> next{0};
        std::atomic<int64_t> kept{0};
        const auto load = [&](const MeshLoad& one, int64_t memory_bytes) {
            std::vector<mesh::MeshOptions> options;
            for (const size_t i : one.meshes) {
                options.push_back(mesh_files_[i].options);
                options.back().memory_bytes = memory_bytes;
            }
            std::vector<Result<mesh::LoadedMesh>> meshes =
                mesh::load_meshes(mesh_files_[one.meshes[0]].file, options);
            for (size_t k = 0; k < meshes.size(); ++k) {
                if (meshes[k]) kept += mesh::mesh_bytes(mesh::counts_of(meshes[k]->mesh));
                loaded[one.meshes[k]].emplace(std::move(meshes[k]));
            }
        };
        // Each gets its share of half of the remaining memory. Files that do not fit are read
        // alone.
        constexpr int kMostAtOnce = 16;
        const auto shares = static_cast<int64_t>(std::min<size_t>(loads.size(), kMostAtOnce));
        const int64_t half = memory_left_ / 2;
        if (shares > 1) {
            tbb::task_arena arena(std::min(tbb::this_task_arena::max_concurrency(), kMostAtOnce));
            arena.execute([&] {
                tbb::parallel_for(size_t{0}, loads.size(), [&](size_t) {
                    const size_t i = order[next++].second;
                    if (kept < half) load(loads[i], half / shares);
                });
            });
        }
        for (const MeshLoad& one : loads) {
            const bool whole = std::all_of(one.meshes.begin(), one.meshes.end(), [&](size_t i) {
                return loaded[i].has_value() && *loaded[i];
            });
            if (whole) continue;
            for (const size_t i : one.meshes) {
                if (loaded[i] && *loaded[i])
                    kept -= mesh::mesh_bytes(mesh::counts_of((*loaded[i])->mesh));
            }
            load(one, memory_left_ - kept);
        }
        for (size_t i = 0; i < loaded.size(); ++i) {
            Result<mesh::LoadedMesh>& mesh = *loaded[i];
            if (!mesh) return json_.fail_with(mesh.error());
            for (const fs::path& other : mesh->files)
                files_.also(*mesh_files_[i].value, other);
            for (std::string& warning : mesh->warnings)
                world_.warnings.push_back(std::move(warning));
            world_.meshes[mesh_files_[i].index] = std::move(mesh->mesh);
        }
        if (!mesh_files_.empty()) take_memory(*mesh_files_.back().value, kept);
    }

    /// Returns the index of the object that `value` names; -1 after an error.
    int32_t reference(const JsonValue& value, const std::string& what, const char* kind,
                      const std::unordered_map<std::string, int32_t>& indices) {
        const std::string name = json_.string(value, what);
        if (!json_.ok()) return -1;
        const auto it = indices.find(name);
        if (it != indices.end()) return it->second;
        std::vector<std::string> names(indices.size());
        for (const auto& [known, index] : indices)
            names[index] = known;
        json_.fail(value, fmt::format(messages::kNoneOfName, kind, name), suggest(name, names));
        return -1;
    }

    void object(const JsonMember& m) {
        const std::string what = fmt::format("object `{}`", m.key);
        if (!json_.object(m.value, world_keys("object"), what)) return;
        Object object;
        object.name = m.key;
        object.mesh =
            reference(m.value.find("mesh")->value, "`mesh` of " + what, "mesh", mesh_places_);
        const JsonValue& fablet = m.value.find("fablet")->value;
        if (reference(fablet, "`fablet` of " + what, "fablet", fablet_places_) >= 0)
            object.fablet = fablet.text;
        if (!json_.ok()) return;
        if (const JsonMember* p = m.value.find("priority")) {
            object.priority =
                json_.integer(p->value, "`priority` of " + what, -1'000'000, 1'000'000);
        }
        if (const JsonMember* p = m.value.find("max_displacement_mm")) {
            object.max_displacement_mm =
                json_.number(p->value, "`max_displacement_mm` of " + what, 0, 1e4);
        }
        if (const JsonMember* p = m.value.find("uniforms"))
            object.uniforms = read_uniforms(p->value, what, &json_);
        const UniformBindings& usual = world_.fablets.at(object.fablet).uniforms;
        object.uniforms.insert(usual.begin(), usual.end());
        if (const JsonMember* p = m.value.find("support")) {
            object.support = json_.boolean(p->value, "`support` of " + what);
        }
        if (const JsonMember* p = m.value.find("repair")) {
            // Already done when the mesh was read.
            json_.choice(p->value, "`repair` of " + what, {"winding"});
        }
        if (const JsonMember* p = m.value.find("pieces")) {
            object.pieces = read_pieces(p->value, what, world_, &json_, &files_);
            if (object.pieces != nullptr)
                check_pieces_hold_something(world_.meshes[object.mesh], *object.pieces, what,
                                            &json_);
        }
        object.location = json_.location(fablet);
        object.mesh_location = json_.location(m.value.find("mesh")->value);
        world_.objects.push_back(std::move(object));
    }

    fs::path file_;
    const bool skips_mesh_files_;
    const JsonValue* root_ = nullptr;  ///< while read runs
    JsonReader json_;
    WorldFiles files_;
    World world_;
    int64_t memory_left_;
    std::unordered_map<std::string, int32_t> mesh_places_, fablet_places_;
    std::optional<std::set<std::string>> repaired_;  ///< meshes, once one was looked for
    struct MeshFile {
        size_t index = 0;  ///< in world_.meshes
        fs::path file;
        mesh::MeshOptions options;
        const JsonValue* value = nullptr;
    };
    std::vector<MeshFile> mesh_files_;
};

}  // namespace

FileRules rules_of(const std::vector<std::string>& allow, int64_t memory_bytes) {
    FileRules rules;
    rules.memory_bytes = memory_bytes;
    for (const std::string& one : allow) {
        if (one == kProgramsWord) {
            rules.programs = true;
        } else {
            rules.allowed.emplace_back(one);
        }
    }
    return rules;
}

Result<World> load_world(const fs::path& file, const FileRules& rules, MeshFiles mesh_files) {
    return WorldReader(file, rules, mesh_files).read();
}

}  // namespace openfab::world
