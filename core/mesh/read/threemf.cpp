// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "base/affine.h"
#include "base/scan_number.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_displaced_corners.h"
#include "mesh/read/threemf_looks.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/threemf_package.h"
#include "mesh/read/threemf_paint.h"
#include "mesh/read/threemf_project.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {
namespace {

/// Components may repeat objects, so that the file's size does not bound these.
constexpr int64_t kMaxTriangles = 50'000'000;
constexpr int64_t kMaxPlacements = 100'000;
constexpr size_t kMaxDepth = 32;

class ThreemfReader {
  public:
    ThreemfReader(ZipFile zip, std::string file, int64_t memory_bytes)
        : zip_(std::move(zip)), file_(std::move(file)), memory_bytes_(memory_bytes) {}

    Result<MeshSource> read() {
        Result<ThreemfPackage> package = read_threemf_package(zip_, file_, memory_bytes_);
        if (!package) return package.error();
        package_ = std::move(*package);
        Result<ThreemfProject> project = read_threemf_project(zip_, file_, &memory_bytes_, &told_);
        if (!project) return project.error();
        project_ = std::move(*project);
        const size_t beside = told_.list().size();
        ThreemfPart* root = part("", package_.model);
        if (root == nullptr) return *error_;
        // Counts first: components may repeat objects, so the file's size is no bound.
        place_all(root, &ThreemfReader::count);
        tell_of_unplaced();
        check_memory();
        if (error_) return *error_;
        mesh_.reserve(counts_);
        place_all(root, &ThreemfReader::add_mesh);
        if (error_) return *error_;
        if (root->model.build.empty())
            return user_error(fmt::format(messages::kBuildNoItems, file_), messages::kAddToBuild);
        if (mesh_.triangles() == 0 && told_.list().size() > beside) {
            const LeftOut& first = told_.list()[beside];
            return user_error(
                fmt::format(messages::kNothingLeftToPrint, file_, first.what, first.place),
                first.remedy);
        }
        MeshSource source = mesh_.finish(file_, root->model.unit_mm);
        project_.tell_of_unused_paint(&told_);
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
        const ThreemfProjectObject* project = nullptr;  ///< what a slicer says of the item
        const ThreemfVolume* volume = nullptr;          ///< and of the component
        int32_t extruder = 0;
        int64_t* passed = nullptr;  ///< triangles of the item before
    };

    using Piece = ThreemfPiece;
    using Use = void (ThreemfReader::*)(ThreemfPart*, const ThreemfObject&, const Place&);

    void fail(const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what), help);
    }

    Result<std::string> load(const std::string& name) {
        return package_.read(zip_, name, file_, memory_bytes_);
    }

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
        for (auto& [id, object] : model->objects) {
            const std::string wrong = project_.paint(id, name_of(object, id), &object);
            if (!wrong.empty()) return fail(wrong), nullptr;
            is_painted_ = is_painted_ || !object.paints.empty();
            const Result<void> painted = apply_threemf_paint(
                &object, fmt::format("{}: {}", file_, name_of(object, id)), &memory_bytes_, &told_);
            if (painted) continue;
            error_ = painted.error();
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
                leave_out(messages::kItemsSwitchedOff, fmt::format("object {}", item.object),
                          messages::kSwitchThemOn);
                mark_placed(root, item);
                continue;
            }
            int64_t passed = 0;
            Place at{.names = &names, .assembly = assemblies_++, .passed = &passed};
            const auto project = project_.objects.find(item.object);
            if (project != project_.objects.end() && item.path.empty()) {
                at.project = &project->second;
                at.extruder = at.project->extruder;
            }
            place(root, item, at, use);
        }
    }

    /// Marks an object and its components as some that an item is about.
    void mark_placed(ThreemfPart* from, const ThreemfPlacement& placement) {
        ThreemfPart* in = placement.path.empty() ? from : part(from->name, placement.path);
        if (in == nullptr) return;
        const auto it = in->model.objects.find(placement.object);
        if (it == in->model.objects.end() || !placed_.insert(&it->second).second) return;
        for (const ThreemfPlacement& component : it->second.components)
            mark_placed(in, component);
    }

    void tell_of_unplaced() {
        is_counting_ = true;
        for (const auto& [path, each] : parts_) {
            for (const auto& [id, object] : each.model.objects) {
                if (object.triangles.empty() || placed_.count(&object) > 0) continue;
                leave_out(messages::kObjectsNotPlaced, name_of(object, id),
                          messages::kObjectsNotPlacedHelp);
            }
        }
        placed_.clear();
    }

    /// Tells once, of two times that all is placed.
    void leave_out(const std::string& what, const std::string& place, const std::string& remedy) {
        if (is_counting_) told_.add(what, place, remedy);
    }

    void leave_out(const ThreemfVolume& volume, const std::string& object) {
        leave_out(volume.extruder > 0 ? volume.kind + messages::kThatNameAnExtruder : volume.kind,
                  volume.name.empty() ? object : fmt::format("volume `{}`", volume.name),
                  messages::kSlicerVolumeHelp);
    }

    static std::string name_of(const ThreemfObject& object, int64_t id) {
        return object.name.empty() ? fmt::format("object {}", id)
                                   : fmt::format("object `{}`", object.name);
    }

    /// Calls `use` for the object and all of its components; `at` is where its holder is.
    void place(ThreemfPart* from, const ThreemfPlacement& placement, Place at, Use use) {
        if (error_) return;
        if (at.depth > kMaxDepth) return fail(fmt::format(messages::kNestedTooDeep, kMaxDepth));
        if (++placements_ > kMaxPlacements)
            return fail(fmt::format(messages::kTooManyObjects, kMaxPlacements));
        ThreemfPart* in = placement.path.empty() ? from : part(from->name, placement.path);
        if (in == nullptr) return;
        const auto it = in->model.objects.find(placement.object);
        if (it == in->model.objects.end())
            return fail(fmt::format(messages::kNoSuchObject, placement.object));
        const ThreemfObject& object = it->second;
        if (is_counting_) placed_.insert(&object);
        // An item without components is its only volume.
        if (at.project != nullptr && (at.depth > 0 || object.components.empty())) {
            const ThreemfVolume* volume = at.project->component(placement.object);
            if (volume != nullptr) at.volume = volume;
        }
        if (!is_printed(object, placement.object, at.volume)) return;
        if (at.volume != nullptr && at.volume->role == BodyRole::kNegative)
            at.role = BodyRole::kNegative;
        if (at.volume != nullptr && at.volume->extruder > 0) at.extruder = at.volume->extruder;
        if (object.extruder > 0) at.extruder = object.extruder;
        const std::string& name = name_at(object, at);
        const bool named =
            !name.empty() && std::find(at.names->begin(), at.names->end(), name) == at.names->end();
        if (named) at.names->push_back(name);
        at.transform = product(at.transform, placement.transform);
        if (!object.triangles.empty()) (this->*use)(in, object, at);
        place_components(in, object, placement.object, at, use);
        if (named) at.names->pop_back();
    }

    /// The name of an object in the model, or what the slicer calls it.
    static const std::string& name_at(const ThreemfObject& object, const Place& at) {
        if (!object.name.empty()) return object.name;
        if (at.volume != nullptr && at.volume->part >= 0) return at.volume->name;
        return at.depth == 0 && at.project != nullptr ? at.project->name : object.name;
    }

    bool is_printed(const ThreemfObject& object, int64_t id, const ThreemfVolume* volume) {
        const std::string name = name_of(object, id);
        if (volume != nullptr && volume->part >= 0) {
            if (volume->role == BodyRole::kNotPrinted) leave_out(*volume, name);
            return volume->role != BodyRole::kNotPrinted;
        }
        if (!object.helper.empty()) {
            leave_out(object.helper, name, messages::kOnlyForTheSlicer);
            return false;
        }
        if (object.type != "model") {
            leave_out(fmt::format(messages::kObjectsOfType, object.type), name,
                      messages::kObjectTypeHelp);
            return false;
        }
        if (object.stand_in)
            fail(fmt::format(messages::kMeshIsAStandIn, name), messages::kMeshIsAStandInHelp);
        return true;
    }

    void place_components(ThreemfPart* in, const ThreemfObject& object, int64_t id, Place at,
                          Use use) {
        using Shape = ThreemfObject::Shape;
        ++at.depth;
        if (object.shape == Shape::kDifference) {
            // What is cut out of something that is itself cut out would be there.
            if (at.role == BodyRole::kNegative)
                return fail(fmt::format(messages::kCutAndCutting, name_of(object, id)),
                            messages::kCutAndCuttingHelp);
            at.assembly = assemblies_++;
        }
        if (object.shape == Shape::kOther)
            return fail(fmt::format(messages::kIntersectionOfOthers, name_of(object, id)),
                        messages::kIntersectionOfOthersHelp);
        bool is_first = true;
        for (const ThreemfPlacement& component : object.components) {
            if (object.shape == Shape::kDifference && !is_first) at.role = BodyRole::kNegative;
            is_first = false;
            place(in, component, at, use);
        }
    }

    /// Returns the bodies of an object, in the order of a slicer's volumes.
    std::vector<Piece> pieces_of(const ThreemfObject& object, const Place& at) {
        if (at.project == nullptr || !at.project->has_ranges()) return {Piece()};
        std::vector<Piece> pieces = at.project->split(object, at.passed);
        std::erase_if(pieces, [&](const Piece& piece) {
            const bool dropped =
                piece.volume != nullptr && piece.volume->role == BodyRole::kNotPrinted;
            if (dropped && !piece.triangles.empty()) leave_out(*piece.volume, at.project->name);
            return dropped || piece.triangles.empty();
        });
        return pieces;
    }

    void count(ThreemfPart*, const ThreemfObject& object, const Place& at) {
        const auto vertices = static_cast<int64_t>(object.vertices.size());
        for (const Piece& piece : pieces_of(object, at)) {
            const auto triangles = static_cast<int64_t>(
                piece.triangles.empty() ? object.triangles.size() : piece.triangles.size());
            counts_.triangles += triangles;
            counts_.vertices +=
                piece.triangles.empty() ? vertices : std::min(vertices, 3 * triangles);
        }
        if (counts_.triangles > kMaxTriangles || counts_.vertices > kMaxTriangles)
            fail(messages::kBuildTooManyTriangles);
    }

    /// Checks that the counted mesh fits in memory beside the models, and can then be checked.
    void check_memory() {
        constexpr int64_t kKinds = 2;  // colours and coordinates
        counts_.attributes = kKinds;
        const bool displaced = std::any_of(parts_.begin(), parts_.end(), [](const auto& part) {
            return part.second.model.displacements != nullptr;
        });
        if (displaced) {
            constexpr int64_t kAtCorners = 3 * 7;
            counts_.attributes += 2;
            counts_.values += kAtCorners * counts_.triangles;
        }
        const int64_t needed = preparing_bytes(counts_);
        if (!error_ && needed > memory_bytes_)
            error_ = too_large_to_read(file_, counts_.triangles, needed, memory_bytes_);
    }

    void add_mesh(ThreemfPart* in, const ThreemfObject& object, const Place& at) {
        std::vector<int32_t> numbers(object.vertices.size(), -1);  // of vertices in the mesh
        for (const Piece& piece : pieces_of(object, at)) {
            Place of = at;
            std::string name = name_at(object, at);
            if (piece.volume != nullptr) {
                if (piece.volume->role == BodyRole::kNegative) of.role = BodyRole::kNegative;
                if (piece.volume->extruder > 0) of.extruder = piece.volume->extruder;
                if (!piece.volume->name.empty()) name = piece.volume->name;
            }
            const int32_t body = add_body(name, of);
            mesh_.begin_part();
            displaced_.begin_body();
            std::map<int32_t, int32_t> groups;  // by look
            if (piece.triangles.empty()) {
                for (size_t v = 0; v < numbers.size(); ++v)
                    vertex(object, of, static_cast<int32_t>(v), &numbers);
                for (size_t t = 0; t < object.triangles.size(); ++t)
                    add_triangle(in, object, of, t, body, &numbers, &groups);
            } else {
                for (const int32_t t : piece.triangles)
                    add_triangle(in, object, of, static_cast<size_t>(t), body, &numbers, &groups);
                // Bodies share no vertices.
                for (const int32_t t : piece.triangles) {
                    for (const int32_t v : object.triangles[static_cast<size_t>(t)].vertices)
                        numbers[static_cast<size_t>(v)] = -1;
                }
            }
            check_names();
        }
    }

    /// Returns the number of a vertex of an object in the mesh, adding it on first use.
    int32_t vertex(const ThreemfObject& object, const Place& at, int32_t v,
                   std::vector<int32_t>* numbers) {
        int32_t& number = (*numbers)[static_cast<size_t>(v)];
        if (number >= 0) return number;
        const Vec3d p = at.transform.apply(object.vertices[static_cast<size_t>(v)]);
        if (!is_position(p.x, p.y, p.z))
            fail(fmt::format(messages::kObjectVertexTooFar, object.name));
        return number = mesh_.add_vertex(p);
    }

    void add_triangle(ThreemfPart* in, const ThreemfObject& object, const Place& at, size_t t,
                      int32_t body, std::vector<int32_t>* numbers,
                      std::map<int32_t, int32_t>* groups) {
        if (error_) return;
        const ThreemfTriangle& triangle = object.triangles[t];
        const int32_t filament = object.filaments.empty() ? 0 : object.filaments[t];
        const ThreemfFace face = face_of(in, object, triangle, filament, at.extruder);
        std::array<int32_t, 3> corners{};
        for (size_t c = 0; c < 3; ++c)
            corners[c] = vertex(object, at, triangle.vertices[c], numbers);
        const bool mirrored = determinant(at.transform) < 0;
        if (mirrored) std::swap(corners[1], corners[2]);
        const auto [group, fresh] = groups->try_emplace(face.look, 0);
        if (fresh) {
            group->second = group_of(face.look, body, *at.names);
            check_names();
        }
        mesh_.add_triangle(corners, group->second);
        if (in->model.displacements != nullptr) {
            if (const Complaint wrong =
                    displaced_.set(*in->model.displacements, object, at.transform, t, mirrored);
                !wrong.empty())
                return fail(wrong.what);
        }
        set(looks_.color(), face.color, mirrored);
        set(looks_.uv(), face.uv, mirrored);
    }

    void check_names() {
        const int64_t bytes = mesh_.group_bytes() + body_bytes_ + looks_.bytes();
        // Allocators round up.
        if (bytes + bytes / 16 > memory_bytes_) fail(messages::kThreemfNamesTakeTooMuch);
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

    /// A triangle's own properties count first, then its paint, those of the object, the extruder. A filament that the slicer
    /// mixes counts before: it prints that, whatever else the file says for other programs.
    ThreemfFace face_of(ThreemfPart* in, const ThreemfObject& object, const ThreemfTriangle& t,
                        int32_t filament, int32_t extruder) {
        if (is_mixed(filament > 0 ? filament : extruder))
            return {.look = filament_look(filament, extruder)};
        const bool own = t.properties[0] >= 0;
        const int64_t group = own && t.group >= 0 ? t.group : object.group;
        if (group < 0 || (!own && filament > 0)) return {.look = filament_look(filament, extruder)};
        std::array<int64_t, 3> picks = t.properties;
        if (!own) picks.fill(object.property);
        return looks_.face(in, object, group, picks);
    }

    bool is_mixed(int32_t filament) const {
        const auto at = static_cast<size_t>(filament);
        return at > 0 && at <= project_.filaments.size() &&
               !project_.filaments[at - 1].mixture.empty();
    }

    int32_t filament_look(int32_t filament, int32_t extruder) {
        if (filament == 0) filament = extruder;
        if (filament == 0) {
            if (project_.filaments.empty() && !is_painted_) return -1;
            filament = 1;
        }
        const auto [known, fresh] = filament_looks_.try_emplace(filament, -1);
        if (!fresh) return known->second;
        ThreemfFilament one;
        if (static_cast<size_t>(filament) <= project_.filaments.size())
            one = project_.filaments[static_cast<size_t>(filament) - 1];
        if (one.name.empty()) one.name = fmt::format("extruder {}", filament);
        if (!one.mixture.empty()) {
            std::map<int32_t, double> mixed;
            for (const auto& [component, share] : one.mixture) {
                const bool plain =
                    project_.filaments[static_cast<size_t>(component) - 1].mixture.empty();
                if (plain && share > 0) mixed[filament_look(component, 0)] += share;
            }
            const int32_t look = looks_.mixture(mixed);
            if (look >= 0) return filament_looks_[filament] = look;
        }
        return known->second = looks_.filament(one.name, one.color);
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
    ThreemfDisplacedCorners displaced_{&mesh_};
    ThreemfLooks looks_{&mesh_, zip_, &told_};
    ThreemfPackage package_;
    ThreemfProject project_;
    std::map<int32_t, int32_t> filament_looks_;
    bool is_painted_ = false;
    int64_t body_bytes_ = 0;
    std::optional<Error> error_;
    int64_t placements_ = 0;
    int32_t assemblies_ = 0;
    std::set<const ThreemfObject*> placed_;  ///< while they are counted
    bool is_counting_ = false;
    int64_t memory_bytes_;  ///< besides the models
    MeshCounts counts_;     ///< of all placed objects
};

}  // namespace

Result<MeshSource> parse_threemf(std::string_view bytes, const std::string& file,
                                 int64_t memory_bytes) {
    Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    return ThreemfReader(std::move(*zip), file, memory_bytes).read();
}

}  // namespace openfab::mesh
