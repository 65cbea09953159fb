// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/transfer_syntax.h"

#include <gdcmTransferSyntax.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "tools/dicom/dicom_elements.h"
#include "tools/texture/check_memory.h"

namespace openfab::tools {

namespace {

constexpr const char* kLosslessJpeg2000 = "1.2.840.10008.1.2.4.90";
constexpr const char* kJpeg2000 = "1.2.840.10008.1.2.4.91";

struct Known {
    const char* identifier;
    Packing packing;
    const char* name;
    const char* codec;
};

/// What is not as the library has it. The blocks of HTJ2K are decoded by the same library as those of
/// JPEG 2000 (OpenJPEG, from 2.5 on), which finds out by itself.
constexpr std::array<Known, 23> kKnown{{
    {"1.2.840.10008.1.2.1.98", Packing::kRawFrames, "", ""},
    {"1.2.840.10008.1.2.8.1", Packing::kDeflatedFrames, "", ""},
    {"1.2.840.10008.1.2.4.201", Packing::kCodec, "HTJ2K", kLosslessJpeg2000},
    {"1.2.840.10008.1.2.4.202", Packing::kCodec, "HTJ2K", kLosslessJpeg2000},
    {"1.2.840.10008.1.2.4.203", Packing::kCodec, "HTJ2K", kJpeg2000},
    {"1.2.840.10008.1.2.4.94", Packing::kUnread, "JPIP, pixels elsewhere", ""},
    {"1.2.840.10008.1.2.4.95", Packing::kUnread, "JPIP, pixels elsewhere", ""},
    {"1.2.840.10008.1.2.4.204", Packing::kUnread, "JPIP, pixels elsewhere", ""},
    {"1.2.840.10008.1.2.4.205", Packing::kUnread, "JPIP, pixels elsewhere", ""},
    {"1.2.840.10008.1.2.4.110", Packing::kUnread, "JPEG XL", ""},
    {"1.2.840.10008.1.2.4.111", Packing::kUnread, "JPEG XL", ""},
    {"1.2.840.10008.1.2.4.112", Packing::kUnread, "JPEG XL", ""},
    {"1.2.840.10008.1.2.4.100", Packing::kUnread, "MPEG-2", ""},
    {"1.2.840.10008.1.2.4.101", Packing::kUnread, "MPEG-2", ""},
    {"1.2.840.10008.1.2.4.102", Packing::kUnread, "MPEG-4", ""},
    {"1.2.840.10008.1.2.4.103", Packing::kUnread, "MPEG-4", ""},
    {"1.2.840.10008.1.2.4.104", Packing::kUnread, "MPEG-4", ""},
    {"1.2.840.10008.1.2.4.105", Packing::kUnread, "MPEG-4", ""},
    {"1.2.840.10008.1.2.4.106", Packing::kUnread, "MPEG-4", ""},
    {"1.2.840.10008.1.2.4.107", Packing::kUnread, "HEVC", ""},
    {"1.2.840.10008.1.2.4.108", Packing::kUnread, "HEVC", ""},
    // Its pixels, but not its elements, are big-endian.
    {"1.2.840.113619.5.2", Packing::kUnread, "GE's own order of bytes", ""},
    {"1.2.840.10008.1.2.1.99", Packing::kDeflatedFile, "", ""},
}};

constexpr uint32_t kClass = 0x02, kSyntax = 0x10;  // elements of a file's own head

/// Where an identifier stands in a file: behind a preamble, in elements that say their kinds and lengths.
struct Place {
    size_t at = 0, bytes = 0;
};

Place find_identifier(std::string_view head, uint32_t element) {
    constexpr size_t kFirst = 132, kShort = 8, kLong = 12;
    if (head.size() < kFirst || head.substr(kFirst - 4, 4) != "DICM") return {};
    size_t at = kFirst;
    const auto number = [&](size_t from, size_t bytes) {
        return static_cast<size_t>(whole_numbers(head.substr(from, bytes), bytes).front());
    };
    while (at + kLong <= head.size() && number(at, 2) == 2) {
        const std::string_view kind = head.substr(at + 4, 2);
        const bool is_long = kind == "OB" || kind == "UN" || kind == "OW" || kind == "SQ" ||
                             kind == "UT" || kind == "OF" || kind == "UC" || kind == "UR";
        const size_t begin = at + (is_long ? kLong : kShort);
        const size_t bytes = is_long ? number(at + 8, 4) : number(at + 6, 2);
        if (bytes > head.size() || begin + bytes > head.size()) return {};
        if (number(at + 2, 2) == element) return {begin, bytes};
        at = begin + bytes;
    }
    return {};
}

Result<std::string> read_head(const InputFile& file) {
    constexpr size_t kHead = 1 << 16;
    std::string head(kHead, '\0');
    const Result<size_t> got = file.read(0, head.data(), head.size());
    if (!got) return got.error();
    head.resize(*got);
    return head;
}

std::string read_identifier(const InputFile& file, uint32_t element) {
    const Result<std::string> head = read_head(file);
    if (!head) return {};
    const Place place = find_identifier(*head, element);
    return std::string(trimmed(std::string_view(*head).substr(place.at, place.bytes)));
}

}  // namespace

std::string stated_syntax(const InputFile& file) {
    return read_identifier(file, kSyntax);
}

std::string stated_class(const InputFile& file) {
    return read_identifier(file, kClass);
}

TransferSyntax transfer_syntax(const std::string& identifier) {
    TransferSyntax out;
    out.identifier = identifier;
    const auto known = std::find_if(kKnown.begin(), kKnown.end(),
                                    [&](const Known& one) { return one.identifier == identifier; });
    if (known != kKnown.end()) {
        out.packing = known->packing;
        out.codec = known->codec;
        out.name = known->name;
        return out;
    }
    const gdcm::TransferSyntax::TSType type = gdcm::TransferSyntax::GetTSType(identifier.c_str());
    if (type == gdcm::TransferSyntax::TS_END) {
        out.packing = Packing::kUnread;
        out.name = "of an unknown kind";
        return out;
    }
    out.is_big_endian = type == gdcm::TransferSyntax::ExplicitVRBigEndian;
    if (gdcm::TransferSyntax(type).IsEncapsulated()) {
        out.packing = Packing::kCodec;
        out.codec = identifier;
    }
    return out;
}

bool is_known_to_library(const std::string& identifier) {
    return gdcm::TransferSyntax::GetTSType(identifier.c_str()) != gdcm::TransferSyntax::TS_END;
}

Result<std::unique_ptr<std::istream>> open_renamed(const InputFile& file,
                                                   const std::string& identifier,
                                                   int64_t memory_bytes) {
    if (Result<void> fits = check_memory(2 * file.bytes(), memory_bytes); !fits)
        return fits.error();
    Result<std::string> bytes = file.read_all(memory_bytes);
    if (!bytes) return bytes.error();
    // Frames in items have explicit elements, too (PS3.5, A.4).
    const bool in_items = transfer_syntax(identifier).packing != Packing::kPlain;
    std::string other = in_items ? kLosslessJpeg2000 : "1.2.840.10008.1.2.1";
    const Place place = find_identifier(*bytes, kSyntax);
    if (place.bytes > 0) {
        other.resize(std::max(place.bytes, other.size() + other.size() % 2), '\0');
        (*bytes)[place.at - 2] = static_cast<char>(other.size());
        bytes->replace(place.at, place.bytes, other);
    }
    return std::unique_ptr<std::istream>(std::make_unique<std::istringstream>(std::move(*bytes)));
}

}  // namespace openfab::tools
