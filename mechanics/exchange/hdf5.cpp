// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/exchange/hdf5.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

namespace openfab::mechanics {

namespace {

constexpr uint64_t kNowhere = ~uint64_t{0};
constexpr size_t kSuperblockBytes = 48;

/// Little-endian bytes in order.
class ByteText {
  public:
    template <typename T>
    ByteText& put(T value) {
        static_assert(std::is_unsigned_v<T>);
        for (size_t i = 0; i < sizeof(T); ++i)
            bytes_.push_back(static_cast<uint8_t>(value >> (8 * i)));
        return *this;
    }
    ByteText& put(const std::string& text) {
        bytes_.insert(bytes_.end(), text.begin(), text.end());
        return *this;
    }
    ByteText& put(const std::vector<uint8_t>& bytes) {
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        return *this;
    }
    const std::vector<uint8_t>& bytes() const { return bytes_; }

  private:
    std::vector<uint8_t> bytes_;
};

enum MessageType : uint8_t {
    kDataspace = 1,
    kLinkInfo = 2,
    kDatatype = 3,
    kFillValue = 5,
    kLink = 6,
    kLayout = 8,
    kGroupInfo = 10,
};

/// An object header of version 2.
class ObjectHeader {
  public:
    void add(MessageType type, const ByteText& data) {
        messages_.put(uint8_t{type})
            .put(static_cast<uint16_t>(data.bytes().size()))
            .put(uint8_t{0})
            .put(data.bytes());
    }
    std::vector<uint8_t> bytes() const {
        constexpr uint8_t kVersion = 2, kSizeOfFourBytes = 2;
        ByteText out;
        out.put(std::string("OHDR")).put(kVersion).put(kSizeOfFourBytes);
        out.put(static_cast<uint32_t>(messages_.bytes().size())).put(messages_.bytes());
        out.put(lookup3(out.bytes()));
        return out.bytes();
    }

  private:
    ByteText messages_;
};

uint64_t size_of(Hdf5Type type) {
    switch (type) {
        case Hdf5Type::kUint8:
            return 1;
        case Hdf5Type::kFloat32:
            return 4;
        case Hdf5Type::kInt64:
        case Hdf5Type::kFloat64:
            return 8;
    }
    return 1;
}

ByteText datatype(Hdf5Type type) {
    constexpr uint8_t kVersion1 = 0x10, kInteger = 0, kFloat = 1;
    const auto bits = static_cast<uint16_t>(8 * size_of(type));
    ByteText out;
    if (type == Hdf5Type::kUint8 || type == Hdf5Type::kInt64) {
        constexpr uint8_t kSigned = 8;
        out.put(static_cast<uint8_t>(kVersion1 | kInteger));
        out.put(type == Hdf5Type::kInt64 ? kSigned : uint8_t{0}).put(uint16_t{0});
        out.put(static_cast<uint32_t>(size_of(type))).put(uint16_t{0}).put(bits);
        return out;
    }
    // The mantissa's first bit is not stored; where the sign, the exponent and the mantissa are.
    constexpr uint8_t kImplied = 0x20;
    const bool wide = type == Hdf5Type::kFloat64;
    out.put(static_cast<uint8_t>(kVersion1 | kFloat)).put(kImplied);
    out.put(static_cast<uint8_t>(bits - 1)).put(uint8_t{0});
    out.put(static_cast<uint32_t>(size_of(type))).put(uint16_t{0}).put(bits);
    out.put(wide ? uint8_t{52} : uint8_t{23}).put(wide ? uint8_t{11} : uint8_t{8});
    out.put(uint8_t{0}).put(wide ? uint8_t{52} : uint8_t{23});
    out.put(wide ? uint32_t{1023} : uint32_t{127});
    return out;
}

std::vector<uint8_t> array_header(const Hdf5Array& array, uint64_t address) {
    ObjectHeader out;
    constexpr uint8_t kVersion = 2, kSimple = 1;
    ByteText space;
    space.put(kVersion).put(static_cast<uint8_t>(array.shape.size())).put(uint8_t{0}).put(kSimple);
    for (const uint64_t n : array.shape)
        space.put(n);
    out.add(kDataspace, space);
    out.add(kDatatype, datatype(array.type));
    // Version 3; allocated late, written if it is set, and it is not.
    out.add(kFillValue, ByteText().put(uint8_t{3}).put(uint8_t{10}));
    constexpr uint8_t kLayoutVersion = 3, kContiguous = 1;
    out.add(kLayout,
            ByteText().put(kLayoutVersion).put(kContiguous).put(address).put(array.bytes()));
    return out.bytes();
}

std::vector<uint8_t> group_header(const std::vector<Hdf5Array>& arrays,
                                  const std::vector<uint64_t>& addresses) {
    ObjectHeader out;
    out.add(kLinkInfo, ByteText().put(uint8_t{0}).put(uint8_t{0}).put(kNowhere).put(kNowhere));
    out.add(kGroupInfo, ByteText().put(uint8_t{0}).put(uint8_t{0}));
    for (size_t i = 0; i < arrays.size(); ++i) {
        constexpr uint8_t kVersion = 1, kNamesItsCharacters = 0x10, kLongName = 1, kUtf8 = 1;
        out.add(kLink, ByteText()
                           .put(kVersion)
                           .put(static_cast<uint8_t>(kNamesItsCharacters | kLongName))
                           .put(kUtf8)
                           .put(static_cast<uint16_t>(arrays[i].name.size()))
                           .put(arrays[i].name)
                           .put(addresses[i]));
    }
    return out.bytes();
}

}  // namespace

uint64_t Hdf5Array::bytes() const {
    uint64_t out = size_of(type);
    for (const uint64_t n : shape)
        out *= n;
    return out;
}

uint32_t lookup3(std::span<const uint8_t> bytes) {
    uint32_t a = 0xdeadbeefU + static_cast<uint32_t>(bytes.size()), b = a, c = a;
    const auto word = [&](size_t at) {
        uint32_t out = 0;
        for (size_t i = 0; i < 4 && at + i < bytes.size(); ++i)
            out |= static_cast<uint32_t>(bytes[at + i]) << (8 * i);
        return out;
    };
    size_t at = 0;
    for (; bytes.size() - at > 12; at += 12) {
        a += word(at);
        b += word(at + 4);
        c += word(at + 8);
        a = (a - c) ^ std::rotl(c, 4), c += b;
        b = (b - a) ^ std::rotl(a, 6), a += c;
        c = (c - b) ^ std::rotl(b, 8), b += a;
        a = (a - c) ^ std::rotl(c, 16), c += b;
        b = (b - a) ^ std::rotl(a, 19), a += c;
        c = (c - b) ^ std::rotl(b, 4), b += a;
    }
    if (at == bytes.size()) return c;
    a += word(at);
    b += word(at + 4);
    c += word(at + 8);
    c = (c ^ b) - std::rotl(b, 14);
    a = (a ^ c) - std::rotl(c, 11);
    b = (b ^ a) - std::rotl(a, 25);
    c = (c ^ b) - std::rotl(b, 16);
    a = (a ^ c) - std::rotl(c, 4);
    b = (b ^ a) - std::rotl(a, 14);
    return (c ^ b) - std::rotl(b, 24);
}

Result<void> write_hdf5(const std::filesystem::path& path, const std::vector<Hdf5Array>& arrays) {
    Result<std::unique_ptr<TextFile>> opened = TextFile::create(path);
    if (!opened) return opened.error();
    TextFile* out = opened->get();
    // Heads first, whose sizes do not depend on the addresses in them, then arrays at multiples of 8.
    std::vector<uint64_t> heads(arrays.size()), begins(arrays.size());
    uint64_t at = kSuperblockBytes + group_header(arrays, heads).size();
    for (size_t i = 0; i < arrays.size(); ++i) {
        heads[i] = at;
        at += array_header(arrays[i], 0).size();
    }
    const auto aligned = [](uint64_t n) { return (n + 7) / 8 * 8; };
    for (size_t i = 0; i < arrays.size(); ++i) {
        at = begins[i] = aligned(at);
        at += arrays[i].bytes();
    }
    ByteText superblock;
    constexpr uint8_t kVersion = 2, kAddressBytes = 8;
    superblock.put(std::string("\x89HDF\r\n\x1a\n")).put(kVersion);
    superblock.put(kAddressBytes).put(kAddressBytes).put(uint8_t{0});
    superblock.put(uint64_t{0}).put(kNowhere).put(at).put(uint64_t{kSuperblockBytes});
    superblock.put(lookup3(superblock.bytes()));
    out->put_bytes(superblock.bytes());
    out->put_bytes(group_header(arrays, heads));
    for (size_t i = 0; i < arrays.size(); ++i)
        out->put_bytes(array_header(arrays[i], begins[i]));
    for (size_t i = 0; i < arrays.size(); ++i) {
        out->put(std::string(begins[i] - static_cast<uint64_t>(out->written()), '\0'));
        arrays[i].put(out);
    }
    return out->keep();
}

}  // namespace openfab::mechanics
