// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_slice.h"

#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <array>
#include <cmath>
#include <string_view>

#include "base/input_file.h"
#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/messages.h"
#include "tools/texture/check_memory.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

const gdcm::Tag kPixels(0x7fe0, 0x0010);
/// Of a texture, too.
constexpr double kMostFrames = 16384;

/// What a file says of its pixels' form.
Result<void> read_format(const gdcm::DataSet& set, DicomImage* out) {
    out->height = short_of(set, {0x0028, 0x0010}, 0);
    out->width = short_of(set, {0x0028, 0x0011}, 0);
    if (out->width < 1 || out->height < 1) return user_error(messages::kNoPicture);
    if (const int32_t samples = short_of(set, {0x0028, 0x0002}, 1); samples != 1)
        return user_error(fmt::format(messages::kValuesPerPixel, samples));
    const std::string_view photometric = trimmed(bytes_of(set, {0x0028, 0x0004}));
    out->is_inverted = photometric == "MONOCHROME1";
    if (!photometric.empty() && !out->is_inverted && photometric != "MONOCHROME2")
        return user_error(fmt::format(messages::kPixelsAreColours, photometric));
    if (bytes_of(set, {0x0008, 0x0008}).find("MOSAIC") != std::string_view::npos)
        return user_error(messages::kMosaic, messages::kMosaicHelp);
    if (set.FindDataElement(gdcm::Tag(0x0028, 0x3000))) return user_error(messages::kModalityLut);
    out->bits_allocated = short_of(set, {0x0028, 0x0100}, 0);
    out->bits_stored = short_of(set, {0x0028, 0x0101}, out->bits_allocated);
    out->high_bit = short_of(set, {0x0028, 0x0102}, out->bits_stored - 1);
    out->has_sign = short_of(set, {0x0028, 0x0103}, 0) == 1;
    const int32_t all = out->bits_allocated;
    if ((all != 8 && all != 16 && all != 32) || out->bits_stored < 1 || out->bits_stored > all ||
        out->high_bit < out->bits_stored - 1 || out->high_bit >= all)
        return user_error(fmt::format(messages::kPixelBits, out->bits_stored, all));
    double frames = 1;
    const std::string_view count = bytes_of(set, {0x0028, 0x0008});
    if (!trimmed(count).empty() && (!parse_decimals(count, &frames, 1) || !(frames >= 1) ||
                                    frames > kMostFrames || frames != std::floor(frames)))
        return user_error(fmt::format(messages::kFrameCount, trimmed(count), kMostFrames));
    out->frames = static_cast<int32_t>(frames);
    return {};
}

/// Finds pixels that are neither packed nor deflated, or the first of packed ones: `at` is where the
/// library stopped.
bool find_pixels(const InputFile& file, int64_t at, DicomImage* out) {
    std::array<uint8_t, 12> head{};
    constexpr auto kHead = static_cast<int64_t>(head.size());
    if (at < kHead || at > file.bytes()) return false;
    const Result<size_t> got = file.read(at - kHead, head.data(), head.size());
    if (!got || *got != head.size()) return false;
    const auto number = [&](size_t from, size_t bytes) {
        uint32_t value = 0;
        for (size_t i = 0; i < bytes; ++i)
            value = value << 8 | head[from + (out->is_big_endian ? i : bytes - 1 - i)];
        return value;
    };
    const auto is_tag = [&](size_t from) {
        return number(from, 2) == kPixels.GetGroup() && number(from + 2, 2) == kPixels.GetElement();
    };
    // With a kind: tag, kind, two bytes, length; without one: tag, length.
    if (is_tag(0)) {
        out->has_words = head[5] == 'W';
    } else if (!is_tag(4)) {
        return false;
    }
    out->pixels_at = at;
    out->pixels_bytes = number(8, 4);
    return true;
}

/// Where a file's frames lie.
class Places {
  public:
    Places(const gdcm::DataSet& set, DicomImage* image)
        : groups_(set), image_(image), offsets_(bytes_of(set, {0x3004, 0x000c})) {}

    Result<void> read(int32_t frame, DicomSlice* out) {
        if (Result<void> plane = read_plane(frame, out); !plane) return plane;
        if (image_->frames > 1 && groups_.find_own(frame, kPosition, kPositionTag).empty()) {
            const Result<double> along = along_normal(frame, *out);
            if (!along) return along.error();
            const Vec3d plane = cross(out->across, out->down);
            out->position = out->position + plane * (*along / length(plane));
        }
        return read_rescale(frame, out);
    }

  private:
    const gdcm::Tag kPosition{0x0020, 0x9113}, kPositionTag{0x0020, 0x0032};
    const gdcm::Tag kMeasures{0x0028, 0x9110};

    Result<void> read_plane(int32_t frame, DicomSlice* out) {
        std::array<double, 3> position{};
        std::array<double, 6> axes{1, 0, 0, 0, 1, 0};
        std::array<double, 2> spacing{};
        const std::string where = groups_.find(frame, kPosition, kPositionTag);
        const std::string turned = groups_.find(frame, {0x0020, 0x9116}, {0x0020, 0x0037});
        // Frames of one file are in place towards each other without it.
        if (frame == 0)
            image_->is_placed = image_->frames == 1 || !where.empty() || !turned.empty();
        if (image_->is_placed && !parse_decimals(where, position.data(), 3))
            return user_error(messages::kNoImagePosition);
        if (image_->is_placed && !parse_decimals(turned, axes.data(), 6))
            return user_error(messages::kNoImageOrientation);
        if (!parse_decimals(groups_.find(frame, kMeasures, {0x0028, 0x0030}), spacing.data(), 2) ||
            !(spacing[0] > 0) || !(spacing[1] > 0))
            return user_error(messages::kNoPixelSpacing);
        out->position = {position[0], position[1], position[2]};
        const Vec3d across{axes[0], axes[1], axes[2]}, down{axes[3], axes[4], axes[5]};
        constexpr double kRounding = 1e-3;
        if (!(std::abs(length(across) - 1) <= kRounding) ||
            !(std::abs(length(down) - 1) <= kRounding) ||
            !(std::abs(dot(across, down)) <= kRounding))
            return user_error(messages::kOrientationNotOrthogonal);
        // Between rows first, then between columns.
        out->down = down * spacing[0];
        out->across = across * spacing[1];
        const std::string thickness = groups_.find(frame, kMeasures, {0x0018, 0x0050});
        if (!trimmed(thickness).empty() && !parse_decimals(thickness, &out->thickness_mm, 1))
            return user_error(messages::kThicknessNotANumber);
        return {};
    }

    /// How far a frame without a position of its own lies from the first: by a list (of doses), else by
    /// one distance.
    Result<double> along_normal(int32_t frame, const DicomSlice& slice) {
        if (!offsets_.empty()) {
            const auto count = static_cast<size_t>(image_->frames);
            if (offset_.empty()) {
                offset_.resize(count);
                if (!parse_decimals(offsets_, offset_.data(), count))
                    return user_error(fmt::format(messages::kFrameOffsets, count));
            }
            return offset_[static_cast<size_t>(frame)] - offset_[0];
        }
        double step = slice.thickness_mm;
        const std::string spacing = groups_.find(frame, kMeasures, {0x0018, 0x0088});
        if (!trimmed(spacing).empty() && !parse_decimals(spacing, &step, 1))
            return user_error(messages::kFrameDistanceNotANumber);
        if (step == 0) return user_error(messages::kNoSliceSpacing);
        return step * frame;
    }

    Result<void> read_rescale(int32_t frame, DicomSlice* out) {
        const gdcm::Tag group(0x0028, 0x9145);
        const std::string slope = groups_.find(frame, group, {0x0028, 0x1053});
        const std::string intercept = groups_.find(frame, group, {0x0028, 0x1052});
        const std::string dose = groups_.find(frame, group, {0x3004, 0x000e});
        if ((!trimmed(slope).empty() && !parse_decimals(slope, &out->slope, 1)) ||
            (!trimmed(intercept).empty() && !parse_decimals(intercept, &out->intercept, 1)) ||
            (!trimmed(dose).empty() && !parse_decimals(dose, &out->slope, 1)))
            return user_error(messages::kRescaleNotANumber);
        return {};
    }

    FrameGroups groups_;
    DicomImage* image_;
    std::string_view offsets_;
    std::vector<double> offset_;
};

Result<std::vector<DicomSlice>> read_slices(const gdcm::DataSet& set,
                                            const std::shared_ptr<DicomImage>& image) {
    if (Result<void> format = read_format(set, image.get()); !format) return format.error();
    std::vector<DicomSlice> slices(static_cast<size_t>(image->frames));
    Places places(set, image.get());
    for (int32_t frame = 0; frame < image->frames; ++frame) {
        DicomSlice& slice = slices[static_cast<size_t>(frame)];
        slice.image = image;
        slice.frame = frame;
        if (Result<void> place = places.read(frame, &slice); !place) {
            if (image->frames == 1) return place.error();
            return with_context(place.error(), fmt::format(messages::kInFrame, frame + 1));
        }
    }
    return slices;
}

/// Whether a file says that it is DICOM.
bool is_marked(const fs::path& path, const InputFile& file) {
    std::array<char, 4> mark{};
    const Result<size_t> got = file.read(128, mark.data(), mark.size());
    const std::string kind = path.extension().string();
    return (got && std::string_view(mark.data(), *got) == "DICM") || kind == ".dcm" ||
           kind == ".DCM";
}

}  // namespace

std::string DicomSlice::name() const {
    const std::string file = image->file.filename().string();
    return image->frames == 1 ? file : fmt::format("{}, frame {}", file, frame + 1);
}

void silence_dicom() {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
}

Result<DicomHead> read_dicom_head(const fs::path& path, int64_t memory_bytes) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    DicomHead out;
    out.file = path;
    out.trouble = user_error(messages::kNotDicom);
    gdcm::Reader reader;
    reader.SetFileName(file->name().c_str());
    out.is_foreign = !is_marked(path, *file);
    if (!reader.CanRead()) return out;
    // The library reads all that stands before the pixels, which of a damaged file is all of it.
    if (Result<void> fits = check_memory(4 * file->bytes(), memory_bytes); !fits)
        return fits.error();
    if (!reader.ReadUpToTag(kPixels, {kPixels})) return out;
    const gdcm::DataSet& set = reader.GetFile().GetDataSet();
    const gdcm::FileMetaInformation& meta = reader.GetFile().GetHeader();
    const gdcm::TransferSyntax& syntax = meta.GetDataSetTransferSyntax();
    const auto image = std::make_shared<DicomImage>();
    image->file = path;
    image->is_packed = syntax.IsEncapsulated();
    image->is_deflated = syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
    image->is_big_endian = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
    image->series = trimmed(bytes_of(set, {0x0020, 0x000e}));
    image->description = trimmed(bytes_of(set, {0x0008, 0x103e}));
    double number = 0;
    constexpr double kMostDigits = 1e12;
    if (parse_decimals(bytes_of(set, {0x0020, 0x0011}), &number, 1) &&
        std::abs(number) < kMostDigits)
        image->series_number = std::llround(number);
    out.series = image->series;
    out.names = {image->series, image->description};
    if (image->series_number) out.names.push_back(std::to_string(*image->series_number));
    constexpr std::string_view kDirectory = "1.2.840.10008.1.3.10";
    out.is_foreign = trimmed(bytes_of(meta, {0x0002, 0x0002})) == kDirectory;
    out.trouble = user_error(messages::kNoPixels);
    const auto at = static_cast<int64_t>(reader.GetStreamCurrentPosition());
    if (!image->is_deflated && !find_pixels(*file, at, image.get())) return out;
    Result<std::vector<DicomSlice>> slices = read_slices(set, image);
    if (slices) {
        out.trouble.reset();
        out.slices = std::move(*slices);
    } else {
        out.trouble = slices.error();
    }
    return out;
}

}  // namespace openfab::tools
