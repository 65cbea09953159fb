// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <unordered_map>

#include "base/json.h"
#include "base/keyed_hash.h"
#include "base/near_miss.h"
#include "base/talking_program.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/primitives.h"
#include "world/beams_reader.h"
#include "world/build_reader.h"
#include "world/dither_ref.h"
#include "world/json_reader.h"
#include "world/mesh_files_reader.h"
#include "world/messages.h"
#include "world/nearly_equal_stretch.h"
#include "world/pieces_reader.h"
#include "world/primitive_reader.h"
#include "world/program_reader.h"
#include "world/texture_reader.h"
#include "world/uniform_values.h"
#include "world/unit_reader.h"
#include "world/world_files.h"

namespace openfab::world {
namespace {

using Kind = JsonValue::Kind;
namespace fs = std::filesystem;

/// As many as slices have codes for.
constexpr size_t kMostMaterials = 254;

/// A key of a mesh beside what it is of, and with which of these it goes.
struct MeshKey {
    const char* key;
    std::array<std::string_view, 3> sources;
    const char *message, *help;

    bool goes_with(std::string_view source) const {
        return std::find(sources.begin(), sources.end(), source) != sources.end();
    }
};

constexpr MeshKey kMeshKeys[] = {
    {"box_mm",
     {"shape", "grow", "program"},
     messages::kBoxWithoutShape,
     messages::kBoxWithoutShapeHelp},
    {"attributes", {"program"}, messages::kGoesWithProgram, ""},
    {"places", {"program"}, messages::kGoesWithProgram, ""},
    {"answer_s", {"program"}, messages::kGoesWithProgram, ""},
    {"answer_mb", {"program"}, messages::kGoesWithProgram, ""},
    {"version", {"program"}, messages::kGoesWithProgram, ""},
    {"body", {"file", "beams"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
    {"unit", {"file", "beams"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
    {"up", {"file"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
    {"origin_mm", {"file"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
    {"groups", {"file"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
    {"groups_attribute", {"file"}, messages::kGoesWithFile, messages::kGoesWithFileHelp},
};

class WorldReader {
  public:
    WorldReader(const fs::path& file, const FileRules& rules, MeshFiles mesh_files)
        : file_(file),
          skips_mesh_files_(mesh_files == MeshFiles::kSkip),
          extent_of_(skips_mesh_files_ ? nullptr : rules.extent_of),
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
            BuildReader(&json_, &files_, &world_, memory_left_, extent_of_)
                .read(groups != nullptr ? &groups->value : nullptr, root->find("build")->value,
                      arrange != nullptr ? &arrange->value : nullptr);
        }
        if (!json_.ok()) return json_.error();
        mesh_files_.warn_of_sizes();
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
            std::unordered_map<std::string, int32_t, KeyedHash> materials;
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

    void texture(const JsonMember& m) { read_texture(m, &json_, &files_, &world_); }

    /// What a mesh is of.
    struct MeshSource {
        std::string key;
        void (WorldReader::*read)(const JsonMember& mesh, const JsonMember& source,
                                  const std::string& what);
    };
    static const std::vector<MeshSource>& mesh_sources() {
        static const std::vector<MeshSource> sources = [] {
            std::vector<MeshSource> all{{"file", &WorldReader::file},
                                        {"beams", &WorldReader::beams},
                                        {"shape", &WorldReader::stage},
                                        {"grow", &WorldReader::stage},
                                        {"program", &WorldReader::program}};
            for (const std::string& key : primitive_keys())
                all.push_back({key, &WorldReader::primitive});
            return all;
        }();
        return sources;
    }

    /// The source that a mesh has, of which it must have one.
    struct Sourced {
        const JsonMember* member = nullptr;
        const MeshSource* source = nullptr;
    };
    Sourced source_of(const JsonMember& m, const std::string& what) {
        Sourced out;
        for (const MeshSource& source : mesh_sources()) {
            const JsonMember* p = m.value.find(source.key);
            if (p == nullptr) continue;
            if (out.member != nullptr) {
                json_.fail_at(p->line, p->column,
                              fmt::format(messages::kBothKeys, what, out.member->key, source.key),
                              messages::kBothKeysHelp);
                return out;
            }
            out = {p, &source};
        }
        if (out.member == nullptr) {
            json_.fail(m.value, fmt::format(messages::kNoFile, what),
                       fmt::format(messages::kNoFileHelp, fmt::join(primitive_keys(), "`, `")));
        }
        return out;
    }

    void mesh(const JsonMember& m) {
        const std::string what = fmt::format("mesh `{}`", m.key);
        if (!json_.object(m.value, world_keys("mesh"), what)) return;
        const auto [source, reader] = source_of(m, what);
        if (!json_.ok()) return;
        for (const MeshKey& row : kMeshKeys) {
            const JsonMember* p = m.value.find(row.key);
            if (p == nullptr || row.goes_with(source->key)) continue;
            return json_.fail_at(p->line, p->column,
                                 fmt::format(fmt::runtime(row.message), row.key, what),
                                 fmt::format(fmt::runtime(row.help), source->key));
        }
        (this->*reader->read)(m, *source, what);
        if (!json_.ok()) return;
        world_.meshes.back().name = m.key;
        mesh_places_.emplace(m.key, last_mesh());
    }

    void load_meshes() {
        const int64_t bytes = mesh_files_.load(memory_left_);
        if (json_.ok() && mesh_files_.last() != nullptr) take_memory(*mesh_files_.last(), bytes);
    }

    bool take_memory(const JsonValue& value, int64_t bytes) {
        memory_left_ -= bytes;
        if (memory_left_ >= 0) return true;
        json_.fail(value, messages::kMeshesTakeTooMuch, messages::kAllowMoreMemory);
        return false;
    }

    void file(const JsonMember& m, const JsonMember& source, const std::string& what) {
        file_meshes_.insert(static_cast<int32_t>(world_.meshes.size()));
        mesh_files_.read(m, source.value, what, any_object_repairs(m.key));
    }

    void primitive(const JsonMember& /*m*/, const JsonMember& source, const std::string& what) {
        std::optional<mesh::Mesh> mesh =
            read_primitive(source, fmt::format("`{}` of {}", source.key, what), &json_);
        if (!mesh || !take_memory(source.value, mesh::mesh_bytes(mesh::counts_of(*mesh)))) return;
        world_.meshes.push_back(std::move(*mesh));
    }

    void beams(const JsonMember& m, const JsonMember& source, const std::string& what) {
        const fs::path file = files_.existing(source.value, "`beams` of " + what);
        mesh::BeamOptions options;
        options.memory_bytes = memory_left_;
        if (const JsonMember* p = m.value.find("unit"))
            options.unit_mm = read_unit_mm(p->value, what, &json_);
        if (const JsonMember* p = m.value.find("body"))
            options.body = json_.string(p->value, "`body` of " + what);
        if (!json_.ok()) return;
        if (skips_mesh_files_) {
            world_.meshes.emplace_back();
        } else {
            take_memory(source.value, add_beams(file, options, m.key, &json_, &world_));
        }
    }

    int32_t last_mesh() const { return static_cast<int32_t>(world_.meshes.size()) - 1; }

    void stage(const JsonMember& m, const JsonMember& source, const std::string& what) {
        if (reference(source.value, fmt::format("`{}` of {}", source.key, what), "fablet",
                      fablet_places_) < 0)
            return;
        box_of(source, m.value.find("box_mm"), what);
        if (json_.ok())
            world_.boxed[last_mesh()] = StageRef{source.value.text, json_.location(source.value)};
    }

    void program(const JsonMember& m, const JsonMember& source, const std::string& what) {
        box_of(source, m.value.find("box_mm"), what);
        if (json_.ok())
            world_.boxed[last_mesh()] = read_program(m.value, source.value, what, &json_, &files_);
    }

    /// A shape, or what a rule grows or a program makes, stands in the world as its box.
    void box_of(const JsonMember& source, const JsonMember* box, const std::string& what) {
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

    /// Returns the index of the object that `value` names; -1 after an error.
    int32_t reference(const JsonValue& value, const std::string& what, const char* kind,
                      const std::unordered_map<std::string, int32_t, KeyedHash>& indices) {
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
            if (json_.ok() && file_meshes_.count(object.mesh) == 0)
                json_.fail_at(p->line, p->column, fmt::format(messages::kRepairWithoutFile, what),
                              messages::kRepairWithoutFileHelp);
        }
        if (const JsonMember* p = m.value.find("pieces")) {
            object.pieces = read_pieces(p->value, what, world_, &json_, &files_);
            if (object.pieces != nullptr)
                check_pieces_hold_something(world_.meshes[object.mesh], *object.pieces, what,
                                            &json_);
            // A box or nothing stands for what has no mesh.
            const bool has_fits =
                object.pieces != nullptr &&
                std::ranges::any_of(object.pieces->regions, [](const pieces::Region& region) {
                    return !region.fits.empty();
                });
            if (has_fits && world_.boxed.contains(object.mesh))
                world_.notes.push_back(fmt::format(messages::kConnectorsNotCompared, m.key));
        }
        object.location = json_.location(fablet);
        object.mesh_location = json_.location(m.value.find("mesh")->value);
        world_.objects.push_back(std::move(object));
    }

    fs::path file_;
    const bool skips_mesh_files_;
    const ExtentOf extent_of_;
    const JsonValue* root_ = nullptr;  ///< while read runs
    JsonReader json_;
    WorldFiles files_;
    World world_;
    MeshFilesReader mesh_files_{&json_, &files_, &world_};
    int64_t memory_left_;
    std::unordered_map<std::string, int32_t, KeyedHash> mesh_places_, fablet_places_;
    std::set<int32_t> file_meshes_;
    std::optional<std::set<std::string>> repaired_;  ///< meshes, once one was looked for
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
