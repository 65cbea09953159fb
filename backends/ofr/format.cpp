// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/format.h"

#include <fmt/format.h>

#include <algorithm>

#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "backends/common/tee_sink.h"
#include "backends/ofr/messages.h"
#include "base/hash.h"

namespace openfab::ofr {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

namespace {

class Writer {
  public:
    template <typename T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto* bytes = reinterpret_cast<const uint8_t*>(&value);
        bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
    }
    void put(const Vec3d& v) { put(v.x), put(v.y), put(v.z); }
    void put(const Vec3i& v) { put(v.x), put(v.y), put(v.z); }
    void put(const std::string& text) {
        put(static_cast<uint32_t>(text.size()));
        bytes_.insert(bytes_.end(), text.begin(), text.end());
    }
    /// Sets the u32 at `at`.
    void patch(size_t at, uint32_t value) {
        std::memcpy(bytes_.data() + at, &value, sizeof(value));
    }
    size_t size() const { return bytes_.size(); }
    std::vector<uint8_t>& bytes() { return bytes_; }

  private:
    std::vector<uint8_t> bytes_;
};

/// Reads fields; after the first one that is not there everything reads as zero and ok() is false.
class Reader {
  public:
    explicit Reader(std::span<const uint8_t> bytes) : rest_(bytes) {}

    template <typename T>
    T get() {
        T value{};
        if (rest_.size() < sizeof(T)) {
            fail();
            return value;
        }
        std::memcpy(&value, rest_.data(), sizeof(T));
        rest_ = rest_.subspan(sizeof(T));
        return value;
    }
    Vec3d get_vec3d() {
        Vec3d v;
        for (int a = 0; a < 3; ++a)
            v[a] = get<double>();
        return v;
    }
    Vec3i get_vec3i() {
        Vec3i v;
        for (int a = 0; a < 3; ++a)
            v[a] = get<int32_t>();
        return v;
    }
    std::string get_string() {
        const auto n = get<uint32_t>();
        if (n > rest_.size()) {
            fail();
            return {};
        }
        std::string text(reinterpret_cast<const char*>(rest_.data()), n);
        rest_ = rest_.subspan(n);
        return text;
    }
    bool ok() const { return ok_; }
    /// Returns whether everything was read and nothing is left.
    bool done() const { return ok_ && rest_.empty(); }
    size_t left() const { return rest_.size(); }

  private:
    void fail() {
        ok_ = false;
        rest_ = {};
    }
    std::span<const uint8_t> rest_;
    bool ok_ = true;
};

Result<void> check_info(const pipeline::PrintInfo& info) {
    for (int a = 0; a < 3; ++a) {
        if (info.size[a] < 1 || info.size[a] > kMaxSide) {
            return user_error(
                fmt::format(messages::kBadGrid, info.size.x, info.size.y, info.size.z));
        }
        if (!(info.pitch_mm[a] > 0) || !std::isfinite(info.pitch_mm[a]) ||
            !std::isfinite(info.origin_mm[a])) {
            return user_error(messages::kBadPitch);
        }
    }
    if (info.bits != 4 && info.bits != 8) {
        return user_error(fmt::format(messages::kBadBits, info.bits));
    }
    if (info.slice_begin < 0 || info.slice_begin > info.slice_end || info.slice_end > info.size.z) {
        return user_error(
            fmt::format(messages::kBadSlices, info.slice_begin, info.slice_end, info.size.z));
    }
    const uint64_t slice_bytes =
        static_cast<uint64_t>(info.size.y) * backends::packed_row_bytes(info.size.x, info.bits);
    if (slice_bytes > kMaxSliceBytes) {
        return user_error(fmt::format(messages::kSlicesTooLarge, slice_bytes, kMaxSliceBytes));
    }
    return {};
}

constexpr size_t kChecksumBytes = 8;

/// Returns whether the last bytes are the checksum of those before.
bool ends_with_checksum(std::span<const uint8_t> bytes) {
    const std::span<const uint8_t> all = bytes.first(bytes.size() - kChecksumBytes);
    uint64_t sum = 0;
    std::memcpy(&sum, bytes.data() + all.size(), sizeof sum);
    return sum == checksum(all);
}

Result<pipeline::PrintInfo> read_header_fields(std::span<const uint8_t> fields, uint32_t version) {
    Reader in(fields);
    pipeline::PrintInfo info;
    info.size = in.get_vec3i();
    info.slice_begin = in.get<int32_t>();
    info.slice_end = in.get<int32_t>();
    info.bits = in.get<int32_t>();
    info.pitch_mm = in.get_vec3d();
    info.origin_mm = in.get_vec3d();
    info.seed = in.get<uint64_t>();
    info.printer = in.get_string();
    info.title = in.get_string();
    const auto materials = in.get<uint32_t>();
    if (in.ok() && materials > (info.bits == 4 ? 15U : 254U)) {  // 255 marks mixtures
        return user_error(fmt::format(messages::kBadMaterials, materials, info.bits));
    }
    for (uint32_t i = 0; i < materials && in.ok(); ++i) {
        pipeline::SliceMaterial material;
        material.name = in.get_string();
        material.key = in.get<std::array<uint8_t, 4>>();
        material.preview = in.get<std::array<uint8_t, 4>>();
        material.density_g_cm3 = in.get<double>();
        material.channel = in.get_string();
        info.materials.push_back(std::move(material));
    }
    const uint32_t settings = version >= 2 ? in.get<uint32_t>() : 0;
    for (uint32_t i = 0; i < settings && in.ok(); ++i) {
        std::string name = in.get_string();
        info.provenance.emplace_back(std::move(name), in.get_string());
    }
    if (!in.done()) return user_error(messages::kHeaderFieldsDiffer);
    if (Result<void> checked = check_info(info); !checked) return checked.error();
    return info;
}

Result<Index> read_index_fields(std::span<const uint8_t> fields) {
    Reader in(fields);
    Index index;
    const auto slices = in.get<uint32_t>();
    for (uint32_t i = 0; i < slices && in.ok(); ++i) {
        IndexEntry entry;
        entry.z = in.get<int32_t>();
        entry.offset = in.get<uint64_t>();
        index.slices.push_back(entry);
    }
    index.totals.complete = true;
    index.totals.voxels_solid = in.get<int64_t>();
    const auto codes = in.get<uint32_t>();
    for (uint32_t i = 0; i < codes && in.ok(); ++i) {
        index.totals.voxels_by_code.push_back(in.get<int64_t>());
    }
    index.totals.hash = in.get<uint64_t>();
    index.totals.tight.lo = in.get_vec3i();
    index.totals.tight.hi = in.get_vec3i();
    if (!in.done()) return user_error(messages::kIndexFieldsDiffer);
    return index;
}

}  // namespace

uint64_t checksum(std::span<const uint8_t> bytes) {
    return xxh3(bytes, 0);
}

std::vector<uint8_t> write_header(const pipeline::PrintInfo& info) {
    Writer out;
    out.put(kMagic);
    out.put(kVersion);
    out.put(uint32_t{0});
    out.put(info.size);
    out.put(info.slice_begin);
    out.put(info.slice_end);
    out.put(info.bits);
    out.put(info.pitch_mm);
    out.put(info.origin_mm);
    out.put(info.seed);
    out.put(info.printer);
    out.put(info.title);
    out.put(static_cast<uint32_t>(info.materials.size()));
    for (const pipeline::SliceMaterial& material : info.materials) {
        out.put(material.name);
        out.put(material.key);
        out.put(material.preview);
        out.put(material.density_g_cm3);
        out.put(material.channel);
    }
    out.put(static_cast<uint32_t>(info.provenance.size()));
    for (const auto& [name, value] : info.provenance) {
        out.put(name);
        out.put(value);
    }
    out.patch(kPreambleBytes - 4, static_cast<uint32_t>(out.size() - kPreambleBytes));
    out.put(checksum(out.bytes()));
    return std::move(out.bytes());
}

Result<size_t> header_bytes_left(std::span<const uint8_t> preamble) {
    Reader in(preamble);
    const auto magic = in.get<std::array<uint8_t, 8>>();
    const auto version = in.get<uint32_t>();
    const auto field_bytes = in.get<uint32_t>();
    if (magic != kMagic) return user_error(messages::kNotOfr);
    if (version < kOldestVersion || version > kVersion)
        return user_error(fmt::format(messages::kOtherVersion, version, kOldestVersion, kVersion));
    if (!in.done() || field_bytes > kMaxHeaderBytes) return user_error(messages::kImpossibleLength);
    return field_bytes + kChecksumBytes;
}

Result<pipeline::PrintInfo> read_header(std::span<const uint8_t> bytes) {
    if (bytes.size() < kPreambleBytes) return user_error(messages::kTooShort);
    const Result<size_t> left = header_bytes_left(bytes.first(kPreambleBytes));
    if (!left) return left.error();
    if (bytes.size() != kPreambleBytes + *left) return user_error(messages::kCutShortInHeader);
    if (!ends_with_checksum(bytes)) return user_error(messages::kHeaderChecksum);
    uint32_t version = 0;
    std::memcpy(&version, bytes.data() + kMagic.size(), sizeof version);
    return read_header_fields(bytes.subspan(kPreambleBytes, *left - kChecksumBytes), version);
}

std::array<uint8_t, kSliceHeadBytes> write_slice_head(const SliceHead& head) {
    Writer out;
    out.put(kSliceMagic);
    out.put(head.z);
    out.put(head.frame_bytes);
    out.put(uint32_t{0});
    out.put(head.rows_checksum);
    out.put(checksum(out.bytes()));
    std::array<uint8_t, kSliceHeadBytes> bytes{};
    std::memcpy(bytes.data(), out.bytes().data(), kSliceHeadBytes);
    return bytes;
}

Result<SliceHead> read_slice_head(std::span<const uint8_t> bytes) {
    Reader in(bytes);
    SliceHead head;
    const auto magic = in.get<uint32_t>();
    head.z = in.get<int32_t>();
    head.frame_bytes = in.get<uint32_t>();
    const auto reserved = in.get<uint32_t>();
    head.rows_checksum = in.get<uint64_t>();
    const auto sum = in.get<uint64_t>();
    if (!in.done() || magic != kSliceMagic || reserved != 0 ||
        sum != checksum(bytes.first(kSliceHeadBytes - 8))) {
        return user_error(messages::kSliceHeaderDamaged);
    }
    return head;
}

std::vector<uint8_t> write_index(const Index& index, uint64_t offset) {
    const pipeline::PrintTotals& totals = index.totals;
    Writer out;
    out.put(kIndexMagic);
    out.put(uint32_t{0});
    out.put(static_cast<uint32_t>(index.slices.size()));
    for (const IndexEntry& entry : index.slices) {
        out.put(entry.z);
        out.put(entry.offset);
    }
    out.put(totals.voxels_solid);
    out.put(static_cast<uint32_t>(totals.voxels_by_code.size()));
    for (int64_t voxels : totals.voxels_by_code)
        out.put(voxels);
    out.put(totals.hash);
    out.put(totals.tight.lo);
    out.put(totals.tight.hi);
    out.patch(4, static_cast<uint32_t>(out.size() - 8));
    out.put(checksum(out.bytes()));
    out.put(offset);
    out.put(kEndMagic);
    return std::move(out.bytes());
}

Result<Index> read_index(std::span<const uint8_t> bytes) {
    if (bytes.size() < kIndexHeadBytes) return user_error(messages::kIndexTooShort);
    Reader in(bytes.first(kIndexHeadBytes));
    const auto magic = in.get<uint32_t>();
    const auto field_bytes = in.get<uint32_t>();
    const size_t all = kIndexHeadBytes + field_bytes + kChecksumBytes;
    if (bytes.size() < all) return user_error(messages::kIndexTooShort);
    if (magic != kIndexMagic || !ends_with_checksum(bytes.first(all)))
        return user_error(messages::kIndexChecksum);
    return read_index_fields(bytes.subspan(kIndexHeadBytes, field_bytes));
}

}  // namespace openfab::ofr
