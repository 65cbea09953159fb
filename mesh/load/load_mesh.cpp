// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/load_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "base/json.h"
#include "base/text.h"
#include "mesh/check/mesh_check.h"
#include "mesh/check/mesh_intersections.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/gltf.h"
#include "mesh/read/obj.h"
#include "mesh/read/ply.h"
#include "mesh/read/stl.h"
#include "mesh/read/threemf.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxFileBytes = 2'000'000'000;
/// Triangles up to which each load looks for crossing ones.
constexpr size_t kMaxChecked = 200'000;

using Reader = Result<MeshSource> (*)(std::string_view bytes, const std::string& file,
                                      int64_t memory_bytes);

struct Format {
    const char* extension;
    Reader read;
};

constexpr Format kFormats[] = {{".obj", parse_obj},  {".stl", parse_stl},
                               {".ply", parse_ply},  {".gltf", parse_gltf},
                               {".glb", parse_gltf}, {".3mf", parse_threemf}};

const Format* find_format(const fs::path& file) {
    const std::string extension = lower_ascii(file.extension().string());
    for (const Format& format : kFormats) {
        if (extension == format.extension) return &format;
    }
    return nullptr;
}

/// Leaves out float attributes that some faces lack, and those that none has.
void drop_partial_attributes(MeshSource* source) {
    std::erase_if(source->mesh.attributes, [&](const MeshAttribute& a) {
        if (a.is_int) return false;
        size_t with = 0;
        size_t lacking = a.corners.size();
        for (size_t t = a.corners.size(); t-- > 0;) {
            const auto& c = a.corners[t];
            const bool has = c[0] >= 0 && c[1] >= 0 && c[2] >= 0;
            with += has;
            lacking = has ? lacking : t;
        }
        if (with > 0 && lacking < a.corners.size()) {
            source->warnings.push_back(fmt::format(
                "{}: some faces of mesh `{}` have no `{}`, this one first; the "
                "attribute is dropped",
                source->origin.str(static_cast<int32_t>(lacking)), source->mesh.name, a.name));
        }
        return with == 0 || lacking < a.corners.size();
    });
}

/// Returns the numbers of a mesh's groups.
class Groups {
  public:
    Groups(MeshSource* source, const MeshOptions& options, LoadedMesh* out)
        : source_(*source), options_(options), out_(*out) {}

    Result<void> number() {
        if (options_.groups) return by_map();
        by_order();
        return Ok{};
    }

  private:
    static std::vector<std::string> names_of(const FaceGroup& group) {
        std::vector<std::string> names = group.names;
        if (!group.material.empty()) names.push_back(group.material);
        if (names.empty()) names.emplace_back("default");
        return names;
    }

    /// Returns a triangle of each group.
    std::vector<int32_t> first_triangles() const {
        std::vector<int32_t> first(source_.groups.size(), -1);
        for (size_t t = source_.face_groups.size(); t-- > 0;)
            first[source_.face_groups[t]] = static_cast<int32_t>(t);
        return first;
    }

    Result<void> by_map() {
        // A file without groups has one group named "default".
        if (source_.groups.empty()) {
            source_.groups.push_back({});
            source_.face_groups.assign(source_.mesh.triangles.size(), 0);
        }
        const std::vector<int32_t> first = first_triangles();
        std::vector<int32_t> values(source_.groups.size());
        for (size_t g = 0; g < values.size(); ++g) {
            if (first[g] < 0) continue;
            const Result<int32_t> value = mapped(source_.groups[g], first[g]);
            if (!value) return value.error();
            values[g] = *value;
        }
        for (const auto& [name, value] : *options_.groups)
            out_.groups.emplace_back(name, value);
        add_attribute(values);
        return Ok{};
    }

    Result<int32_t> mapped(const FaceGroup& group, int32_t triangle) const {
        const std::vector<std::string> names = names_of(group);
        const std::string* found = nullptr;
        int32_t value = 0;
        for (const std::string& name : names) {
            const auto it = options_.groups->find(name);
            if (it == options_.groups->end()) continue;
            if (found != nullptr && value != it->second) {
                return error_at(
                    source_.origin.location(triangle),
                    fmt::format("the face is in group `{}` ({}) and in `{}` ({}) of \"groups\"",
                                *found, value, name, it->second),
                    "a face has one value");
            }
            value = it->second;
            found = &name;
        }
        if (found != nullptr) return value;
        std::string list;
        for (const std::string& name : names)
            list += fmt::format("{}`{}`", list.empty() ? "" : ", ", name);
        return error_at(
            source_.origin.location(triangle),
            fmt::format("the face is in group {}, which \"groups\" of mesh `{}` does not map", list,
                        options_.name),
            all_names());
    }

    std::string all_names() const {
        std::set<std::string> names;
        for (const FaceGroup& group : source_.groups) {
            names.insert(group.names.begin(), group.names.end());
            if (!group.material.empty()) names.insert(group.material);
        }
        if (names.empty()) return "the file names no groups";
        constexpr size_t kMost = 12;
        std::string text = "the file has ";
        size_t shown = 0;
        for (const std::string& name : names) {
            if (shown == kMost) return text + fmt::format(" and {} more", names.size() - kMost);
            text += fmt::format("{}`{}`", shown++ == 0 ? "" : ", ", name);
        }
        return text;
    }

    void by_order() {
        const bool materials = std::any_of(source_.groups.begin(), source_.groups.end(),
                                           [](const FaceGroup& g) { return !g.material.empty(); });
        const auto name_of = [&](const FaceGroup& group) {
            if (materials) return group.material;
            std::string name;
            for (const std::string& part : group.names)
                name += (name.empty() ? "" : " ") + part;
            return name;
        };
        std::map<std::string, int32_t> numbers;
        std::vector<int32_t> values(source_.groups.size(), -1);
        bool named = false;
        for (int32_t g : source_.face_groups) {
            int32_t& value = values[g];
            if (value >= 0) continue;
            const std::string name = name_of(source_.groups[g]);
            const auto [it, fresh] = numbers.emplace(name, static_cast<int32_t>(numbers.size()));
            value = it->second;
            named = named || !name.empty();
            if (fresh) out_.groups.emplace_back(name.empty() ? "default" : name, value);
        }
        if (named && source_.mesh.find(options_.groups_attribute) == nullptr) {
            add_attribute(values);
        } else {
            out_.groups.clear();
        }
    }

    void add_attribute(const std::vector<int32_t>& values) {
        std::erase_if(source_.mesh.attributes,
                      [&](const MeshAttribute& a) { return a.name == options_.groups_attribute; });
        MeshAttribute a;
        a.name = options_.groups_attribute;
        a.is_int = true;
        a.faces.reserve(source_.face_groups.size());
        for (int32_t g : source_.face_groups)
            a.faces.push_back(values[g]);
        source_.mesh.attributes.push_back(std::move(a));
    }

    MeshSource& source_;
    const MeshOptions& options_;
    LoadedMesh& out_;
};

void to_millimetres(MeshSource* source, const MeshOptions& options, LoadedMesh* out) {
    Mesh& mesh = source->mesh;
    if (options.unit_mm) {
        out->unit_mm = *options.unit_mm;
        out->unit_note = "as asked";
    } else if (source->unit_mm > 0) {
        out->unit_mm = source->unit_mm;
        out->unit_note = "as the file says";
    } else {
        Box3d box;
        for (const auto& t : mesh.triangles) {
            for (int32_t v : t)
                box.add(mesh.positions[v]);
        }
        const Vec3d size = box.empty() ? Vec3d{} : box.size();
        const double largest = std::max({size.x, size.y, size.z});
        // Nobody prints a part below a millimetre, and many programs write metres.
        const bool metres = largest > 0 && largest < 1;
        out->unit_mm = metres ? 1000 : 1;
        out->unit_note = metres ? "guessed from the size" : "assumed, as the file says none";
        if (metres) {
            source->warnings.push_back(fmt::format(
                "{}: mesh `{}` is {:.4g} x {:.4g} x {:.4g} in a unit that the file does not give; "
                "taken as metres. Set `unit` if it is another",
                source->origin.file, mesh.name, size.x, size.y, size.z));
        }
    }
    source->unit_mm = out->unit_mm;
    for (Vec3d& p : mesh.positions)
        p = p * out->unit_mm;
}

/// y up, z to the viewer -> z up, y away; as glTF is read.
void stand_up(Mesh* mesh) {
    for (Vec3d& p : mesh->positions)
        p = {p.x, 0 - p.z, p.y};
    for (MeshAttribute& a : mesh->attributes) {
        if (a.name != "n" || a.components != 3) continue;
        for (size_t i = 0; i + 2 < a.values.size(); i += 3) {
            const float y = a.values[i + 1];
            a.values[i + 1] = 0 - a.values[i + 2];
            a.values[i + 2] = y;
        }
    }
}

void look_for_intersections(MeshSource* source) {
    const Intersections found = find_intersections(source->mesh);
    source->checks.intersections = found.pairs;
    source->checks.all_intersections = found.all;
    if (found.pairs == 0) return;
    source->warnings.push_back(fmt::format(
        "{}: mesh `{}` intersects itself: {}{} pair{} of triangles cross, one at {}; its "
        "volume is printed once, but distances count inner surfaces, too. "
        "Unite its pieces if that matters",
        source->origin.str(found.first), source->mesh.name, found.all ? "" : "at least ",
        found.pairs, found.pairs == 1 ? "" : "s", source->location(found.point)));
}

/// The steps common to all formats. A refusal is an error of prepare_mesh.
Result<LoadedMesh> finish(MeshSource source, const MeshOptions& options, bool tolerant) {
    LoadedMesh out;
    source.mesh.name = options.name;
    out.files = std::move(source.files);
    drop_partial_attributes(&source);
    const MeshCounts counts = counts_of(source);
    out.peak_bytes = preparing_bytes(counts);
    if (out.peak_bytes > options.memory_bytes) {
        return too_large_to_read(source.origin.file, counts.triangles, out.peak_bytes,
                                 options.memory_bytes);
    }
    if (Result<void> numbered = Groups(&source, options, &out).number(); !numbered)
        return numbered.error();
    to_millimetres(&source, options, &out);
    if (options.y_up) stand_up(&source.mesh);
    Result<void> fine = prepare_mesh(&source, options.repair);
    if (!fine) {
        if (!tolerant) return fine.error();
        out.refusal = fine.error().text();
    }
    if (tolerant || source.mesh.triangles.size() <= kMaxChecked) look_for_intersections(&source);
    std::move(source.warnings.begin(), source.warnings.end(), std::back_inserter(out.warnings));
    out.checks = source.checks;
    out.mesh = std::move(source.mesh);
    return out;
}

Error no_format(const fs::path& file) {
    return user_error(fmt::format("{} does not have the extension of a mesh; supported: {}",
                                  file.string(), mesh_formats()));
}

Result<LoadedMesh> load(const fs::path& file, const MeshOptions& options, bool tolerant) {
    const Format* format = find_format(file);
    if (format == nullptr) return no_format(file);
    Result<std::string> bytes = read_text_file(
        file, static_cast<size_t>(std::clamp<int64_t>(options.memory_bytes, 0, kMaxFileBytes)));
    if (!bytes) return bytes.error();
    Result<MeshSource> source = format->read(
        *bytes, file.string(), options.memory_bytes - static_cast<int64_t>(bytes->capacity()));
    if (!source) return source.error();
    bytes = std::string();  // the next steps take as much again
    return finish(std::move(*source), options, tolerant);
}

}  // namespace

bool is_mesh_file(const fs::path& file) {
    return find_format(file) != nullptr;
}

bool format_says_up(const fs::path& file) {
    const Format* format = find_format(file);
    return format != nullptr && format->read == parse_gltf;
}

std::string mesh_formats() {
    std::string text;
    for (const Format& format : kFormats)
        text += fmt::format("{}{}", text.empty() ? "" : ", ", format.extension);
    return text;
}

Result<LoadedMesh> load_mesh(const fs::path& file, const MeshOptions& options) {
    return load(file, options, false);
}

Result<LoadedMesh> parse_mesh(std::string_view bytes, const fs::path& file,
                              const MeshOptions& options) {
    const Format* format = find_format(file);
    if (format == nullptr) return no_format(file);
    Result<MeshSource> source = format->read(bytes, file.string(), options.memory_bytes);
    if (!source) return source.error();
    return finish(std::move(*source), options, false);
}

Result<LoadedMesh> read_mesh(const fs::path& file, const MeshOptions& options) {
    return load(file, options, true);
}

}  // namespace openfab::mesh
