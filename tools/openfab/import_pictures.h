// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pictures of the world that an import makes: each once, whatever uses it.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "mesh/model/look.h"
#include "tools/fields/fablet_text.h"
#include "tools/openfab/import_text.h"

namespace openfab::tools {

/// Shared by all that uses them.
using SharedBytes = std::shared_ptr<const std::string>;

/// The bytes of a file's pictures, by PictureUse::source, or why there are none.
using Pictures = std::map<std::string, Result<SharedBytes>>;

/// A file to be written into the folder.
struct ImportedFile {
    std::string name;
    SharedBytes bytes;
};

/// Takes the pictures that cannot be read out of the looks; returns a note for each.
std::vector<std::string> leave_out_unreadable(const Pictures& pictures,
                                              std::vector<mesh::Look>* looks);

class ImportPictures {
  public:
    explicit ImportPictures(const Pictures& pictures) : pictures_(pictures) {}

    /// Adds a picture of the file; returns the name of its texture. Empty, and a note once, where
    /// it cannot be read. `luminance`: it is a map of heights.
    std::string add(const mesh::PictureUse& use, bool luminance, std::vector<std::string>* notes);
    /// Adds a picture of these bytes.
    std::string add(const std::string& name, const SharedBytes& bytes,
                    const std::array<mesh::PictureWrap, 2>& wrap, bool luminance);
    /// Adds another texture; returns its name.
    std::string add_file(const std::string& name, const std::string& extension, SharedBytes bytes);

    /// Adds the sheets of a 3MF image as a volume whose lowest corner is 0 and whose highest is 1; returns its
    /// texture. An error where a sheet cannot be read.
    Result<std::string> add_volume(const FieldImage& image);

    /// Adds a picture of heights, whose numbers are taken as they are.
    Result<std::string> add_map(const FieldMap& map);

    const std::vector<std::string>& lines() const { return lines_; }
    std::vector<ImportedFile>& files() { return files_; }

  private:
    /// How a picture is read.
    struct Way {
        std::array<mesh::PictureWrap, 2> wrap{};
        bool opaque = false, nearest = false;
        mesh::PictureUse::Space space = mesh::PictureUse::Space::kOwn;
        auto operator<=>(const Way&) const = default;
    };

    std::string add_as(const std::string& name, const SharedBytes& bytes, const Way& way,
                       bool luminance);

    const Pictures& pictures_;
    std::vector<std::string> lines_;
    std::vector<ImportedFile> files_;
    Names names_;
    std::map<std::pair<const std::string*, Way>, std::string> shared_;
    /// File names by contents, and textures by those and the way.
    std::unordered_map<std::string_view, std::string> by_content_;
    std::map<std::pair<std::string, Way>, std::string> by_file_;
    std::map<std::string, bool> told_;
    /// Folders of volumes by their sheets, and textures by folder and way.
    std::map<std::vector<std::string>, std::string> stacks_;
    std::map<std::tuple<std::string, bool, bool>, std::string> volumes_;
};

}  // namespace openfab::tools
