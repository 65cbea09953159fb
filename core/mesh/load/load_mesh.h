// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loads meshes from files of any format, checked and in millimetres. A format's reader (obj.h,
// stl.h, …) returns a MeshSource: the contents of the file, in its own unit. The steps common to
// all formats are here: the unit, the numbers of groups, the checks.

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mesh/model/mesh.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Options of loading.
struct MeshOptions {
    std::string name;               ///< the mesh's name in the world, for messages
    std::optional<double> unit_mm;  ///< length of one unit of the file; without it the file's own,
                                    ///< or guessed from the size
    /// Names of groups and materials to values of an int attribute. Without it they are numbered
    /// from 0 in the order of their first faces: the materials if the file has any, else the
    /// groups.
    std::optional<std::map<std::string, int32_t>> groups;
    std::optional<std::string> groups_attribute;  ///< its name; `face` without it
    std::string body;  ///< the name of one of load_bodies; empty: all parts as one mesh
    /// This place of the file, in millimetres, becomes the origin.
    Vec3d origin_mm;
    /// Of load_bodies: the origin becomes the middle of the parts, and their lowest z, to whole
    /// millimetres; LoadedBodies::origin_mm says where that was.
    bool recentre = false;
    bool y_up = false;    ///< y of the file is up; ignored for glTF, whose format says so
    bool repair = false;  ///< close open meshes (prepare_mesh)
    /// Memory limit of reading, the file's bytes included; more is an error.
    int64_t memory_bytes = kDefaultReadingBytes;
};

/// A mesh that was read, with what was found.
struct LoadedMesh {
    Mesh mesh;
    std::string body;  ///< its name among the file's bodies
    BodyRole role = BodyRole::kPart;
    int32_t assembly = 0;
    int32_t depth = 0;  ///< how many bodies of the file it lies in; of load_bodies only
    std::vector<std::string> warnings;
    std::vector<std::string> of_size;  ///< those of the unit and the size, which a scale may settle
    double unit_mm = 1;
    std::string unit_note;  ///< where the unit comes from: "given", "as the file says", "guessed …"
    std::vector<std::pair<std::string, int32_t>> groups;  ///< name and number, as in the attribute
    /// By number of the attribute: an index in `looks` of the file, -1 where it says nothing. One
    /// entry where the attribute is missing.
    std::vector<int32_t> look_of;
    std::vector<std::filesystem::path> files;  ///< read besides the mesh file
    MeshChecks checks;
    int64_t peak_bytes = 0;         ///< peak memory of reading
    std::vector<LeftOut> left_out;  ///< of the file; of load_mesh and read_mesh
    /// Why the mesh cannot be printed, else empty; set by read_mesh and read_bodies only.
    std::string refusal;
};

/// The bodies of a file, with what the file says beside them.
struct LoadedBodies {
    std::vector<LoadedMesh> bodies;  ///< parts and negative ones, in the order of the file
    std::vector<Look> looks;
    /// Pairs of bodies that share volume, and neither lies in the other.
    std::vector<std::pair<int32_t, int32_t>> overlaps;
    double unit_mm = 1;
    std::string unit_note;
    Vec3d origin_mm;  ///< as in the options, or found
    std::vector<LeftOut> left_out;
    std::vector<std::string> warnings;  ///< of the file; those of a body are with it
    std::vector<std::string> of_size;   ///< as of a mesh
    std::vector<std::filesystem::path> files;
};

/// Returns whether load_mesh reads files of this extension, in upper or lower case.
bool is_mesh_file(const std::filesystem::path& file);

/// Returns whether the format defines which axis is up; its reader then turns the mesh.
bool format_says_up(const std::filesystem::path& file);

/// Returns ".obj, .stl, …", for messages.
std::string mesh_formats();

/// Returns what a file is by its extension, and what to save it as, if it is a mesh of a format that
/// is not read: "VRML, which is not read; save it as …". Empty: it is none that is known.
std::string other_mesh_format(const std::filesystem::path& file);

/// Reads a mesh by its extension and prepares it for printing (prepare_mesh). If neither options
/// nor file give the unit, a size under 1 unit is taken as metres, with a warning. Crossing
/// triangles are a warning, searched for in meshes of up to 200,000 triangles. Errors name the
/// file, and the line in text formats.
Result<LoadedMesh> load_mesh(const std::filesystem::path& file, const MeshOptions& options);

/// Reads several meshes of one file, which is read once; a result for each of `options`. Memory
/// counts for all of them together: the least of their limits.
std::vector<Result<LoadedMesh>> load_meshes(const std::filesystem::path& file,
                                            std::span<const MeshOptions> options);

/// Reads all bodies of a file, each prepared as by load_mesh. `options.body` and `groups` are not
/// looked at; `name` is that of the file in messages.
Result<LoadedBodies> load_bodies(const std::filesystem::path& file, const MeshOptions& options);

/// Same for inspection, as read_mesh.
Result<LoadedBodies> read_bodies(const std::filesystem::path& file, const MeshOptions& options);

/// As load_mesh, from bytes; `file` gives the format and the folder of referenced files.
Result<LoadedMesh> parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                              const MeshOptions& options);

/// Reads a mesh for inspection: like load_mesh, but a mesh that cannot be printed gets a `refusal`
/// instead of an error, and crossing triangles are searched for in meshes of any size.
Result<LoadedMesh> read_mesh(const std::filesystem::path& file, const MeshOptions& options);

}  // namespace openfab::mesh
