// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// VTK's XML files (.vti, .vtr, .vts, .vtu), https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html:
// which arrays there are, and the numbers in them, whether as text, base64 or raw bytes, packed by zlib
// or not. Read without VTK, whose package takes half a gigabyte with what it needs: of its format these
// files are a small part, and untrusted ones must not reach the rest.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/cache.h"
#include "tools/texture/array_numbers.h"

namespace openfab::tools {

class VtkFile {
  public:
    enum class Where { kPoints, kCells, kPlaces, kTopology, kAxes };
    enum class Coding { kText, kBase64, kAppended };
    struct Array {
        Where where = Where::kPoints;
        std::string name;
        ArrayType type = ArrayType::kFloat32;
        int64_t components = 1;
        Coding coding = Coding::kText;
        int64_t offset = 0;  ///< in the appended data
        std::string text;    ///< what stands in the file, where it is not appended
    };

    /// Reads the file up to its appended data. `kind` is the type of its root that is wanted, such as
    /// `ImageData`. Errors do not name the file.
    static Result<std::unique_ptr<VtkFile>> open(const std::filesystem::path& file,
                                                 const std::string& kind,
                                                 const texture::ReadLimits& limits);

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

    // Of ImageData and other structured grids and their piece; of UnstructuredGrid the counts.
    std::array<double, 6> extent{};  ///< of the piece: first and last point along each axis
    std::array<double, 3> origin{}, spacing{1, 1, 1};
    std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
    int64_t points = 0, cells = 0;

  private:
    class Reading;
    explicit VtkFile(InputFile file) : file_(std::move(file)) {}

    InputFile file_;
    bool swapped_ = false, packed_ = false, appended_base64_ = false;
    std::string unknown_packer_;  ///< empty, or what packed arrays that are not text
    int64_t header_bytes_ = 4;    ///< of a number before the bytes of an array
    int64_t appended_at_ = -1;    ///< offset of its first byte
    std::vector<Array> arrays_;
    std::string point_scalars_, cell_scalars_;
};

}  // namespace openfab::tools
