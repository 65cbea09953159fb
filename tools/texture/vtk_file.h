// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// VTK's XML files (.vti, .vtr, .vts, .vtu), https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html,
// and its older ones (.vtk): which arrays there are, and the numbers in them, whether as text, base64 or raw
// bytes, packed by zlib or not. Read without VTK, whose package takes half a gigabyte with what it needs: of its format these
// files are a small part, and untrusted ones must not reach the rest.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/cache.h"
#include "tools/texture/array_numbers.h"
#include "tools/texture/vtk_image.h"

namespace openfab::tools {

/// What an older file begins with.
constexpr std::string_view kLegacyVtk = "# vtk DataFile";

class VtkFile : public VtkImage {
  public:
    enum class Where { kPoints, kCells, kPlaces, kTopology, kAxes };
    enum class Coding { kText, kBase64, kAppended, kFileText, kBytes };
    struct Array {
        Where where = Where::kPoints;
        std::string name;
        ArrayType type = ArrayType::kFloat32;
        int64_t components = 1;
        Coding coding = Coding::kText;
        int64_t offset = 0;  ///< in the appended data; of an older file, in the file
        std::string text;    ///< what stands in the file, where it is not appended
        // Of older files alone:
        int64_t bytes = 0, total = 0;  ///< in the file, and numbers that they are
        int64_t skip = 0;              ///< of these numbers, before the first that counts
        double times = 1;              ///< of the numbers in the file
        bool interleaved = false;      ///< each cell's number of corners before its corners
    };

    /// Reads the file up to its appended data, or an older one to its end, passing over the numbers.
    /// Errors do not name the file.
    static Result<std::unique_ptr<VtkFile>> open(const std::filesystem::path& file,
                                                 const texture::ReadLimits& limits);

    /// ImageData, RectilinearGrid, StructuredGrid or UnstructuredGrid.
    const std::string& kind() const { return kind_; }

    /// Returns the field of this name, of points before cells; without a name the one that the file
    /// calls its scalars, or the only one. Fails with the names that there are.
    Result<const Array*> field(const std::string& name) const;
    /// Returns the array of the mesh itself; fails where there is none.
    Result<const Array*> part(Where where, const std::string& name) const;
    /// Returns the places along x, y and z of a rectilinear grid; fails where there are not three.
    Result<std::array<const Array*, 3>> axes() const;

    /// Opens an array that holds `count` numbers. Fails where the file cannot hold as many. Must not
    /// outlive the file.
    Result<std::unique_ptr<ArrayNumbers>> numbers(const Array& array, int64_t count) const;

    int64_t points = 0, cells = 0;  ///< of an UnstructuredGrid

  private:
    class Reading;
    class Legacy;
    VtkFile(InputFile file, std::string name, int64_t memory_bytes)
        : file_(std::move(file)), name_(std::move(name)), memory_bytes_(memory_bytes) {}
    Result<void> read_xml(const texture::ReadLimits& limits);
    Result<void> read_legacy();
    Result<std::unique_ptr<ArrayNumbers>> legacy_numbers(const Array& array, int64_t count) const;

    InputFile file_;
    std::string name_;  ///< for people
    int64_t memory_bytes_;
    std::string kind_;
    bool swapped_ = false, packed_ = false, appended_base64_ = false;
    std::string unknown_packer_;  ///< empty, or what packed arrays that are not text
    int64_t header_bytes_ = 4;    ///< of a number before the bytes of an array
    int64_t appended_at_ = -1;    ///< offset of its first byte
    std::vector<Array> arrays_;
    std::string point_scalars_, cell_scalars_;
};

}  // namespace openfab::tools
