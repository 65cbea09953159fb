// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh file says of the looks of its materials: colours and pictures. Printing reads none of
// it; an import makes a world of it.

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

namespace openfab::tool {

/// Shared by all that have the same: a picture is mostly that of many materials.
using SharedBytes = std::shared_ptr<const std::string>;

struct Picture {
    std::string name;    ///< of its file, without folders
    SharedBytes bytes;   ///< the file's content
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
    std::vector<Look> looks;         ///< each name once
    std::vector<std::string> notes;  ///< what was found and left out
};

/// The place of each look by its name.
std::unordered_map<std::string_view, size_t> places_of(const Looks& looks);

/// Collects the looks of a file, and keeps to what they may take.
class LooksMaker {
  public:
    /// `*memory_left`, which others may take of, goes down by what the looks take.
    explicit LooksMaker(int64_t* memory_left) : memory_left_(*memory_left) {}

    /// A new look, valid until the next one; null where there is one of this name, which counts, or
    /// where it would be too much.
    Look* add(const std::string& name);
    /// A picture's bytes, which `read` gives, at most so many, where `key` was not asked for before.
    Result<SharedBytes> picture(const std::string& key,
                                const std::function<Result<std::string>(int64_t most)>& read);
    void note(std::string text);
    int64_t memory_left() const { return memory_left_; }

    /// An error where they were too much.
    Result<Looks> finish(const std::string& file);

  private:
    /// Whether there is so much left, which is taken.
    bool take(size_t bytes);

    int64_t& memory_left_;
    Looks looks_;
    std::unordered_map<std::string, size_t> places_;
    std::map<std::string, Result<SharedBytes>> pictures_;
};

/// Reads what goes with a mesh file of any format; a file that says nothing has no looks. Files
/// that it names are read below its own folder alone, others are a note. More than `memory_bytes`
/// is an error, of the file and its looks; a picture that is too large for what is left is a note.
Result<Looks> read_looks(const std::filesystem::path& mesh,
                         int64_t memory_bytes = scene::kReadingBytes);

Result<Looks> gltf_looks(std::string_view bytes, const std::string& file,
                         int64_t memory_bytes = scene::kReadingBytes);
Result<Looks> threemf_looks(std::string_view bytes, const std::string& file,
                            int64_t memory_bytes = scene::kReadingBytes);

}  // namespace openfab::tool
