// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/pyramid_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>
#include <vector>

#include "base/check.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/replace_file.h"
#include "texture/messages.h"
#include "texture/pyramid.h"

namespace openfab::texture {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is written as it lies in memory");

constexpr char kMagic[8] = {'O', 'F', 'T', 'X', '\r', '\n', '\x1a', '\n'};
constexpr int64_t kAlignment = 64;
constexpr int32_t kDepthOfAlpha = -1;

struct Header {
    char magic[8];
    int32_t version;
    int32_t channels;
    int32_t width;
    int32_t height;
    int32_t levels;
    int32_t depth;
    uint64_t content_key;
    int64_t texels;
    int64_t minmax;
    int64_t file_bytes;
    uint64_t checksum;
};
static_assert(sizeof(Header) == 72);

/// Bytes of the mapping that may be resident before they are released.
constexpr int64_t kMostHeld = 32 << 20;
constexpr size_t kAtOnce = 1 << 20;
/// Bytes that filtering touches per byte that it writes: eight texels of a volume, and that one.
constexpr int64_t kReadForOne = 9;

int64_t aligned(int64_t bytes) {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// Writes the part after the header: the domain of a volume, then the level table as in the info
/// block.
std::vector<int32_t> table_for(const PyramidLayout& layout) {
    const std::vector<int32_t> info = pyramid_info(layout, 0, 0);
    std::vector<int32_t> table(info.begin() + kInfoHeader, info.end());
    if (layout.volume) {
        table.insert(table.begin() + (kVolumeInfoHeader - kInfoHeader),
                     layout.volume->table ? 1 : 0);
    }
    return table;
}

/// Makes the header of a file of this layout.
Header header_for(const PyramidLayout& layout, uint64_t content_key) {
    Header h{};
    std::memcpy(h.magic, kMagic, sizeof kMagic);
    h.version = kFileVersion;
    h.channels = layout.channels;
    h.width = layout.levels[0].width;
    h.height = layout.levels[0].height;
    h.levels = static_cast<int32_t>(layout.levels.size());
    h.depth = layout.volume ? layout.levels[0].depth : layout.alpha ? kDepthOfAlpha : 0;
    h.content_key = content_key;
    h.texels = aligned(static_cast<int64_t>(sizeof(Header) + 4 * table_for(layout).size()));
    h.minmax = h.texels + aligned(layout.texel_floats * 4);
    h.file_bytes = h.minmax + layout.minmax_floats * 4;
    return h;
}

/// The checksum of a file, in blocks of kAtOnce bytes: each block's hash seeds the next. In the
/// first block the header's checksum counts as 0.
class Checksum {
  public:
    void add(const void* data, size_t bytes) {
        const auto* block = static_cast<const uint8_t*>(data);
        if (first_ && bytes >= sizeof(Header)) {
            constexpr size_t kPlace = offsetof(Header, checksum);
            constexpr size_t kBehind = kPlace + sizeof(Header::checksum);
            constexpr uint8_t kZeros[sizeof(Header::checksum)] = {};
            value_ = xxh3({block, kPlace}, value_);
            value_ = xxh3(kZeros, value_);
            block += kBehind;
            bytes -= kBehind;
        }
        first_ = false;
        value_ = xxh3({block, bytes}, value_);
    }
    uint64_t value() const { return value_; }

  private:
    uint64_t value_ = 0;
    bool first_ = true;
};

Error system_trouble(const std::filesystem::path& file) {
    return outside_error(
        fmt::format(messages::kCannotWrite, file.string(), std::generic_category().message(errno)));
}

}  // namespace

int64_t pyramid_file_bytes(const PyramidLayout& layout) {
    return header_for(layout, 0).file_bytes;
}

Result<std::unique_ptr<PyramidWriter>> PyramidWriter::create(const std::filesystem::path& file,
                                                             const PyramidLayout& layout,
                                                             uint64_t content_key) {
    if (const auto replaceable = check_replaceable(file); !replaceable) return replaceable.error();
    std::unique_ptr<PyramidWriter> writer(new PyramidWriter);
    writer->file_ = file;
    writer->layout_ = layout;
    int fd = -1;
    writer->at_end_.emplace([&] {
        fd = open_temporary(file, &writer->temporary_);
        return writer->temporary_;
    });
    writer->descriptor_ = fd;
    if (fd < 0) return system_trouble(file);
    const Header header = header_for(layout, content_key);
    // Allocates the space now: a full disk is an error here instead of a signal while the mapping
    // is written.
    const int trouble = ::posix_fallocate(fd, 0, header.file_bytes);
    // Temporary files are private to their owner; this one may be in a folder that others read.
    (void)::fchmod(fd, 0644);
    void* mapping = MAP_FAILED;
    if (trouble == 0) {
        mapping = ::mmap(nullptr, static_cast<size_t>(header.file_bytes), PROT_READ | PROT_WRITE,
                         MAP_SHARED, fd, 0);
    } else {
        errno = trouble;
    }
    if (mapping == MAP_FAILED) return system_trouble(file);
    writer->mapping_ = mapping;
    writer->bytes_ = static_cast<size_t>(header.file_bytes);
    auto* bytes = static_cast<std::byte*>(mapping);
    std::memcpy(bytes, &header, sizeof header);
    const std::vector<int32_t> table = table_for(layout);
    std::memcpy(bytes + sizeof header, table.data(), table.size() * sizeof(int32_t));
    writer->texels_ = reinterpret_cast<float*>(bytes + header.texels);
    writer->minmax_ = reinterpret_cast<float*>(bytes + header.minmax);
    return writer;
}

PyramidWriter::~PyramidWriter() {
    if (mapping_ != nullptr) ::munmap(mapping_, bytes_);
    if (descriptor_ >= 0 && !temporary_.empty()) ::unlink(temporary_.c_str());
    if (descriptor_ >= 0) ::close(descriptor_);
}

void PyramidWriter::wrote(int64_t bytes) {
    held_bytes_ += bytes;
    if (held_bytes_ < kMostHeld) return;
    // A shared mapping loses no data, which are in the file. A failure only costs memory.
    (void)::madvise(mapping_, bytes_, MADV_DONTNEED);
    held_bytes_ = 0;
}

Result<void> PyramidWriter::finish() {
    OPENFAB_CHECK(!temporary_.empty());  // once
    fill_pyramid(layout_, texels_, minmax_, [&](int64_t bytes) { wrote(kReadForOne * bytes); });
    Checksum checksum;
    const auto* start = static_cast<const std::byte*>(mapping_);
    for (size_t at = 0; at < bytes_; at += kAtOnce) {
        const size_t bytes = std::min(kAtOnce, bytes_ - at);
        checksum.add(start + at, bytes);
        wrote(static_cast<int64_t>(bytes));
    }
    const uint64_t value = checksum.value();
    std::memcpy(static_cast<std::byte*>(mapping_) + offsetof(Header, checksum), &value,
                sizeof value);
    if (::rename(temporary_.c_str(), file_.c_str()) != 0) return system_trouble(file_);
    at_end_.reset();
    temporary_.clear();
    return Ok{};
}

Result<void> check_pyramid_file(const InputFile& file) {
    std::vector<char> buffer(kAtOnce);
    Checksum checksum;
    Header header{};
    for (int64_t at = 0;;) {
        const Result<size_t> got = file.read(at, buffer.data(), buffer.size());
        if (!got) return with_context(got.error(), messages::kCannotBeRead);
        if (*got == 0 && at > 0) break;
        if (at == 0) {
            if (*got < sizeof header) return user_error(messages::kPyramidTooShort);
            std::memcpy(&header, buffer.data(), sizeof header);
        }
        checksum.add(buffer.data(), *got);
        at += static_cast<int64_t>(*got);
    }
    if (checksum.value() != header.checksum) return user_error(messages::kChecksumWrong);
    return Ok{};
}

namespace {

/// Computes the layout from the header; `table` is what follows it.
Result<PyramidLayout> layout_of(const Header& h, const std::byte* table, size_t bytes) {
    if (h.depth == 0) return pyramid_layout(h.width, h.height, h.channels);
    if (h.depth == kDepthOfAlpha) {
        if (h.channels < 2) return user_error(messages::kAlphaAlone);
        Result<PyramidLayout> picture = pyramid_layout(h.width, h.height, h.channels);
        if (picture) picture->alpha = true;
        return picture;
    }
    int32_t words[7];
    if (bytes < sizeof words) return user_error(messages::kTooShort);
    std::memcpy(words, table, sizeof words);
    VolumeDomain domain;
    for (size_t a = 0; a < 3; ++a) {
        domain.origin[a] = std::bit_cast<float>(words[a]);
        domain.extent[a] = std::bit_cast<float>(words[3 + a]);
    }
    domain.table = words[6] != 0;
    return volume_layout({h.width, h.height, h.depth}, h.channels, domain);
}

}  // namespace

Result<PyramidView> parse_pyramid_file(const void* data, size_t bytes) {
    Header h;
    if (bytes < sizeof h) return user_error(messages::kPyramidTooShort);
    std::memcpy(&h, data, sizeof h);
    if (std::memcmp(h.magic, kMagic, sizeof kMagic) != 0) return user_error(messages::kNotPyramid);
    if (h.version != kFileVersion) {
        return user_error(fmt::format(messages::kPyramidVersion, h.version),
                          fmt::format(messages::kPyramidVersionHelp, kFileVersion));
    }
    const auto* start = static_cast<const std::byte*>(data);
    Result<PyramidLayout> layout = layout_of(h, start + sizeof h, bytes - sizeof h);
    if (!layout) return with_context(layout.error(), messages::kIsDamaged);
    Header expected = header_for(*layout, h.content_key);
    expected.checksum = h.checksum;
    if (std::memcmp(&h, &expected, sizeof h) != 0)
        return user_error(messages::kHeaderContradictory);
    if (static_cast<uint64_t>(h.file_bytes) != bytes) {
        return user_error(fmt::format(messages::kFileCutShort, bytes, h.file_bytes));
    }
    const std::vector<int32_t> table = table_for(*layout);
    if (std::memcmp(start + sizeof h, table.data(), table.size() * sizeof(int32_t)) != 0) {
        return user_error(messages::kLevelTableContradictory);
    }
    PyramidView view;
    view.layout = std::move(*layout);
    view.content_key = h.content_key;
    view.texels = reinterpret_cast<const float*>(start + h.texels);
    view.minmax = reinterpret_cast<const float*>(start + h.minmax);
    return view;
}

}  // namespace openfab::texture
