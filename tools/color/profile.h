// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// ICC profiles of printers: written from a fitted model, and read from anywhere.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/samples.h"
#include "tools/color/separation.h"
#include "tools/texture/icc_context.h"

namespace openfab::color {

enum class Intent { kPerceptual, kRelative, kSaturation, kAbsolute };

struct ProfileOptions {
    SeparationOptions separation;
    std::string description = "OpenFab inks";
    /// The measurements, kept in the profile as text (tag `targ`).
    std::string measurements;
    /// ICC version 2.4 instead of 4.4: tables of 16 bits (lut16) with that version's Lab.
    bool version_two = false;
    int ink_nodes = 17;    ///< an axis of the table from inks to colours
    int color_nodes = 33;  ///< an axis of the tables from colours to inks
};

/// Makes an output profile, ICC version 4.4 or 2.4, of inks CMYK and Lab as connection space:
///
///   A2B0, A2B1, A2B2   inks to colours, relative to the white of the print
///   B2A0, B2A2         perceptual: scaled between the print's black and white, then separated
///   B2A1               relative colorimetric: separated as it is
///   gamt               what the inks do not reach within CIEDE2000 2
Result<std::string> make_profile(const PrinterModel& model, const ProfileOptions& options);

/// A printer's profile: output class, CMYK.
class PrinterProfile {
  public:
    /// Reads a file; errors name it and say what it is instead.
    static Result<PrinterProfile> read(const std::filesystem::path& file);
    /// Same for the bytes of one; errors do not name a file.
    static Result<PrinterProfile> parse(std::vector<uint8_t> bytes);

    std::string description() const { return tools::icc_description(profile_.get()); }

    /// Converts colours of sRGB, encoded 0..1, to inks as the profile's tables say. Inks may add up
    /// to more than 1. `black_point` scales black as well as white under the relative intent.
    Result<std::vector<Inks>> to_inks(const std::vector<Rgb>& colours, Intent intent,
                                      bool black_point) const;
    /// Returns the colours of inks that add up to 1 at most, relative to the print's white or
    /// absolute.
    Result<std::vector<Lab>> to_lab(const std::vector<Inks>& inks, bool absolute) const;

  private:
    PrinterProfile() = default;

    std::vector<uint8_t> bytes_;
    std::unique_ptr<tools::IccContext> context_;  ///< outlives profile_
    tools::CmsProfile profile_;
};

/// Scales inks so that they add up to `limit` at most.
Inks limited(Inks inks, double limit);

}  // namespace openfab::color
