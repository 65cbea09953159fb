// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the numbers of a picture mean, by what its file says: an ICC profile, chunks of a PNG, the
// chromaticities of an OpenEXR file; and by convention where it says nothing.

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "tools/texture/rgb_space.h"

namespace openfab::tools {

/// Lightness and two differences of colour, of TIFF: how these are stored.
enum class Lab { kNone, kSigned, kShifted };

struct FileColor {
    Lab lab = Lab::kNone;          ///< then nothing else counts
    RgbSpace space;                ///< where there is no profile, or none that can be read
    std::vector<uint8_t> profile;  ///< ICC; may be damaged, or of another kind of colour
    bool inks = false;             ///< cyan, magenta, yellow and black, 1 for all of it
    const char* note = nullptr;    ///< what is not known of the colours, a message
    bool bare_alpha = false;       ///< a last channel of 4 is left out
    bool straight_alpha = false;   ///< colours are not multiplied by it, whatever OpenImageIO says
};

/// Of a PNG, in this order: cICP, iCCP, sRGB, gAMA and cHRM (PNG, third edition, 4.3); one that says
/// nothing is sRGB, of 16 bits too, as browsers and OpenImageIO have it. In other formats a profile
/// counts first, then OpenEXR's chromaticities, TIFF's Lab or EXIF's Adobe RGB; else integers of 8 bits are sRGB, and others linear
/// light with its primaries. `format` is OpenImageIO's name of it.
FileColor color_of(const InputFile& file, std::string_view format, const OIIO::ImageSpec& spec);

/// Whether a TIFF has Lab, by what OpenImageIO calls its colours.
Lab lab_of(const OIIO::ImageSpec& spec);

/// Converts Lab as it is stored, each value scaled to 0..1 from integers of `steps` + 1 values, to linear
/// light with the primaries of sRGB. Its white is D50, which becomes white.
class LabDecoder {
  public:
    LabDecoder(Lab stored, float steps);
    void decode(const float* in, float* rgb) const;

  private:
    Lab stored_;
    double steps_;
    RgbSpace from_xyz_;
};

}  // namespace openfab::tools
