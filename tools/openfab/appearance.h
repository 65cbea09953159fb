// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the appearance of materials from mesh files: colours and pictures. Only `openfab import`
// uses it, to make a world.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "mesh/model/mesh.h"

namespace openfab::tools {

/// Shared by all materials with the same picture.
using SharedBytes = std::shared_ptr<const std::string>;

struct Picture {
    std::string name;    ///< of its file, without folders
    SharedBytes bytes;   ///< the file's content
    bool clamp = false;  ///< beyond 0 … 1 the border is repeated, not the picture
};

/// The appearance of one material of a file.
struct MaterialAppearance {
    std::string name;                            ///< same as in mesh::LoadedMesh::groups
    std::optional<std::array<double, 3>> color;  ///< linear light, 0 … 1
    std::optional<Picture> picture;
    /// The colour multiplies the picture; otherwise it is only a fallback.
    bool tinted = false;
};

struct Appearances {
    std::vector<MaterialAppearance> appearances;  ///< each name once
    std::vector<std::string> notes;               ///< features that were ignored
};

/// The index of each appearance by its name.
std::unordered_map<std::string_view, size_t> indices_of(const Appearances& appearances);

/// Collects the appearances of a file within a memory limit.
class LooksMaker {
  public:
    /// Decreases `*memory_left`, which others may share, by what the appearances take.
    explicit LooksMaker(int64_t* memory_left) : memory_left_(*memory_left) {}

    /// Adds an appearance, valid until the next call; null if one of this name exists, which takes
    /// precedence, or if memory is exceeded.
    MaterialAppearance* add(const std::string& name);
    /// Returns a picture's bytes: those of an earlier call with this key, else those of `read`,
    /// which gets the limit.
    Result<SharedBytes> picture(const std::string& key,
                                const std::function<Result<std::string>(int64_t most)>& read);
    void note(std::string text);
    int64_t memory_left() const { return memory_left_; }

    /// Returns an error if memory was exceeded.
    Result<Appearances> finish(const std::string& file);

  private:
    /// Takes memory if that much is left; returns whether it was.
    bool take(size_t bytes);

    int64_t& memory_left_;
    Appearances appearances_;
    std::unordered_map<std::string, size_t> index_by_name_;
    std::map<std::string, Result<SharedBytes>> pictures_;
};

/// Reads the appearance of a mesh file of any format; empty where it has none. Files that it names
/// are read below its own folder only; a note reports others. More than `memory_bytes` is an error,
/// for the file and its appearances; a picture that is too large for the rest is a note.
Result<Appearances> read_appearances(const std::filesystem::path& mesh,
                                     int64_t memory_bytes = mesh::kDefaultReadingBytes);

Result<Appearances> gltf_appearances(std::string_view bytes, const std::string& file,
                                     int64_t memory_bytes = mesh::kDefaultReadingBytes);
Result<Appearances> threemf_appearances(std::string_view bytes, const std::string& file,
                                        int64_t memory_bytes = mesh::kDefaultReadingBytes);

}  // namespace openfab::tools
