// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loads meshes from files of any format, checked and in millimetres. A format's reader (obj.h,
// stl.h, …) returns a MeshSource: the contents of the file, in its own unit. The steps common to
// all formats are here: the unit, the numbers of groups, the checks.

#include <filesystem>
#include <map>
#include <optional>
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
    std::string groups_attribute = "face";
    bool y_up = false;    ///< y of the file is up; ignored for glTF, whose format says so
    bool repair = false;  ///< close open meshes (prepare_mesh)
    /// Memory limit of reading, the file's bytes included; more is an error.
    int64_t memory_bytes = kDefaultReadingBytes;
};

/// A mesh that was read, with what was found.
struct LoadedMesh {
    Mesh mesh;
    std::vector<std::string> warnings;
    double unit_mm = 1;
    std::string unit_note;  ///< where the unit comes from: "given", "as the file says", "guessed …"
    std::vector<std::pair<std::string, int32_t>> groups;  ///< name and number, as in the attribute
    std::vector<std::filesystem::path> files;             ///< read besides the mesh file
    MeshChecks checks;
    int64_t peak_bytes = 0;  ///< peak memory of reading
    /// Why the mesh cannot be printed, else empty; set by read_mesh only.
    std::string refusal;
};

/// Returns whether load_mesh reads files of this extension, in upper or lower case.
bool is_mesh_file(const std::filesystem::path& file);

/// Returns whether the format defines which axis is up; its reader then turns the mesh.
bool format_says_up(const std::filesystem::path& file);

/// Returns ".obj, .stl, …", for messages.
std::string mesh_formats();

/// Reads a mesh by its extension and prepares it for printing (prepare_mesh). If neither options
/// nor file give the unit, a size under 1 unit is taken as metres, with a warning. Crossing
/// triangles are a warning, searched for in meshes of up to 200,000 triangles. Errors name the
/// file, and the line in text formats.
Result<LoadedMesh> load_mesh(const std::filesystem::path& file, const MeshOptions& options);

/// Same, from bytes; `file` gives the format and the folder of referenced files.
Result<LoadedMesh> parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                              const MeshOptions& options);

/// Reads a mesh for inspection: like load_mesh, but a mesh that cannot be printed gets a `refusal`
/// instead of an error, and crossing triangles are searched for in meshes of any size.
Result<LoadedMesh> read_mesh(const std::filesystem::path& file, const MeshOptions& options);

}  // namespace openfab::mesh
