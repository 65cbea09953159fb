// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_slice.h"

#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <string_view>

#include "base/input_file.h"
#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/frame_places.h"
#include "tools/dicom/messages.h"
#include "tools/dicom/pixel_format.h"
#include "tools/texture/check_memory.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

const gdcm::Tag kPixels(0x7fe0, 0x0010), kFloats(0x7fe0, 0x0008), kDoubles(0x7fe0, 0x0009);

/// Finds pixels that are neither packed nor deflated, or the first of packed ones: `at` is where the
/// library stopped.
bool find_pixels(const InputFile& file, const gdcm::Tag& tag, int64_t at, DicomImage* out) {
    std::array<uint8_t, 12> head{};
    constexpr auto kHead = static_cast<int64_t>(head.size());
    if (at < kHead || at > file.bytes()) return false;
    const Result<size_t> got = file.read(at - kHead, head.data(), head.size());
    if (!got || *got != head.size()) return false;
    const auto number = [&](size_t from, size_t bytes) {
        uint32_t value = 0;
        for (size_t i = 0; i < bytes; ++i)
            value = value << 8 | head[from + (out->syntax.is_big_endian ? i : bytes - 1 - i)];
        return value;
    };
    const auto is_tag = [&](size_t from) {
        return number(from, 2) == tag.GetGroup() && number(from + 2, 2) == tag.GetElement();
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

/// Whether a file says that it is DICOM.
bool is_marked(const fs::path& path, const InputFile& file) {
    std::array<char, 4> mark{};
    const Result<size_t> got = file.read(128, mark.data(), mark.size());
    const std::string kind = path.extension().string();
    return (got && std::string_view(mark.data(), *got) == "DICM") || kind == ".dcm" ||
           kind == ".DCM";
}

/// A file as the library reads it.
class Elements {
  public:
    /// Reads all that stands before the pixels; false where it is not DICOM, or damaged.
    Result<bool> open(const InputFile& file, int64_t memory_bytes) {
        identifier_ = stated_syntax(file);
        file_ = &file;
        memory_bytes_ = memory_bytes;
        if (Result<bool> read = read_up_to(kPixels); !read || !*read) return read;
        // What does not state it is understood by the library.
        const gdcm::TransferSyntax& found =
            reader_->GetFile().GetHeader().GetDataSetTransferSyntax();
        if (identifier_.empty() && found.IsValid())
            identifier_ = gdcm::TransferSyntax::GetTSString(found);
        return true;
    }

    /// Finds where the pixels begin; false where there are none.
    Result<bool> find_pixels_of(DicomImage* out) {
        const std::pair<gdcm::Tag, SampleKind> kinds[] = {{kPixels, SampleKind::kInteger},
                                                          {kFloats, SampleKind::kFloat},
                                                          {kDoubles, SampleKind::kDouble}};
        for (const auto& [tag, sample] : kinds) {
            if (tag != kPixels) {
                // Numbers with a fraction stand before the others, which such a file does not have: they
                // have been read, but not where they lie.
                if (!set().FindDataElement(tag)) continue;
                if (Result<bool> read = read_up_to(tag); !read || !*read) return read;
            }
            const auto at = static_cast<int64_t>(reader_->GetStreamCurrentPosition());
            if (!find_pixels(*file_, tag, at, out)) continue;
            out->sample = sample;
            return true;
        }
        return false;
    }

    const gdcm::DataSet& set() const { return reader_->GetFile().GetDataSet(); }
    const std::string& identifier() const { return identifier_; }

  private:
    Result<bool> read_up_to(const gdcm::Tag& tag) {
        reader_ = std::make_unique<gdcm::Reader>();
        if (identifier_.empty() || is_known_to_library(identifier_)) {
            reader_->SetFileName(file_->name().c_str());
            if (!reader_->CanRead()) return false;
        } else {
            Result<std::unique_ptr<std::istream>> renamed =
                open_renamed(*file_, identifier_, memory_bytes_);
            if (!renamed) return renamed.error();
            stream_ = std::move(*renamed);
            reader_->SetStream(*stream_);
        }
        // The library reads all that stands before the pixels, which of a damaged file is all of it.
        if (Result<void> fits = check_memory(4 * file_->bytes(), memory_bytes_); !fits)
            return fits.error();
        return reader_->ReadUpToTag(tag, {tag});
    }

    const InputFile* file_ = nullptr;
    int64_t memory_bytes_ = 0;
    std::string identifier_;
    std::unique_ptr<std::istream> stream_;
    std::unique_ptr<gdcm::Reader> reader_;
};

/// Of several dates that of the series.
std::string date_of(const gdcm::DataSet& set) {
    for (const uint16_t item : {0x0021, 0x0022, 0x0023, 0x0020}) {
        const std::string_view date = trimmed(bytes_of(set, {0x0008, item}));
        constexpr size_t kDigits = 8;
        if (date.size() == kDigits && date.find_first_not_of("0123456789") == std::string::npos)
            return std::string(date);
    }
    return {};
}

/// What names the series, and says how it was made.
void read_names(const gdcm::DataSet& set, DicomImage* out) {
    out->series = trimmed(bytes_of(set, {0x0020, 0x000e}));
    out->description = trimmed(bytes_of(set, {0x0008, 0x103e}));
    out->modality = trimmed(bytes_of(set, {0x0008, 0x0060}));
    out->date = date_of(set);
    out->long_offsets = bytes_of(set, {0x7fe0, 0x0001});
    double number = 0;
    constexpr double kMostDigits = 1e12;
    if (parse_decimals(bytes_of(set, {0x0020, 0x0011}), &number, 1) &&
        std::abs(number) < kMostDigits)
        out->series_number = std::llround(number);
}

Result<std::vector<DicomSlice>> read_slices(Elements* elements,
                                            const std::shared_ptr<DicomImage>& image) {
    if (Result<void> kind = read_kind(elements->set(), image.get()); !kind) return kind.error();
    const TransferSyntax& syntax = image->syntax;
    if (syntax.packing == Packing::kUnread) {
        return user_error(fmt::format(messages::kSyntaxNotRead, syntax.name, syntax.identifier),
                          messages::kWriteUncompressed);
    }
    if (syntax.packing == Packing::kDeflatedFile) {
        const gdcm::DataSet& set = elements->set();
        if (set.FindDataElement(kFloats)) image->sample = SampleKind::kFloat;
        if (set.FindDataElement(kDoubles)) image->sample = SampleKind::kDouble;
    } else {
        const Result<bool> found = elements->find_pixels_of(image.get());
        if (!found) return found.error();
        if (!*found) return user_error(messages::kNoPixels);
    }
    if (Result<void> format = read_format(elements->set(), image.get()); !format)
        return format.error();
    return read_frames(elements->set(), image);
}

}  // namespace

std::string DicomSlice::name() const {
    return image->frames == 1 ? image->label : fmt::format("{}, frame {}", image->label, frame + 1);
}

const FrameLabel* DicomSlice::label(uint32_t source) const {
    const auto found = std::find_if(labels.begin(), labels.end(), [&](const FrameLabel& label) {
        return label.source == source;
    });
    return found == labels.end() ? nullptr : &*found;
}

void silence_dicom() {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
}

Result<DicomHead> read_dicom_head(const fs::path& path, const std::string& label,
                                  int64_t memory_bytes) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    DicomHead out;
    out.file = path;
    out.label = label;
    out.trouble = user_error(messages::kNotDicom);
    // A medium's list, whatever its name, is no slice, damaged or not.
    constexpr std::string_view kDirectory = "1.2.840.10008.1.3.10";
    const bool is_list = stated_class(*file) == kDirectory;
    out.is_foreign = is_list || !is_marked(path, *file);
    Elements elements;
    const Result<bool> read = elements.open(*file, memory_bytes);
    if (!read) return read.error();
    if (!*read) return out;
    const auto image = std::make_shared<DicomImage>();
    image->file = path;
    image->label = label;
    image->syntax = transfer_syntax(elements.identifier());
    read_names(elements.set(), image.get());
    out.series = image->series;
    out.names = {image->series, image->description};
    if (image->series_number) out.names.push_back(std::to_string(*image->series_number));
    out.is_foreign = is_list;
    Result<std::vector<DicomSlice>> slices = read_slices(&elements, image);
    if (slices) {
        out.trouble.reset();
        out.slices = std::move(*slices);
    } else {
        out.trouble = slices.error();
    }
    return out;
}

}  // namespace openfab::tools
