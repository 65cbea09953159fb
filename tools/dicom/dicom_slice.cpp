// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_slice.h"

#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "base/input_file.h"
#include "base/scan_number.h"
#include "tools/texture/check_memory.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

const gdcm::Tag kPixels(0x7fe0, 0x0010);

/// Returns a value's bytes; empty where there is none.
std::string_view value(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    if (!set.FindDataElement(tag)) return {};
    const gdcm::ByteValue* const bytes = set.GetDataElement(tag).GetByteValue();
    if (bytes == nullptr || bytes->GetPointer() == nullptr) return {};
    return {bytes->GetPointer(), bytes->GetLength()};
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kPadding(" \0", 2);
    text.remove_prefix(std::min(text.find_first_not_of(kPadding), text.size()));
    return text.substr(0, text.find_last_not_of(kPadding) + 1);
}

/// Parses `count` decimals that backslashes part.
bool decimals(const gdcm::DataSet& set, const gdcm::Tag& tag, double* out, size_t count) {
    std::string_view text = value(set, tag);
    for (size_t i = 0; i < count; ++i) {
        const size_t end = std::min(text.find('\\'), text.size());
        if (!scan_number(trimmed(text.substr(0, end)), out++).empty()) return false;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return trimmed(text).empty();
}

/// A number of 16 bits; `otherwise` where there is none.
int32_t short_of(const gdcm::DataSet& set, const gdcm::Tag& tag, int32_t otherwise) {
    const std::string_view bytes = value(set, tag);
    if (bytes.size() != 2) return otherwise;
    return static_cast<uint8_t>(bytes[0]) | static_cast<uint8_t>(bytes[1]) << 8;
}

/// What a file says of its pixels' form.
Result<void> read_format(const gdcm::DataSet& set, DicomSlice* out) {
    out->height = short_of(set, {0x0028, 0x0010}, 0);
    out->width = short_of(set, {0x0028, 0x0011}, 0);
    if (out->width < 1 || out->height < 1) return user_error("it holds no picture");
    if (const int32_t samples = short_of(set, {0x0028, 0x0002}, 1); samples != 1)
        return user_error(fmt::format("it has {} values a pixel; a scan has one", samples));
    out->bits_allocated = short_of(set, {0x0028, 0x0100}, 0);
    out->bits_stored = short_of(set, {0x0028, 0x0101}, out->bits_allocated);
    out->high_bit = short_of(set, {0x0028, 0x0102}, out->bits_stored - 1);
    out->has_sign = short_of(set, {0x0028, 0x0103}, 0) == 1;
    const int32_t all = out->bits_allocated;
    if ((all != 8 && all != 16) || out->bits_stored < 1 || out->bits_stored > all ||
        out->high_bit < out->bits_stored - 1 || out->high_bit >= all)
        return user_error(fmt::format("its pixels of {} bits in {} are not read; 8 and 16 are",
                                      out->bits_stored, all));
    double frames = 1;
    const gdcm::Tag count(0x0028, 0x0008);
    if (!value(set, count).empty() && (!decimals(set, count, &frames, 1) || frames != 1))
        return user_error("it holds several frames; write one file a slice");
    const gdcm::Tag slope(0x0028, 0x1053), intercept(0x0028, 0x1052);
    if ((!value(set, slope).empty() && !decimals(set, slope, &out->slope, 1)) ||
        (!value(set, intercept).empty() && !decimals(set, intercept, &out->intercept, 1)))
        return user_error("its rescale slope or intercept is not a number");
    return {};
}

Result<void> read_place(const gdcm::DataSet& set, DicomSlice* out) {
    std::array<double, 3> position{};
    std::array<double, 6> axes{};
    std::array<double, 2> spacing{};
    if (!decimals(set, {0x0020, 0x0032}, position.data(), 3))
        return user_error("it does not say where it lies (Image Position)");
    if (!decimals(set, {0x0020, 0x0037}, axes.data(), 6))
        return user_error("it does not say how it is turned (Image Orientation)");
    if (!decimals(set, {0x0028, 0x0030}, spacing.data(), 2) || !(spacing[0] > 0) ||
        !(spacing[1] > 0))
        return user_error("it does not say how large its pixels are (Pixel Spacing)");
    out->position = {position[0], position[1], position[2]};
    const Vec3d across{axes[0], axes[1], axes[2]}, down{axes[3], axes[4], axes[5]};
    constexpr double kRounding = 1e-3;
    if (std::abs(length(across) - 1) > kRounding || std::abs(length(down) - 1) > kRounding ||
        std::abs(dot(across, down)) > kRounding)
        return user_error("the axes of its orientation are not at right angles, of length 1");
    // Between rows first, then between columns.
    out->down = down * spacing[0];
    out->across = across * spacing[1];
    const gdcm::Tag thickness(0x0018, 0x0050);
    if (!value(set, thickness).empty() && !decimals(set, thickness, &out->thickness_mm, 1))
        return user_error("its thickness is not a number");
    return {};
}

float pixel(const DicomSlice& slice, const char* at) {
    uint32_t bits = static_cast<uint8_t>(at[0]);
    if (slice.bits_allocated == 16) bits |= static_cast<uint32_t>(static_cast<uint8_t>(at[1])) << 8;
    const uint32_t mask = (1U << slice.bits_stored) - 1;
    bits = bits >> (slice.high_bit + 1 - slice.bits_stored) & mask;
    auto stored = static_cast<int64_t>(bits);
    if (slice.has_sign && (bits >> (slice.bits_stored - 1)) != 0) stored -= int64_t{mask} + 1;
    return static_cast<float>(static_cast<double>(stored) * slice.slope + slice.intercept);
}

/// Pixels that are packed, by the library's decoders.
Result<void> unpack(const InputFile& file, std::vector<char>* out) {
    gdcm::ImageReader reader;
    reader.SetFileName(file.name().c_str());
    if (!reader.Read() || reader.GetImage().GetBufferLength() != out->size() ||
        !reader.GetImage().GetBuffer(out->data()))
        return user_error("its packed pixels are damaged, or of a kind that is not known");
    return {};
}

}  // namespace

void silence_dicom() {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
}

Result<DicomSlice> read_dicom_slice(const fs::path& path, int64_t memory_bytes) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    // The library reads it whole.
    if (Result<void> fits = check_memory(4 * file->bytes(), memory_bytes); !fits)
        return fits.error();
    gdcm::Reader reader;
    reader.SetFileName(file->name().c_str());
    if (!reader.CanRead() || !reader.ReadUpToTag(kPixels))
        return user_error("it is not a DICOM file, or damaged");
    const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    if (syntax == gdcm::TransferSyntax::ExplicitVRBigEndian)
        return user_error("its numbers are big-endian, which DICOM has given up; write it anew");
    const gdcm::DataSet& set = reader.GetFile().GetDataSet();
    DicomSlice out;
    out.file = path;
    out.packed = syntax.IsEncapsulated();
    out.series = trimmed(value(set, {0x0020, 0x000e}));
    double number = 0;
    if (decimals(set, {0x0020, 0x0011}, &number, 1)) out.series_number = std::lround(number);
    if (Result<void> format = read_format(set, &out); !format) return format.error();
    if (Result<void> place = read_place(set, &out); !place) return place.error();
    return out;
}

Result<void> read_dicom_pixels(const DicomSlice& slice, float* out) {
    const Result<InputFile> file = InputFile::open(slice.file);
    if (!file) return file.error();
    const auto count = static_cast<size_t>(slice.width) * static_cast<size_t>(slice.height);
    const size_t size = slice.bits_allocated == 16 ? 2 : 1;
    std::vector<char> unpacked;
    gdcm::Reader reader;
    std::string_view bytes;
    if (slice.packed) {
        unpacked.resize(count * size);
        if (Result<void> done = unpack(*file, &unpacked); !done) return done;
        bytes = {unpacked.data(), unpacked.size()};
    } else {
        reader.SetFileName(file->name().c_str());
        if (!reader.Read()) return user_error("it is damaged");
        bytes = value(reader.GetFile().GetDataSet(), kPixels);
    }
    if (bytes.size() < count * size)
        return user_error("it is cut short: it has fewer pixels than it says");
    for (size_t i = 0; i < count; ++i)
        out[i] = pixel(slice, bytes.data() + i * size);
    return {};
}

}  // namespace openfab::tools
