// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/load_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/json.h"
#include "base/near_miss.h"
#include "base/text.h"
#include "mesh/check/mesh_check.h"
#include "mesh/check/nesting.h"
#include "mesh/load/bodies.h"
#include "mesh/load/face_numbers.h"
#include "mesh/load/finish_mesh.h"
#include "mesh/load/jailed.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/messages.h"
#include "mesh/read/amf.h"
#include "mesh/read/gltf.h"
#include "mesh/read/obj.h"
#include "mesh/read/off.h"
#include "mesh/read/ply.h"
#include "mesh/read/stl.h"
#include "mesh/read/threemf.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxFileBytes = 2'000'000'000;

using Reader = Result<MeshSource> (*)(std::string_view bytes, const std::string& file,
                                      int64_t memory_bytes);

struct Format {
    const char* extension;
    Reader read;
};

constexpr Format kFormats[] = {{".obj", parse_obj},   {".stl", parse_stl},  {".ply", parse_ply},
                               {".gltf", parse_gltf}, {".glb", parse_gltf}, {".3mf", parse_threemf},
                               {".amf", parse_amf},   {".off", parse_off},  {".coff", parse_off}};

const Format* find_format(const fs::path& file) {
    const std::string extension = lower_ascii(file.extension().string());
    for (const Format& format : kFormats) {
        if (extension == format.extension) return &format;
    }
    return nullptr;
}

/// Formats of meshes that are not read, and what keeps their colours.
struct OtherFormat {
    std::string_view extension;
    const char* name;
    const char* remedy;
};

constexpr OtherFormat kOtherFormats[] = {
    {".wrl", "VRML", messages::kImportVrml},
    {".vrml", "VRML", messages::kImportVrml},
    {".x3d", "X3D", messages::kSaveWithMeshLab},
    {".3ds", "3DS", messages::kSaveWithMeshLab},
    {".fbx", "FBX", messages::kSaveWithBlender},
    {".dae", "COLLADA", messages::kSaveDae},
    {".usd", "USD", messages::kImportUsd},
    {".usda", "USD", messages::kImportUsd},
    {".usdc", "USD", messages::kImportUsd},
    {".usdz", "USD", messages::kImportUsd},
    {".blend", "a scene of Blender", messages::kSaveWithBlender},
    {".3dm", "a model of Rhino", messages::kSaveAs3mf},
    {".skp", "a model of SketchUp", messages::kSaveAsObj},
    {".iges", "IGES", messages::kSaveAsStep},
    {".igs", "IGES", messages::kSaveAsStep},
    {".f3d", "a model of Fusion", messages::kSaveAs3mf},
    {".sldprt", "a part of SolidWorks", messages::kSaveAs3mf}};

Error no_format(const fs::path& file) {
    if (const std::string other = other_mesh_format(file); !other.empty())
        return user_error(fmt::format("{} is {}", file.string(), other));
    return user_error(fmt::format(messages::kNoMeshExtension, file.string(), mesh_formats()));
}

/// A file that was read, with its bodies.
struct ReadFile {
    MeshSource source;
    FoundBodies found;
    Unit unit;
};

Result<MeshSource> read_source(std::string_view bytes, const fs::path& file, int64_t memory_bytes) {
    const Format* format = find_format(file);
    if (format == nullptr) return no_format(file);
    Result<MeshSource> read = format->read(bytes, file.string(), memory_bytes);
    if (read) join_corners(&*read, memory_bytes);
    return read;
}

ReadFile with_unit(MeshSource source, const MeshOptions& options) {
    ReadFile out{std::move(source), {}, {}};
    part_bare_faces(&out.source);
    out.unit = unit_of(&out.source, options);
    return out;
}

/// Finds the bodies, once the bytes of the file are freed.
Result<void> find_bodies_of(ReadFile* file, int64_t memory_bytes) {
    const MeshCounts counts = counts_of(file->source);
    const int64_t needed = preparing_bytes(counts);
    if (needed > memory_bytes) {
        return too_large_to_read(file->source.origin.file, counts.triangles, needed, memory_bytes);
    }
    file->found = find_bodies(file->source);
    return {};
}

Result<ReadFile> read_file(const fs::path& file, const MeshOptions& options, int64_t memory_bytes) {
    if (find_format(file) == nullptr) return no_format(file);
    // The bytes of the file are in the jail alone: the next steps take as much again.
    Result<MeshSource> source = mesh_from_jail(file, memory_bytes, [&]() -> Result<MeshSource> {
        const Result<std::string> bytes = read_text_file(
            file, static_cast<size_t>(std::clamp<int64_t>(memory_bytes, 0, kMaxFileBytes)));
        if (!bytes) return bytes.error();
        return read_source(*bytes, file, memory_bytes - static_cast<int64_t>(bytes->capacity()));
    });
    if (!source) return source.error();
    ReadFile out = with_unit(std::move(*source), options);
    if (Result<void> found = find_bodies_of(&out, memory_bytes); !found) return found.error();
    return out;
}

/// All parts of a file as one mesh.
Result<LoadedMesh> finish_whole(ReadFile file, const MeshOptions& options, bool tolerant) {
    MeshSource& source = file.source;
    std::vector<LeftOut> left_out = std::move(source.left_out);
    const std::vector<Look> looks = std::move(source.looks);
    const bool one = file.found.bodies.size() == 1;
    if (!one) keep_parts(file.found, &source);
    if (one && file.found.bodies[0].joined) source.part_of_vertex.clear();
    Result<LoadedMesh> mesh = finish_mesh(std::move(source), looks, file.unit, options, tolerant);
    if (!mesh) return mesh;
    mesh->left_out = std::move(left_out);
    if (one) mesh->body = file.found.bodies[0].name;
    return mesh;
}

/// Splitting has the file's mesh and its bodies at one time.
Result<void> check_splitting(const ReadFile& file, int64_t memory_bytes) {
    const MeshCounts counts = counts_of(file.source);
    const int64_t needed = mesh_bytes(counts) + preparing_bytes(counts);
    if (needed <= memory_bytes) return {};
    return too_large_to_read(file.source.origin.file, counts.triangles, needed, memory_bytes);
}

Error no_body(const ReadFile& file, const MeshOptions& options) {
    std::vector<std::string> names;
    for (const FoundBody& body : file.found.bodies)
        names.push_back(body.name);
    return user_error(
        fmt::format(messages::kNoBodyOfMesh, file.source.origin.file, options.body, options.name),
        suggest(options.body, names));
}

/// The index of the body that is asked for; -1: there is none.
int32_t index_of(const FoundBodies& found, const std::string& body) {
    const auto it = std::find_if(found.bodies.begin(), found.bodies.end(),
                                 [&](const FoundBody& b) { return b.name == body; });
    return it == found.bodies.end() ? -1 : static_cast<int32_t>(it - found.bodies.begin());
}

/// Takes the bodies that are asked for, each for itself, out of a file of several.
std::vector<Result<LoadedMesh>> finish_some(ReadFile file, std::span<const MeshOptions> options,
                                            int64_t memory_bytes) {
    std::vector<Result<LoadedMesh>> out(options.size(), Result<LoadedMesh>(LoadedMesh{}));
    if (Result<void> fits = check_splitting(file, memory_bytes); !fits) {
        out[0] = fits.error();
        return out;
    }
    std::vector<int32_t> bodies;
    for (const MeshOptions& o : options)
        bodies.push_back(index_of(file.found, o.body));
    std::vector<int32_t> wanted = bodies;
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    if (!wanted.empty() && wanted[0] < 0) wanted.erase(wanted.begin());
    std::vector<MeshSource> sources = split_bodies(file.source, file.found, wanted);
    // The last one that wants a body gets it, those before a copy.
    std::vector<size_t> last(wanted.size());
    const auto place = [&](size_t i) {
        return static_cast<size_t>(std::lower_bound(wanted.begin(), wanted.end(), bodies[i]) -
                                   wanted.begin());
    };
    for (size_t i = 0; i < bodies.size(); ++i) {
        if (bodies[i] >= 0) last[place(i)] = i;
    }
    std::vector<std::optional<MeshSource>> own(options.size());
    for (size_t i = 0; i < bodies.size(); ++i) {
        if (bodies[i] < 0) {
            out[i] = no_body(file, options[i]);
        } else if (last[place(i)] == i) {
            own[i] = std::move(sources[place(i)]);
        } else {
            own[i] = sources[place(i)];
        }
    }
    const std::vector<Look> looks = std::move(file.source.looks);
    if (own[0]) {
        own[0]->files = std::move(file.source.files);
        own[0]->warnings = std::move(file.source.warnings);
        own[0]->of_size = std::move(file.source.of_size);
    }
    file.source = {};
    tbb::parallel_for(size_t{0}, own.size(), [&](size_t i) {
        if (!own[i]) return;
        out[i] = finish_mesh(std::move(*own[i]), looks, file.unit, options[i], false);
        if (out[i]) out[i]->body = options[i].body;
    });
    return out;
}

/// Finds which bodies lie in which others, and which share volume.
void find_depths(const ReadFile& file, LoadedBodies* out) {
    const auto count = static_cast<int32_t>(file.found.bodies.size());
    std::vector<int32_t> pieces(file.source.mesh.triangles.size());
    for (size_t t = 0; t < pieces.size(); ++t) {
        const int32_t body = file.found.of_triangle(file.source, t);
        pieces[t] = file.found.bodies[body].role == BodyRole::kPart ? body : -1;
    }
    const std::optional<Nesting> nesting = find_nesting(file.source.mesh, pieces, count);
    if (!nesting) {
        out->warnings.push_back(fmt::format(messages::kTooManyBodies, file.source.origin.file));
        return;
    }
    for (size_t b = 0; b < out->bodies.size(); ++b)
        out->bodies[b].depth = static_cast<int32_t>(nesting->inside[b].size());
    out->overlaps = nesting->overlaps;
}

/// The middle of a file's parts in x and y, and their lowest z, to whole millimetres.
Vec3d middle_of(const ReadFile& file, bool y_up) {
    Box3d box;
    for (size_t t = 0; t < file.source.mesh.triangles.size(); ++t) {
        const int32_t body = file.found.of_triangle(file.source, t);
        if (file.found.bodies[body].role != BodyRole::kPart) continue;
        for (const int32_t v : file.source.mesh.triangles[t]) {
            const Vec3d p = file.source.mesh.positions[v] * file.unit.mm;
            box.add(y_up ? Vec3d{p.x, 0 - p.z, p.y} : p);
        }
    }
    if (box.empty()) return {};
    const Vec3d middle = box.center();
    return {std::round(middle.x), std::round(middle.y), std::floor(box.lo.z)};
}

/// Leaves out what is not printed; the overlaps keep to those that stay.
void keep_printed(const ReadFile& file, LoadedBodies* out) {
    const std::vector<FoundBody>& found = file.found.bodies;
    std::vector<int32_t> place(found.size(), -1);
    size_t kept = 0;
    const bool any_solid = std::any_of(found.begin(), found.end(), [](const FoundBody& body) {
        return body.role == BodyRole::kPart && !body.flat;
    });
    for (size_t b = 0; b < found.size(); ++b) {
        if (found[b].role == BodyRole::kNotPrinted) {
            out->left_out.push_back({fmt::format(messages::kBodyNotPrinted, found[b].name),
                                     {},
                                     messages::kBodyNotPrintedHelp,
                                     1});
        } else if (found[b].flat && any_solid) {
            out->left_out.push_back({fmt::format(messages::kBodyWithoutVolume, found[b].name),
                                     {},
                                     messages::kBodyWithoutVolumeHelp,
                                     1});
        } else {
            place[b] = static_cast<int32_t>(kept);
            if (kept != b) out->bodies[kept] = std::move(out->bodies[b]);
            ++kept;
        }
    }
    out->bodies.resize(kept);
    std::erase_if(out->overlaps, [&](std::pair<int32_t, int32_t>& pair) {
        pair = {place[pair.first], place[pair.second]};
        return pair.first < 0 || pair.second < 0;
    });
}

Result<LoadedBodies> all_bodies(ReadFile file, const MeshOptions& options, bool tolerant) {
    LoadedBodies out;
    out.left_out = std::move(file.source.left_out);
    out.warnings = std::move(file.source.warnings);
    out.of_size = std::move(file.source.of_size);
    out.files = std::move(file.source.files);
    out.looks = std::move(file.source.looks);
    out.unit_mm = file.unit.mm;
    out.unit_note = file.unit.note;
    const std::vector<FoundBody>& found = file.found.bodies;
    out.bodies.resize(found.size());
    out.origin_mm = options.recentre ? middle_of(file, options.y_up) : options.origin_mm;
    std::vector<MeshSource> sources;
    if (found.size() == 1) {
        if (found[0].joined) file.source.part_of_vertex.clear();
        sources.push_back(std::move(file.source));
    } else {
        if (Result<void> fits = check_splitting(file, options.memory_bytes); !fits)
            return fits.error();
        find_depths(file, &out);
        std::vector<int32_t> all(found.size());
        std::iota(all.begin(), all.end(), 0);
        sources = split_bodies(file.source, file.found, all);
        file.source.mesh = {};
    }
    std::vector<Result<LoadedMesh>> meshes(found.size(), Result<LoadedMesh>(LoadedMesh{}));
    const bool alone = found.size() == 1;
    tbb::parallel_for(size_t{0}, found.size(), [&](size_t b) {
        if (!alone && (found[b].role == BodyRole::kNotPrinted || found[b].flat)) return;
        MeshOptions own = options;
        if (!alone) own.name = found[b].name;
        own.origin_mm = out.origin_mm;
        meshes[b] = finish_mesh(std::move(sources[b]), out.looks, file.unit, own, tolerant);
    });
    for (size_t b = 0; b < found.size(); ++b) {
        if (!meshes[b]) return meshes[b].error();
        const int32_t depth = out.bodies[b].depth;
        out.bodies[b] = std::move(*meshes[b]);
        out.bodies[b].depth = depth;
        out.bodies[b].body = found[b].name;
        out.bodies[b].role = found[b].role;
        out.bodies[b].assembly = found[b].assembly;
    }
    if (!alone) keep_printed(file, &out);
    return out;
}

}  // namespace

bool is_mesh_file(const fs::path& file) {
    return find_format(file) != nullptr;
}

bool format_says_up(const fs::path& file) {
    const Format* format = find_format(file);
    return format != nullptr && format->read == parse_gltf;
}

std::string other_mesh_format(const fs::path& file) {
    const std::string extension = lower_ascii(file.extension().string());
    for (const OtherFormat& format : kOtherFormats) {
        if (extension == format.extension)
            return fmt::format(messages::kOtherFormat, format.name, format.remedy);
    }
    return {};
}

std::string mesh_formats() {
    std::string text;
    for (const Format& format : kFormats)
        text += fmt::format("{}{}", text.empty() ? "" : ", ", format.extension);
    return text;
}

std::vector<Result<LoadedMesh>> load_meshes(const fs::path& file,
                                            std::span<const MeshOptions> options) {
    int64_t memory_bytes = options[0].memory_bytes;
    for (const MeshOptions& o : options)
        memory_bytes = std::min(memory_bytes, o.memory_bytes);
    Result<ReadFile> read = read_file(file, options[0], memory_bytes);
    std::vector<Result<LoadedMesh>> out(options.size(), Result<LoadedMesh>(LoadedMesh{}));
    if (!read) {
        out[0] = read.error();
        return out;
    }
    if (read->found.bodies.size() > 1 && !options[0].body.empty())
        return finish_some(std::move(*read), options, memory_bytes);
    for (size_t i = 0; i < options.size(); ++i) {
        const bool known = options[i].body.empty() || options[i].body == read->found.bodies[0].name;
        out[i] = !known                   ? Result<LoadedMesh>(no_body(*read, options[i]))
                 : i + 1 < options.size() ? finish_whole(*read, options[i], false)
                                          : finish_whole(std::move(*read), options[i], false);
    }
    return out;
}

Result<LoadedMesh> load_mesh(const fs::path& file, const MeshOptions& options) {
    return std::move(load_meshes(file, {&options, 1})[0]);
}

Result<LoadedMesh> parse_mesh(std::string_view bytes, const fs::path& file,
                              const MeshOptions& options) {
    Result<MeshSource> source = read_source(bytes, file, options.memory_bytes);
    if (!source) return source.error();
    ReadFile read = with_unit(std::move(*source), options);
    if (Result<void> found = find_bodies_of(&read, options.memory_bytes); !found)
        return found.error();
    return finish_whole(std::move(read), options, false);
}

Result<LoadedMesh> read_mesh(const fs::path& file, const MeshOptions& options) {
    Result<ReadFile> read = read_file(file, options, options.memory_bytes);
    if (!read) return read.error();
    return finish_whole(std::move(*read), options, true);
}

Result<LoadedBodies> load_bodies(const fs::path& file, const MeshOptions& options) {
    Result<ReadFile> read = read_file(file, options, options.memory_bytes);
    if (!read) return read.error();
    return all_bodies(std::move(*read), options, false);
}

Result<LoadedBodies> read_bodies(const fs::path& file, const MeshOptions& options) {
    Result<ReadFile> read = read_file(file, options, options.memory_bytes);
    if (!read) return read.error();
    return all_bodies(std::move(*read), options, true);
}

}  // namespace openfab::mesh
