// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes from files of any format, checked and in millimetres. A format's reader (obj.h, stl.h, …)
// gives a MeshSource: what the file says, in its own unit. What all formats have in common follows
// here: the unit, the numbers of groups, the checks.

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

namespace openfab::scene {

struct MeshOptions {
    std::string name;               ///< the mesh's name in the world, for messages
    std::optional<double> unit_mm;  ///< length of one unit of the file; without it the file's own,
                                    ///< or guessed from the size
    /// Names of groups and materials to values of an int attribute. Without it they are numbered
    /// from 0 in the order of their first faces: the materials if the file has any, else the
    /// groups.
    std::optional<std::map<std::string, int32_t>> groups;
    std::string groups_attribute = "face";
    bool y_up = false;    ///< y of the file is up; glTF has that by its format and takes no word
    bool repair = false;  ///< close what is open, as prepare_mesh says
    /// What reading may take, the file's bytes included; more is an error.
    int64_t memory_bytes = kReadingBytes;
};

struct LoadedMesh {
    Mesh mesh;
    std::vector<std::string> warnings;
    double unit_mm = 1;
    std::string unit_note;  ///< where the unit comes from: "given", "as the file says", "guessed …"
    std::vector<std::pair<std::string, int32_t>> groups;  ///< name and number, as in the attribute
    std::vector<std::filesystem::path> files;             ///< read besides the mesh file
    MeshChecks checks;
    int64_t peak_bytes = 0;  ///< what it took to read
    /// Why the mesh cannot be printed; only read_mesh gives one that has any.
    std::string refusal;
};

/// Whether load_mesh reads files of this extension, in any case.
bool is_mesh_file(const std::filesystem::path& file);

/// Whether a format says which axis is up; its reader has turned the mesh then.
bool format_says_up(const std::filesystem::path& file);

/// ".obj, .stl, …", for messages.
std::string mesh_formats();

/// Reads a mesh by its extension; prepare_mesh has made it fit to print. A size under 1 unit where
/// neither options nor file say the unit is taken as metres, with a warning. Triangles that cross
/// are a warning, looked for in meshes of up to 200,000. Errors name the file, and the line where
/// it has lines.
Result<LoadedMesh> load_mesh(const std::filesystem::path& file, const MeshOptions& options);

/// The same from bytes; `file` gives the format and the folder of files beside it.
Result<LoadedMesh> parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                              const MeshOptions& options);

/// As load_mesh, for telling about a mesh: one that reads well but cannot be printed has a
/// `refusal`, and triangles that cross are looked for in meshes of any size.
Result<LoadedMesh> read_mesh(const std::filesystem::path& file, const MeshOptions& options);

}  // namespace openfab::scene
