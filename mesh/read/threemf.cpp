// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "base/affine.h"
#include "base/scan_number.h"
#include "base/xml.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {
namespace {

using Kind = ThreemfGroup::Kind;

/// Components may repeat objects, so that the file's size does not bound these.
constexpr int64_t kMaxTriangles = 50'000'000;
constexpr int64_t kMaxPlacements = 100'000;
constexpr size_t kMaxDepth = 32;

/// Finds the model in the package's relationships.
class Relationships : public XmlHandler {
  public:
    std::string model;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        const char* type = a.find("Type");
        const char* target = a.find("Target");
        if (name == "Relationship" && type != nullptr && target != nullptr && model.empty() &&
            std::string_view(type).ends_with("/3dmodel"))
            model = target;
        return {};
    }
    void end(std::string_view) override {}
};

class ThreemfReader {
  public:
    ThreemfReader(ZipFile zip, std::string file, int64_t memory_bytes)
        : zip_(std::move(zip)), file_(std::move(file)), memory_bytes_(memory_bytes) {}

    Result<MeshSource> read() {
        const Result<std::string> relationships = load("_rels/.rels");
        if (!relationships) return relationships.error();
        const Result<std::string> model = threemf_model_part(*relationships, file_);
        if (!model) return model.error();
        Part* root = part(*model);
        if (root == nullptr) return *error_;
        // Counts first: components may repeat objects, so the file's size is no bound.
        std::vector<std::string> names;
        for (const ThreemfPlacement& item : root->model.build)
            place(*root, item, {}, &names, 0, &ThreemfReader::count);
        check_memory();
        if (error_) return *error_;
        mesh_.reserve(counts_);
        placements_ = 0;
        for (const ThreemfPlacement& item : root->model.build)
            place(*root, item, {}, &names, 0, &ThreemfReader::add_mesh);
        if (error_) return *error_;
        warn_of_what_is_left_out(root->model.build.empty());
        return mesh_.finish(file_, root->model.unit_mm);
    }

  private:
    /// A model, with the indices of its property values in the mesh.
    struct Part {
        ThreemfModel model;
        std::map<int64_t, std::vector<int32_t>> values;  ///< by group; -2: not added yet
    };

    /// The resolved properties of a triangle.
    struct Properties {
        std::string material;
        std::optional<std::array<int32_t, 3>> color, uv;  ///< values by corner
    };

    void fail(const std::string& what) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what));
    }

    Result<std::string> load(const std::string& name) { return zip_.read(name, memory_bytes_); }

    Part* part(const std::string& name) {
        const std::string path = ZipFile::key(name);
        const auto it = parts_.find(path);
        if (it != parts_.end()) return &it->second;
        const Result<std::string> text = load(name);
        if (!text) {
            if (!error_) error_ = text.error();
            return nullptr;
        }
        // The text lives as long as it is parsed.
        const auto length = static_cast<int64_t>(text->size());
        memory_bytes_ -= length;
        Result<ThreemfModel> model =
            parse_threemf_model(*text, fmt::format("{}: {}", file_, name), &memory_bytes_);
        memory_bytes_ += length;
        if (!model) {
            if (!error_) error_ = model.error();
            return nullptr;
        }
        beams_ = beams_ || model->has_beams;
        return &parts_.emplace(path, Part{std::move(*model), {}}).first->second;
    }

    using Use = void (ThreemfReader::*)(Part*, const ThreemfObject&, const Affine3d&,
                                        const std::vector<std::string>&);

    /// Calls `use` for the object and all of its components.
    void place(Part& from, const ThreemfPlacement& placement, const Affine3d& outer,
               std::vector<std::string>* names, size_t depth, Use use) {
        if (error_) return;
        if (depth > kMaxDepth)
            return fail(
                fmt::format("objects are nested more than {} deep, or in themselves", kMaxDepth));
        if (++placements_ > kMaxPlacements)
            return fail(fmt::format("more than {} objects are placed", kMaxPlacements));
        Part* in = placement.path.empty() ? &from : part(placement.path);
        if (in == nullptr) return;
        const auto it = in->model.objects.find(placement.object);
        if (it == in->model.objects.end())
            return fail(
                fmt::format("an item or component refers to object {}, which does not exist",
                            placement.object));
        const ThreemfObject& object = it->second;
        if (object.type != "model") {
            other_types_ = true;
            return;
        }
        const bool named = !object.name.empty() &&
                           std::find(names->begin(), names->end(), object.name) == names->end();
        if (named) names->push_back(object.name);
        const Affine3d transform = product(outer, placement.transform);
        if (!object.triangles.empty()) (this->*use)(in, object, transform, *names);
        for (const ThreemfPlacement& component : object.components)
            place(*in, component, transform, names, depth + 1, use);
        if (named) names->pop_back();
    }

    void count(Part*, const ThreemfObject& object, const Affine3d&,
               const std::vector<std::string>&) {
        counts_.vertices += static_cast<int64_t>(object.vertices.size());
        counts_.triangles += static_cast<int64_t>(object.triangles.size());
        if (counts_.triangles > kMaxTriangles || counts_.vertices > kMaxTriangles)
            fail("the build has too many triangles");
    }

    /// Checks that the counted mesh fits in memory beside the models, and can then be checked.
    void check_memory() {
        constexpr int64_t kKinds = 2;  // colours and coordinates
        counts_.attributes = kKinds;
        const int64_t needed = preparing_bytes(counts_);
        if (!error_ && needed > memory_bytes_)
            error_ = too_large_to_read(file_, counts_.triangles, needed, memory_bytes_);
    }

    void add_mesh(Part* in, const ThreemfObject& object, const Affine3d& transform,
                  const std::vector<std::string>& names) {
        mesh_.begin_part();
        const auto first = static_cast<int32_t>(mesh_.vertices());
        for (const Vec3d& v : object.vertices) {
            const Vec3d p = transform.apply(v);
            if (!is_position(p.x, p.y, p.z))
                return fail(fmt::format("a vertex of object `{}` is not finite or too far away",
                                        object.name));
            mesh_.add_vertex(p);
        }
        const bool mirrored = determinant(transform) < 0;
        const int32_t names_number = number_of(names);
        std::map<std::string, int32_t> groups;  // by material
        for (const ThreemfTriangle& t : object.triangles) {
            Properties properties;
            const bool own = t.properties[0] >= 0;
            const int64_t group = own && t.group >= 0 ? t.group : object.group;
            std::array<int64_t, 3> picks = t.properties;
            if (!own) picks.fill(object.property);
            if (group >= 0) resolve(in, group, picks, true, &properties);
            std::array<int32_t, 3> corners = t.vertices;
            for (int32_t& v : corners)
                v += first;
            if (mirrored) std::swap(corners[1], corners[2]);
            const auto [group_of, fresh] = groups.try_emplace(properties.material, 0);
            if (fresh) group_of->second = group_index(names_number, names, properties.material);
            mesh_.add_triangle(corners, group_of->second);
            set(color_, properties.color, mirrored);
            set(uv_, properties.uv, mirrored);
        }
        if (mesh_.group_bytes() + names_bytes_ > memory_bytes_)
            fail(
                "the names of the objects take more memory than is allowed; allow more with "
                "`--memory`");
    }

    int32_t number_of(const std::vector<std::string>& names) {
        const auto [known, fresh] = names_.try_emplace(names, static_cast<int32_t>(names_.size()));
        constexpr size_t kNode = 64;
        if (fresh) names_bytes_ += static_cast<int64_t>(sizeof names + kNode);
        for (size_t i = 0; fresh && i < names.size(); ++i)
            names_bytes_ += static_cast<int64_t>(sizeof names[i] + names[i].size());
        return known->second;
    }

    /// Nested objects have many and long names, which are not processed again for each material.
    int32_t group_index(int32_t names_number, const std::vector<std::string>& names,
                        const std::string& material) {
        const auto [known, fresh] = group_of_.try_emplace({names_number, material}, 0);
        constexpr size_t kNode = 64;
        if (fresh) {
            known->second = mesh_.group_index({names, material});
            names_bytes_ += static_cast<int64_t>(sizeof material + kNode + material.size());
        }
        return known->second;
    }

    void set(const std::optional<size_t>& attribute,
             const std::optional<std::array<int32_t, 3>>& values, bool mirrored) {
        if (!attribute || !values) return;
        std::array<int32_t, 3> corners = *values;
        if (mirrored) std::swap(corners[1], corners[2]);
        mesh_.set_corners(*attribute, corners);
    }

    void resolve(Part* in, int64_t id, const std::array<int64_t, 3>& picks, bool layers,
                 Properties* out) {
        const auto it = in->model.groups.find(id);
        if (it == in->model.groups.end()) {
            unknown_groups_ = true;
            return;
        }
        const ThreemfGroup& group = it->second;
        if (group.kind == Kind::kMaterials) {
            if (static_cast<size_t>(picks[0]) < group.names.size())
                out->material = group.names[picks[0]];
        } else if (group.kind == Kind::kColors) {
            out->color = values_of(in, id, group, picks, "color", 3, &color_);
        } else if (group.kind == Kind::kCoordinates) {
            out->uv = values_of(in, id, group, picks, "uv", 2, &uv_);
            if (out->material.empty()) out->material = threemf_texture_name(std::to_string(id));
        } else if (group.kind == Kind::kMulti && layers) {
            for (size_t layer = 0; layer < group.layers.size(); ++layer) {
                std::array<int64_t, 3> inner{};
                for (size_t c = 0; c < 3; ++c) {
                    if (static_cast<size_t>(picks[c]) >= group.picks.size()) return;
                    const auto& pick = group.picks[picks[c]];
                    inner[c] = layer < pick.size() ? pick[layer] : 0;
                }
                resolve(in, group.layers[layer], inner, false, out);
            }
        } else {
            unknown_groups_ = true;
        }
    }

    /// Returns the mesh's value for an entry of a group, adding it on first use.
    std::array<int32_t, 3> values_of(Part* in, int64_t id, const ThreemfGroup& group,
                                     const std::array<int64_t, 3>& picks, const char* name,
                                     int32_t components, std::optional<size_t>* attribute) {
        if (!*attribute) *attribute = mesh_.attribute(name, components);
        std::vector<int32_t>& values = in->values[id];
        values.resize(group.values.size(), -2);
        std::array<int32_t, 3> out{-1, -1, -1};
        for (size_t c = 0; c < 3; ++c) {
            const auto pick = static_cast<size_t>(picks[c]);
            if (pick >= values.size()) continue;
            if (values[pick] == -2)
                values[pick] = mesh_.add_value(**attribute, group.values[pick].data());
            out[c] = values[pick];
        }
        return out;
    }

    void warn_of_what_is_left_out(bool no_items) {
        const auto warn = [&](bool left_out, const char* what) {
            if (left_out) mesh_.warnings().push_back(fmt::format("{}: {}", file_, what));
        };
        warn(no_items, "the build has no items");
        warn(other_types_, "objects that are supports, surfaces or others are left out");
        warn(unknown_groups_,
             "some triangles have properties of a kind that is not read, or that are not there");
        warn(beams_, "lattices of beams are left out");
    }

    ZipFile zip_;
    std::string file_;
    std::map<std::string, Part> parts_;
    MeshAssembly mesh_;
    std::map<std::vector<std::string>, int32_t> names_;  ///< of groups, numbered
    std::map<std::pair<int32_t, std::string>, int32_t> group_of_;
    int64_t names_bytes_ = 0;           ///< of both
    std::optional<size_t> color_, uv_;  ///< attributes of the mesh
    std::optional<Error> error_;
    int64_t placements_ = 0;
    int64_t memory_bytes_;  ///< besides the models
    MeshCounts counts_;     ///< of all placed objects
    bool other_types_ = false;
    bool unknown_groups_ = false;
    bool beams_ = false;
};

}  // namespace

Result<std::string> threemf_model_part(std::string_view relationships, const std::string& file) {
    Relationships found;
    const Result<void> parsed =
        parse_xml(relationships, fmt::format("{}: _rels/.rels", file), &found);
    if (!parsed) return parsed.error();
    if (found.model.empty()) return user_error(fmt::format("{}: the file has no model", file));
    return found.model;
}

Result<MeshSource> parse_threemf(std::string_view bytes, const std::string& file,
                                 int64_t memory_bytes) {
    Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    return ThreemfReader(std::move(*zip), file, memory_bytes).read();
}

}  // namespace openfab::mesh
