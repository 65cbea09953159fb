// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh file says of the looks of its materials: colours and pictures. Printing reads none of
// it; an import makes a world of it.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::tool {

struct Picture {
    std::string name;    ///< of its file, without folders
    std::string bytes;   ///< the file's content
    bool clamp = false;  ///< beyond 0 … 1: the border, not again
};

/// One material of a file.
struct Look {
    std::string name;                            ///< as in scene::LoadedMesh::groups
    std::optional<std::array<double, 3>> color;  ///< linear light, 0 … 1
    std::optional<Picture> picture;
    /// Whether the colour multiplies the picture; else it stands in for it.
    bool tinted = false;
};

struct Looks {
    std::vector<Look> looks;
    std::vector<std::string> notes;  ///< what was found and left out

    const Look* find(std::string_view name) const;
};

/// Reads what goes with a mesh file of any format; a file that says nothing has no looks. Files
/// that it names are read below its own folder alone, others are a note.
Result<Looks> read_looks(const std::filesystem::path& mesh);

/// Of a material library (.mtl): newmtl, Kd, map_Kd with its options. Lines of other things count
/// for nothing.
void parse_mtl(std::string_view text, const std::filesystem::path& file, Looks* out);
Result<Looks> gltf_looks(std::string_view bytes, const std::string& file);
Result<Looks> threemf_looks(std::string_view bytes, const std::string& file);

}  // namespace openfab::tool
