// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "base/affine.h"
#include "base/input_file.h"
#include "base/scan_number.h"
#include "base/xml.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/threemf_looks.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {
namespace {

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
        ThreemfPart* root = part("", *model);
        if (root == nullptr) return *error_;
        // Counts first: components may repeat objects, so the file's size is no bound.
        place_all(root, &ThreemfReader::count);
        check_memory();
        if (error_) return *error_;
        mesh_.reserve(counts_);
        place_all(root, &ThreemfReader::add_mesh);
        if (error_) return *error_;
        if (root->model.build.empty())
            mesh_.warnings().push_back(fmt::format("{}: the build has no items", file_));
        MeshSource source = mesh_.finish(file_, root->model.unit_mm);
        source.left_out = std::move(told_.list());
        return source;
    }

  private:
    /// Where an object is placed.
    struct Place {
        Affine3d transform;
        std::vector<std::string>* names = nullptr;  ///< of the objects that hold it, and its own
        size_t depth = 0;
        int32_t assembly = 0;
        BodyRole role = BodyRole::kPart;
    };

    using Use = void (ThreemfReader::*)(ThreemfPart*, const ThreemfObject&, const Place&);

    void fail(const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what), help);
    }

    Result<std::string> load(const std::string& name) { return zip_.read(name, memory_bytes_); }

    /// Returns the part that part `from` calls `name`.
    ThreemfPart* part(const std::string& from, const std::string& name) {
        const std::string path = zip_.resolve(from, name);
        const std::string key = ZipFile::key(path);
        const auto it = parts_.find(key);
        if (it != parts_.end()) return &it->second;
        const Result<std::string> text = zip_.has(path) ? load(path) : load(name);
        if (!text) {
            if (!error_) error_ = text.error();
            return nullptr;
        }
        // The text lives as long as it is parsed.
        const auto length = static_cast<int64_t>(text->size());
        memory_bytes_ -= length;
        Result<ThreemfModel> model =
            parse_threemf_model(*text, fmt::format("{}: {}", file_, name), &memory_bytes_, &told_);
        memory_bytes_ += length;
        if (!model) {
            if (!error_) error_ = model.error();
            return nullptr;
        }
        return &parts_.emplace(key, ThreemfPart{path, std::move(*model), {}}).first->second;
    }

    void place_all(ThreemfPart* root, Use use) {
        placements_ = 0;
        assemblies_ = 0;
        is_counting_ = use == &ThreemfReader::count;
        std::vector<std::string> names;
        for (const ThreemfPlacement& item : root->model.build) {
            if (!item.printable) {
                leave_out("items of the build that are switched off",
                          fmt::format("object {}", item.object),
                          "switch them on in the slicer if they shall be printed");
                continue;
            }
            place(root, item, {.names = &names, .assembly = assemblies_++}, use);
        }
    }

    /// Tells once, of two times that all is placed.
    void leave_out(const std::string& what, const std::string& place, const std::string& remedy) {
        if (is_counting_) told_.add(what, place, remedy);
    }

    static std::string name_of(const ThreemfObject& object, int64_t id) {
        return object.name.empty() ? fmt::format("object {}", id)
                                   : fmt::format("object `{}`", object.name);
    }

    /// Calls `use` for the object and all of its components; `at` is where its holder is.
    void place(ThreemfPart* from, const ThreemfPlacement& placement, Place at, Use use) {
        if (error_) return;
        if (at.depth > kMaxDepth)
            return fail(
                fmt::format("objects are nested more than {} deep, or in themselves", kMaxDepth));
        if (++placements_ > kMaxPlacements)
            return fail(fmt::format("more than {} objects are placed", kMaxPlacements));
        ThreemfPart* in = placement.path.empty() ? from : part(from->name, placement.path);
        if (in == nullptr) return;
        const auto it = in->model.objects.find(placement.object);
        if (it == in->model.objects.end())
            return fail(
                fmt::format("an item or component refers to object {}, which does not exist",
                            placement.object));
        const ThreemfObject& object = it->second;
        if (!is_printed(object, placement.object)) return;
        const bool named = !object.name.empty() && std::find(at.names->begin(), at.names->end(),
                                                             object.name) == at.names->end();
        if (named) at.names->push_back(object.name);
        at.transform = product(at.transform, placement.transform);
        if (!object.triangles.empty()) (this->*use)(in, object, at);
        place_components(in, object, placement.object, at, use);
        if (named) at.names->pop_back();
    }

    bool is_printed(const ThreemfObject& object, int64_t id) {
        const std::string name = name_of(object, id);
        if (!object.helper.empty()) {
            leave_out(object.helper, name, "they only say something to the slicer");
            return false;
        }
        if (object.type != "model") {
            leave_out(fmt::format("objects of type `{}`", object.type), name,
                      "objects of type `model` are printed; change the type if this is a part");
            return false;
        }
        if (object.stand_in)
            fail(fmt::format("the mesh of {} is a stand-in (meshresolution `lowres`) for slices, "
                             "which are not read",
                             name),
                 "export it with full resolution");
        return true;
    }

    void place_components(ThreemfPart* in, const ThreemfObject& object, int64_t id, Place at,
                          Use use) {
        using Shape = ThreemfObject::Shape;
        ++at.depth;
        if (object.shape == Shape::kDifference) {
            // What is cut out of something that is itself cut out would be there.
            if (at.role == BodyRole::kNegative)
                return fail(
                    fmt::format("{} is cut out of another, and is cut itself", name_of(object, id)),
                    "unite or cut the meshes in the program that made them");
            at.assembly = assemblies_++;
        }
        if (object.shape == Shape::kOther)
            return fail(fmt::format("{} is an intersection of others, which is not supported",
                                    name_of(object, id)),
                        "intersect the meshes in the program that made them");
        bool is_first = true;
        for (const ThreemfPlacement& component : object.components) {
            if (object.shape == Shape::kDifference && !is_first) at.role = BodyRole::kNegative;
            is_first = false;
            place(in, component, at, use);
        }
    }

    void count(ThreemfPart*, const ThreemfObject& object, const Place&) {
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

    void add_mesh(ThreemfPart* in, const ThreemfObject& object, const Place& at) {
        const int32_t body = add_body(object.name, at);
        mesh_.begin_part();
        const auto first = static_cast<int32_t>(mesh_.vertices());
        for (const Vec3d& v : object.vertices) {
            const Vec3d p = at.transform.apply(v);
            if (!is_position(p.x, p.y, p.z))
                return fail(fmt::format("a vertex of object `{}` is not finite or too far away",
                                        object.name));
            mesh_.add_vertex(p);
        }
        const bool mirrored = determinant(at.transform) < 0;
        std::map<int32_t, int32_t> groups;  // by look
        for (const ThreemfTriangle& t : object.triangles) {
            const ThreemfFace face = face_of(in, object, t);
            std::array<int32_t, 3> corners = t.vertices;
            for (int32_t& v : corners)
                v += first;
            if (mirrored) std::swap(corners[1], corners[2]);
            const auto [group, fresh] = groups.try_emplace(face.look, 0);
            if (fresh) {
                group->second = group_of(face.look, body, *at.names);
                check_names();
                if (error_) return;
            }
            mesh_.add_triangle(corners, group->second);
            set(looks_.color(), face.color, mirrored);
            set(looks_.uv(), face.uv, mirrored);
        }
        check_names();
    }

    void check_names() {
        const int64_t bytes = mesh_.group_bytes() + body_bytes_ + looks_.bytes();
        // Allocators round up.
        if (bytes + bytes / 16 > memory_bytes_)
            fail(
                "the names and materials of the objects take more memory than is allowed; allow "
                "more with `--memory`");
    }

    int32_t add_body(const std::string& own_name, const Place& at) {
        Body body;
        body.name = !own_name.empty() || at.names->empty() ? own_name : at.names->back();
        body.role = at.role;
        body.assembly = at.assembly;
        body_bytes_ += static_cast<int64_t>(3 * sizeof body + body.name.size());
        mesh_.bodies().push_back(std::move(body));
        return static_cast<int32_t>(mesh_.bodies().size() - 1);
    }

    int32_t group_of(int32_t look, int32_t body, const std::vector<std::string>& names) {
        FaceGroup group;
        group.names = names;
        group.look = look;
        group.body = body;
        if (look >= 0) {
            const Look& of = mesh_.looks()[static_cast<size_t>(look)];
            if (of.is_material || of.picture) group.material = of.name;
        }
        return mesh_.group_index(group);
    }

    ThreemfFace face_of(ThreemfPart* in, const ThreemfObject& object, const ThreemfTriangle& t) {
        const bool own = t.properties[0] >= 0;
        const int64_t group = own && t.group >= 0 ? t.group : object.group;
        if (group < 0) return {};
        std::array<int64_t, 3> picks = t.properties;
        if (!own) picks.fill(object.property);
        return looks_.face(in, object, group, picks);
    }

    void set(const std::optional<size_t>& attribute,
             const std::optional<std::array<int32_t, 3>>& values, bool mirrored) {
        if (!attribute || !values) return;
        std::array<int32_t, 3> corners = *values;
        if (mirrored) std::swap(corners[1], corners[2]);
        mesh_.set_corners(*attribute, corners);
    }

    ZipFile zip_;
    std::string file_;
    std::map<std::string, ThreemfPart> parts_;
    MeshAssembly mesh_;
    ThreemfTold told_;
    ThreemfLooks looks_{&mesh_, zip_, &told_};
    int64_t body_bytes_ = 0;
    std::optional<Error> error_;
    int64_t placements_ = 0;
    int32_t assemblies_ = 0;
    bool is_counting_ = false;
    int64_t memory_bytes_;  ///< besides the models
    MeshCounts counts_;     ///< of all placed objects
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

Result<void> read_threemf_pictures(const std::filesystem::path& file,
                                   std::span<const std::string> sources, int64_t memory_bytes,
                                   const TakePicture& take) {
    Result<InputFile> input = InputFile::open(file);
    if (!input) return Error(input.error());
    const Result<std::string> bytes = input->read_all(memory_bytes);
    if (!bytes) return bytes.error();
    const Result<ZipFile> zip = ZipFile::open(*bytes, file.string());
    if (!zip) return zip.error();
    const int64_t left = memory_bytes - static_cast<int64_t>(bytes->size());
    for (size_t i = 0; i < sources.size(); ++i)
        take(i, zip->read(sources[i], left));
    return Ok{};
}

}  // namespace openfab::mesh
