// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Readers of volumes: stacks of pictures, NRRD, NPY, .cube tables, VTK's .vti, .vtr, .vts, .vtu and
// .vtk. Those of XDMF are in xdmf_reader.h, of NIfTI and MetaImage in scans.h.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "texture/cache.h"
#include "texture/volume.h"

namespace openfab::tools {

/// A volume whose size is known and whose texels can be read. Errors do not name the file.
class VolumeReader {
  public:
    virtual ~VolumeReader() = default;
    Vec3i size;
    int32_t channels = 1;
    /// Lowest corner and size of a texel, where the file gives them.
    std::optional<std::array<double, 3>> origin, spacing;
    bool table = false;
    /// What a turned grid has beyond its texels, unless the options say.
    std::array<float, 4> beyond{};
    bool no_nan = false;      ///< none of its numbers can be NaN
    bool one_field = false;   ///< it has none to choose from by their names
    bool no_lengths = false;  ///< it does not say how large a texel is
    bool in_mm = false;       ///< its lengths are, whatever an option says
    bool rounded = false;     ///< an integer was read that a float does not hold
    bool resampled = false;   ///< at a pitch, with a value where the file has none

    /// Fills a slice, size.x * size.y * channels floats: channels innermost, then x, then y
    /// upwards. In every format the first values of the file have the lowest coordinates. Slices
    /// are read once each, in order. Calls `wrote` now and then for bytes that were written.
    using Wrote = std::function<void(int64_t bytes)>;
    virtual Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) = 0;

    int64_t row_floats() const { return static_cast<int64_t>(size.x) * channels; }
    int64_t slice_floats() const { return row_floats() * size.y; }
};

using MadeReader = Result<std::unique_ptr<VolumeReader>>;

/// Opens pictures of one size as slices, the first at the bottom; one file gives its pages. The
/// first row is at the lowest y, as in an array, not at the top as in a picture. 8-bit colour is
/// decoded from sRGB unless the space says otherwise, all else is taken as linear; integers are
/// scaled to 0..1.
MadeReader open_stack(const std::vector<std::filesystem::path>& files,
                      const texture::VolumeOptions& options, const texture::ReadLimits& limits);
/// Opens an NRRD of 3 dimensions, or of 4 with 1 to 4 channels along any of them; raw, text or gzip,
/// attached or in a file of its own, after a `line skip` and a `byte skip`. Unsigned integers of 8 and
/// 16 bits are scaled to 0..1, others are taken as they are. "space origin" is the centre of the first
/// texel; axes may be turned (placed_grid.h).
MadeReader open_nrrd(const std::filesystem::path& file, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits);
/// Opens an NPY of shape (z, y, x) or (z, y, x, channel), integers as in open_nrrd. That of a print lies where FILE.npy.json
/// beside it says.
MadeReader open_npy(const std::filesystem::path& file, const texture::ReadLimits& limits);
/// Opens a 3-D look-up table (LUT_3D_SIZE): red is x, DOMAIN_MIN and _MAX give the box; three
/// channels.
MadeReader open_cube(const std::filesystem::path& file, const texture::ReadLimits& limits);
/// Opens a file of VTK, XML or older, by what it holds: image data, a rectilinear, a curvilinear or an
/// unstructured grid, and of it the field that the options name.
MadeReader open_vtk(const std::filesystem::path& file, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits);

/// Formats of numbers as they lie in files.
struct NumberFormat {
    enum class Kind { kUnsigned, kSigned, kFloat } kind = Kind::kFloat;
    int bytes = 4;
    bool swapped = false;    ///< big-endian
    bool as_stored = false;  ///< else unsigned ones of 1 and 2 bytes become 0..1
};

/// Reads one number.
float read_number(const NumberFormat& format, const char* at);
double read_number_exactly(const NumberFormat& format, const char* at);
/// Returns a float of few bits as IEEE 754 builds them: a sign, an exponent, a fraction.
double small_float(uint32_t bits, int exponent_bits, int fraction_bits);
/// Returns whether a number is an integer that a float does not hold.
bool is_rounded(const NumberFormat& format, const char* at);
/// Returns the stored number that becomes 1.
double unit_of(const NumberFormat& format);

}  // namespace openfab::tools
