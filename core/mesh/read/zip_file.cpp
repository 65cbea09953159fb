// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Not based on minizip's unzip, although minizip writes our packages: on 15,000 damaged archives it
// was as safe (under the address sanitizer), but took three times as long and accepted a different
// set; it inflates by zlib instead of libdeflate, and the limits below would be needed all the
// same.
#include "mesh/read/zip_file.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>

#include "base/text.h"
#include "mesh/read/beside_files.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// The text of meshes compresses to a tenth, blanks or a repeated vertex to a hundredth; a large
/// entry beyond this ratio was made to exhaust the reader's memory.
constexpr uint64_t kTightest = 200;
constexpr uint64_t kLargeEntry = 32'000'000;
/// Beyond any file: keeps sums of false sizes from overflowing.
constexpr uint64_t kLargest = uint64_t{1} << 46;
constexpr size_t kEndSize = 22;  ///< end of central directory, without its comment
constexpr size_t kLongestComment = 65535;
constexpr size_t kCentralSize = 46;
constexpr size_t kLocalSize = 30;

static_assert(std::endian::native == std::endian::little, "ZIP is read as it lies in memory");

/// Reads a number at an offset; 0 past the end.
template <typename T>
T number_at(std::string_view bytes, uint64_t at) {
    T value = 0;
    if (at <= bytes.size() && bytes.size() - at >= sizeof value)
        std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::optional<uint64_t> find_end(std::string_view bytes) {
    if (bytes.size() < kEndSize) return {};
    const size_t least = bytes.size() - std::min(bytes.size(), kEndSize + kLongestComment);
    for (size_t at = bytes.size() - kEndSize + 1; at-- > least;) {
        if (number_at<uint32_t>(bytes, at) == 0x06054b50) return at;
    }
    return {};
}

/// Sizes and offset that do not fit 32 bits are in an extra field, in this order.
void read_zip64(std::string_view extra, uint64_t* size, uint64_t* compressed, uint64_t* offset) {
    while (extra.size() >= 4) {
        const auto kind = number_at<uint16_t>(extra, 0);
        const size_t length = std::min<size_t>(number_at<uint16_t>(extra, 2), extra.size() - 4);
        if (kind == 1) {
            const std::string_view field = extra.substr(4, length);
            uint64_t at = 0;
            for (uint64_t* value : {size, compressed, offset}) {
                if (*value != 0xffffffff) continue;
                *value = number_at<uint64_t>(field, at);
                at += 8;
            }
        }
        extra.remove_prefix(4 + length);
    }
}

/// Without `.`, `..` and empty names between slashes.
std::string normal(std::string_view path) {
    std::string out;
    while (!path.empty()) {
        const std::string_view name = path.substr(0, path.find_first_of("/\\"));
        path.remove_prefix(std::min(name.size() + 1, path.size()));
        if (name == "..") {
            out.resize(out.find('/') == std::string::npos ? 0 : out.rfind('/'));
        } else if (!name.empty() && name != ".") {
            out += out.empty() ? "" : "/";
            out += name;
        }
    }
    return out;
}

}  // namespace

std::string ZipFile::key(std::string_view name) {
    std::string out = percent_decoded(name);
    for (char& c : out)
        c = c == '\\' ? '/' : lower_ascii(c);
    return out.substr(std::min(out.find_first_not_of('/'), out.size()));
}

std::string ZipFile::file_name(const std::string& path) {
    const std::string name = percent_decoded(path);
    return name.substr(name.find_last_of("/\\") + 1);
}

std::string ZipFile::resolve(const std::string& from, const std::string& name) const {
    std::string path = normal(name);
    const size_t folder = from.rfind('/');
    if (name.starts_with('/') || folder == std::string::npos || has(path)) return path;
    return normal(from.substr(0, folder + 1) + name);
}

Result<ZipFile> ZipFile::open(std::string_view bytes, const std::string& file) {
    ZipFile out;
    out.bytes_ = bytes;
    out.file_ = file;
    const std::optional<uint64_t> end = find_end(bytes);
    if (!end) return user_error(fmt::format(messages::kNotZip, file));
    uint64_t count = number_at<uint16_t>(bytes, *end + 10);
    uint64_t at = number_at<uint32_t>(bytes, *end + 16);
    if ((count == 0xffff || at == 0xffffffff) && *end >= 20 &&
        number_at<uint32_t>(bytes, *end - 20) == 0x07064b50) {
        const auto end64 = number_at<uint64_t>(bytes, *end - 20 + 8);
        count = number_at<uint64_t>(bytes, end64 + 32);
        at = number_at<uint64_t>(bytes, end64 + 48);
    }
    uint64_t packed = 0, unpacked = 0, largest = 0;
    for (uint64_t i = 0; i < count; ++i) {
        if (number_at<uint32_t>(bytes, at) != 0x02014b50 || bytes.size() - at < kCentralSize)
            return user_error(fmt::format(messages::kDirectoryDamaged, file));
        Entry entry;
        entry.encrypted = (number_at<uint16_t>(bytes, at + 8) & 1) != 0;
        entry.method = number_at<uint16_t>(bytes, at + 10);
        entry.checksum = number_at<uint32_t>(bytes, at + 16);
        entry.compressed = number_at<uint32_t>(bytes, at + 20);
        entry.size = number_at<uint32_t>(bytes, at + 24);
        const size_t name = number_at<uint16_t>(bytes, at + 28);
        const size_t extra = number_at<uint16_t>(bytes, at + 30);
        const size_t comment = number_at<uint16_t>(bytes, at + 32);
        entry.offset = number_at<uint32_t>(bytes, at + 42);
        if (bytes.size() - at - kCentralSize < name + extra + comment)
            return user_error(fmt::format(messages::kDirectoryDamaged, file));
        read_zip64(bytes.substr(at + kCentralSize + name, extra), &entry.size, &entry.compressed,
                   &entry.offset);
        // Disjoint entries fill the file at most; otherwise they overlap, and a small file could
        // expand many times.
        if (entry.compressed > bytes.size() - packed)
            return user_error(fmt::format(messages::kEntriesTooLarge, file));
        packed += entry.compressed;
        unpacked += std::min(entry.size, kLargest);
        largest = std::max(largest, std::min(entry.size, kLargest));
        entry.name = std::string(bytes.substr(at + kCentralSize, name));
        out.entries_.emplace(key(entry.name), entry);
        at += kCentralSize + name + extra + comment;
    }
    // A single large entry is reported when it is read; many just below that limit would be as
    // much.
    if (unpacked - largest > kLargeEntry && (unpacked - largest) / kTightest > bytes.size()) {
        return user_error(
            fmt::format(messages::kArchiveUnpacksTooFar, file, unpacked / bytes.size()));
    }
    return out;
}

bool ZipFile::has(const std::string& name) const {
    return entries_.count(key(name)) != 0;
}

std::vector<std::string> ZipFile::names() const {
    std::vector<std::string> names;
    for (const auto& [key, entry] : entries_)
        names.push_back(entry.name);
    return names;
}

Result<std::string> ZipFile::read(const std::string& name, int64_t limit) const {
    const auto error = [&](const std::string& what) {
        return user_error(fmt::format(messages::kEntryWrong, file_, name, what));
    };
    const auto it = entries_.find(key(name));
    if (it == entries_.end()) return error(messages::kEntryMissing);
    const Entry& entry = it->second;
    if (entry.encrypted) return error(messages::kEntryEncrypted);
    if (entry.method != 0 && entry.method != 8)
        return error(fmt::format(messages::kEntryMethod, entry.method));
    const uint64_t start = entry.offset + kLocalSize +
                           number_at<uint16_t>(bytes_, entry.offset + 26) +
                           number_at<uint16_t>(bytes_, entry.offset + 28);
    if (entry.offset >= bytes_.size() || number_at<uint32_t>(bytes_, entry.offset) != 0x04034b50 ||
        start > bytes_.size() || entry.compressed > bytes_.size() - start)
        return error(messages::kEntryCutShort);
    const std::string_view packed = bytes_.substr(start, entry.compressed);
    if (limit < 0 || entry.size > static_cast<uint64_t>(limit)) {
        return error(fmt::format(messages::kEntryTakesTooMuch, entry.size / 1'000'000 + 1,
                                 std::max<int64_t>(limit, 0) / 1'000'000));
    }
    // Deflate's ratio is at most 1032: a larger size is false.
    if (entry.size > packed.size() * 1032 + 64 ||
        (entry.method == 0 && entry.size != packed.size()))
        return error(messages::kEntryTooLarge);
    if (entry.size > kLargeEntry && entry.size / kTightest > packed.size()) {
        return error(fmt::format(messages::kEntryUnpacksTooFar,
                                 entry.size / std::max<size_t>(packed.size(), 1)));
    }
    std::string out(entry.size, '\0');
    if (entry.method == 0) {
        out = packed;
    } else {
        const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
            decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
        if (decompressor == nullptr) return outside_error(messages::kOutOfMemory);
        size_t size = 0;
        if (libdeflate_deflate_decompress(decompressor.get(), packed.data(), packed.size(),
                                          out.data(), out.size(), &size) != LIBDEFLATE_SUCCESS ||
            size != out.size())
            return error(messages::kEntryDamaged);
    }
    if (libdeflate_crc32(0, out.data(), out.size()) != entry.checksum)
        return error(messages::kEntryChecksum);
    return out;
}

}  // namespace openfab::mesh
