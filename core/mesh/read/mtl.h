// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Material libraries (.mtl) of OBJ files: how the faces of a material look. Gloss, reflection and
// refraction come with a voxel's material and are not read.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mesh/model/look.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// A material of a library.
struct MtlMaterial {
    Look look;  ///< the picture's source is its name relative to the mesh's folder
    /// The picture is at uv * scale + offset.
    std::array<double, 2> scale{1, 1}, offset{0, 0};
    std::vector<LeftOut> left_out;

    bool moves_picture() const {
        return look.picture && (scale != std::array{1.0, 1.0} || offset != std::array{0.0, 0.0});
    }
};

/// Returns text without a comment at its end. A sign `#` begins one where blanks are around it, since
/// names such as `Material #1` are common.
std::string_view without_comment(std::string_view text);
/// Returns text up to the last word that begins with `#`, without blanks; empty if there is none.
std::string_view before_last_mark(std::string_view text);
/// Returns text without blanks around it.
std::string_view without_blanks(std::string_view text);

/// The libraries that one mesh names.
class MtlLibraries {
  public:
    /// Takes at most `memory_bytes`. `out` gets the files, and what is missing.
    MtlLibraries(const std::filesystem::path& mesh, int64_t memory_bytes, MeshSource* out)
        : mesh_(mesh), memory_bytes_(memory_bytes), out_(*out) {}

    /// Reads what the rest of a `mtllib` statement names: a library, or several. The error says that
    /// they take too much memory.
    Result<void> add(std::string_view names, const std::string& place);

    /// Returns the material that a `usemtl` statement names; null if no library has it.
    const MtlMaterial* find(std::string_view name) const;
    const std::vector<MtlMaterial>& materials() const { return materials_; }
    /// Whether each library that was named was read, and there is one.
    bool complete() const { return !read_.empty() && missing_.empty(); }
    int64_t bytes() const { return bytes_; }

  private:
    Result<void> read(const std::filesystem::path& library);

    std::filesystem::path mesh_;
    int64_t memory_bytes_;
    MeshSource& out_;
    int64_t bytes_ = 0;
    std::set<std::string> known_;  ///< statements that were read
    std::set<std::filesystem::path> read_;
    std::set<std::string> missing_;
    std::vector<MtlMaterial> materials_;
    /// Indices by name, and by what stands before a sign `#` in it.
    std::map<std::string, size_t, std::less<>> by_name_, by_start_;
};

}  // namespace openfab::mesh
