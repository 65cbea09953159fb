// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a DICOM file says before its pixels: of which series it is, where each of its frames lies, and of
// what it is.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "tools/dicom/packed_frames.h"
#include "tools/dicom/transfer_syntax.h"

namespace openfab::tools {

/// What kind of object a file is, as far as its pixels mean something of their own.
enum class DicomKind { kImage, kSegmentation, kLabelMap, kParametricMap, kDose };

enum class SampleKind { kInteger, kBit, kFloat, kDouble };

/// A part of a segmentation.
struct DicomSegment {
    int32_t number = 0;
    std::string label;
    std::optional<std::array<uint8_t, 3>> color;  ///< sRGB
};

/// A file with pixels.
struct DicomImage {
    std::filesystem::path file;
    std::string label;                     ///< for people: its name, or its path below the folder
    std::string series;                    ///< its identifier
    std::optional<int64_t> series_number;  ///< as people know it
    std::string description;               ///< of the series; may be empty
    std::string modality, date;            ///< as YYYYMMDD; may be empty
    DicomKind kind = DicomKind::kImage;
    std::vector<DicomSegment> segments;
    int32_t width = 0, height = 0, frames = 1;
    SampleKind sample = SampleKind::kInteger;
    int32_t bits_allocated = 16, bits_stored = 16, high_bit = 15;
    bool has_sign = false;
    bool is_inverted = false;       ///< its low values are shown white (MONOCHROME1)
    bool is_placed = true;          ///< else its first pixel is put at 0, 0, 0
    bool is_in_volume = false;      ///< its place is that of an ultrasound volume, not of a patient
    bool has_offsets = false;       ///< of doses, which are sampled in planes at any distances
    bool is_contiguous = false;     ///< the distance of its slices is taken from their thickness
    bool is_relative = false;       ///< a dose in shares, not in Gy
    int64_t behind_bytes = 0;       ///< of pixels, behind the last frame
    bool has_other_values = false;  ///< a Real World Value Mapping beside the rescale
    TransferSyntax syntax;
    bool has_words = true;     ///< pixels of 8 bits, too, lie two in a word
    int64_t pixels_at = 0;     ///< in the file; neither this nor the next where it is deflated
    int64_t pixels_bytes = 0;  ///< as the file says; unknown where they are packed
    std::string long_offsets;  ///< of packed frames
    PackedFrames packed;       ///< found by check_pixels

    bool is_plain() const { return syntax.packing == Packing::kPlain; }
    int64_t pixels() const { return int64_t{width} * height; }
    int64_t frame_bits() const { return bits_allocated * pixels(); }
    /// Counts the bytes of one frame that begins at one, and of all in a row.
    int64_t frame_bytes() const { return (frame_bits() + 7) / 8; }
    int64_t all_bytes() const { return (frame_bits() * frames + 7) / 8; }
};

/// What tells frames of several volumes apart, such as the time at which one was taken.
struct FrameLabel {
    uint32_t source = 0;    ///< the tag of what says it
    std::string key;        ///< of a texture, which chooses by it; empty where none does
    std::string name;       ///< for people, of several: "times"
    double value = 0;       ///< the number that the key takes, or a quantity
    std::string text;       ///< instead of the number, where it is none
    bool is_rank = false;   ///< the key takes the place of `value` among all, from 1
    bool is_strict = true;  ///< else frames in different places may differ in it
};

/// The source of labels that say of which segment a frame is.
inline constexpr uint32_t kSegmentLabel = 0x0062000b;

/// A frame of a file.
struct DicomSlice {
    std::shared_ptr<DicomImage> image;
    int32_t frame = 0;
    Vec3d position;           ///< of the first pixel's centre, mm
    Vec3d across, down;       ///< to the next column, to the next row, mm
    double thickness_mm = 0;  ///< 0: not given
    double spacing_mm = 0;    ///< of the planes of a segmentation, as it says; 0: not given
    std::string stack;        ///< of the file's, to which it belongs
    double slope = 1, intercept = 0;
    /// The stored numbers that mean something; others are none.
    std::optional<std::pair<double, double>> range;
    std::optional<int32_t> only;  ///< the label that is 1, while others are 0
    bool is_empty = false;        ///< of another segment: all of it is 0
    std::vector<FrameLabel> labels;

    /// Names it for people: `im7`, `im7, frame 3`.
    std::string name() const;
    /// Returns what `source` says of it; null where that is nothing.
    const FrameLabel* label(uint32_t source) const;
};

struct DicomHead {
    std::filesystem::path file;
    std::string label;               ///< of the file, for people
    std::string series;              ///< empty where it was not found
    std::vector<std::string> names;  ///< of the series, as a field may say
    /// Empty where the file is none of DICOM, has no pixels or some that are not read.
    std::vector<DicomSlice> slices;
    bool is_foreign = false;       ///< no DICOM, or a list of files
    std::optional<Error> trouble;  ///< why its pixels are not read; without the file's name
};

/// Turns GDCM's messages off.
void silence_dicom();

/// Reads what stands before the pixels. Fails, without the file's name, where the file cannot be
/// opened or takes too much memory.
Result<DicomHead> read_dicom_head(const std::filesystem::path& file, const std::string& label,
                                  int64_t memory_bytes);

}  // namespace openfab::tools
