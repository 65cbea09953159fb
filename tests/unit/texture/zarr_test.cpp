// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Stores of Zarr, written here byte by byte: what zarr-python writes is read in tests/python/test_zarr_textures.py.
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

#include "base/crc32c.h"
#include "base/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/volume_files.h"
#include "texture/messages.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;
namespace core = texture::messages;
using testing::Says;
using Encode = std::function<std::string(const std::string&)>;

constexpr int kZ = 3, kY = 5, kX = 4;  ///< of all volumes here
constexpr int kSide = 2;               ///< of their chunks

uint16_t value_at(int z, int y, int x) {
    return static_cast<uint16_t>(1000 * z + 100 * y + 10 * x + 1);
}

std::string number(uint64_t value, size_t bytes, bool big = false) {
    std::string out;
    for (size_t b = 0; b < bytes; ++b)
        out += static_cast<char>(value >> 8 * (big ? bytes - 1 - b : b) & 0xff);
    return out;
}

/// A chunk of 2 x 2 x 2; beyond the volume are other numbers.
std::string chunk_of(int z, int y, int x, bool big = false, bool x_slowest = false) {
    std::string out;
    for (int i = 0; i < 8; ++i) {
        const int slow = i / 4, middle = i / 2 % 2, fast = i % 2;
        const int dz = x_slowest ? fast : slow, dx = x_slowest ? slow : fast;
        const int at[] = {2 * z + dz, 2 * y + middle, 2 * x + dx};
        const bool inside = at[0] < kZ && at[1] < kY && at[2] < kX;
        out += number(inside ? value_at(at[0], at[1], at[2]) : 0xbad, 2, big);
    }
    return out;
}

std::string crc(const std::string& bytes) {
    return number(crc32c({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}), 4);
}

std::string deflated(const std::string& bytes, int window) {
    z_stream state{};
    deflateInit2(&state, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
    std::string out(1000, '\0');
    state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    state.avail_in = static_cast<uInt>(bytes.size());
    state.next_out = reinterpret_cast<Bytef*>(out.data());
    state.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&state, Z_FINISH), Z_STREAM_END);
    out.resize(state.total_out);
    deflateEnd(&state);
    return out;
}

std::string zstd(const std::string& bytes) {
    std::string out(1000, '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
    return out;
}

/// A header of Blosc 1 in front of bytes that it did not compress.
std::string blosc(const std::string& bytes) {
    const auto n = static_cast<uint32_t>(bytes.size());
    return std::string("\x02\x01\x02\x01", 4) + number(n, 4) + number(n, 4) + number(n + 16, 4) +
           bytes;
}

const std::string kBytes = R"({"name": "bytes", "configuration": {"endian": "little"}})";

class ZarrTest : public VolumeTest {
  protected:
    fs::path store() const { return folder_.path() / "s.zarr"; }
    void write(const std::string& name, const std::string& bytes) {
        fs::create_directories((store() / name).parent_path());
        folder_.write("s.zarr/" + name, bytes);
    }
    /// Metadata of version 3 of an array with chunks of 2 x 2 x 2.
    static std::string array3(const std::string& codecs = kBytes,
                              const std::string& chunk = "[2, 2, 2]",
                              const std::string& shape = "[3, 5, 4]",
                              const std::string& more = "") {
        return R"({"zarr_format": 3, "node_type": "array", "shape": )" + shape +
               R"(, "data_type": "uint16", "fill_value": 7,
"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": )" +
               chunk + R"(}},
"chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
)" + more + R"("codecs": [)" +
               codecs + "]}";
    }
    static std::string array2(const std::string& compressor, const std::string& dtype = "<u2",
                              const std::string& order = "C", const std::string& more = "") {
        return R"({"zarr_format": 2, "shape": [3, 5, 4], "chunks": [2, 2, 2], "dtype": ")" + dtype +
               R"(", "order": ")" + order + R"(", "fill_value": 7, "compressor": )" + compressor +
               more + R"(, "filters": null})";
    }
    /// Writes all chunks; `separator` as the names of files have it.
    void chunks(const std::string& begin, const std::string& separator, const Encode& encode = {},
                bool big = false, bool x_slowest = false) {
        for (int z = 0; z < 2; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x) {
                    const std::string bytes = chunk_of(z, y, x, big, x_slowest);
                    write(fmt::format("{}{}{}{}{}{}", begin, z, separator, y, separator, x),
                          encode ? encode(bytes) : bytes);
                }
    }
    void expect_volume(const VolumeOptions& options = {}, uint16_t missing = 0) {
        const auto p = converted(store(), options);
        ASSERT_NE(p, nullptr);
        ASSERT_EQ(size(*p), (Vec3i{kX, kY, kZ}));
        const std::vector<float> got = level0(*p);
        for (int z = 0; z < kZ; ++z)
            for (int y = 0; y < kY; ++y)
                for (int x = 0; x < kX; ++x) {
                    const bool gone = missing != 0 && z < 2 && y < 2 && x < 2;
                    const float wanted =
                        static_cast<float>(gone ? missing : value_at(z, y, x)) / 65535;
                    EXPECT_EQ(got[static_cast<size_t>((z * kY + y) * kX + x)], wanted)
                        << z << ' ' << y << ' ' << x;
                }
    }
};

TEST_F(ZarrTest, Version3IsReadAsItWasWritten) {
    write("zarr.json", array3());
    chunks("c/", "/");
    expect_volume();
    fs::remove(store() / "c/0/0/0");
    expect_volume({}, 7);
    const std::array<std::pair<std::string, Encode>, 4> packed = {{
        {R"({"name": "zstd"})", zstd},
        {R"({"name": "gzip"})", [](const std::string& b) { return deflated(b, 31); }},
        {R"({"name": "crc32c"})", [](const std::string& b) { return b + crc(b); }},
        {R"({"name": "numcodecs.zlib"}, {"name": "zstd"}, "crc32c")",
         [](const std::string& b) {
             const std::string inner = zstd(deflated(b, 15));
             return inner + crc(inner);
         }},
    }};
    for (const auto& [codec, encode] : packed) {
        SCOPED_TRACE(codec);
        write("zarr.json", array3(kBytes + ", " + codec));
        chunks("c/", "/", encode);
        expect_volume();
    }
    write("zarr.json", array3(R"({"name": "transpose", "configuration": {"order": [2, 1, 0]}},
        {"name": "bytes", "configuration": {"endian": "big"}})"));
    chunks("c/", "/", {}, true, true);
    expect_volume();
}

TEST_F(ZarrTest, Version2IsReadAsItWasWritten) {
    write(".zarray", array2("null"));
    chunks("", ".");
    expect_volume();
    write(".zarray", array2("null", ">u2", "F", R"(, "dimension_separator": "/")"));
    chunks("", "/", {}, true, true);
    expect_volume();
    write(".zarray", array2(R"({"id": "zlib", "level": 1})"));
    chunks("", ".", [](const std::string& b) { return deflated(b, 15); });
    expect_volume();
    write(".zarray", array2(R"({"id": "gzip", "level": 1})"));
    chunks("", ".", [](const std::string& b) { return deflated(b, 31); });
    expect_volume();
    fs::remove(store() / "0.0.0");
    expect_volume({}, 7);
}

TEST_F(ZarrTest, BloscIsReadOrRefusedByName) {
    write(".zarray", array2(R"({"id": "blosc", "cname": "lz4"})"));
    chunks("", ".", blosc);
    const std::string why = trouble(store());
    if (why != "no error") {
        EXPECT_THAT(why, Says(messages::kZarrNoBlosc));
        return;
    }
    expect_volume();
    write("0.0.1", blosc(chunk_of(0, 0, 1)).substr(0, 20));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChunkDamaged, "blosc"));
}

/// A shard of 2 x 6 x 4 with its six chunks, `skipped` of which is not there.
std::string shard_of(int z, bool index_first, int skipped = -1, uint64_t shift = 0) {
    const size_t index_bytes = 6 * 16 + 4;
    std::string data, index;
    for (int c = 0; c < 6; ++c) {
        if (c == skipped) {
            index += std::string(16, '\xff');
            continue;
        }
        const std::string chunk = zstd(chunk_of(z, c / 2, c % 2));
        index += number(data.size() + (index_first ? index_bytes : 0) + shift, 8) +
                 number(chunk.size(), 8);
        data += chunk;
    }
    index += crc(index);
    return index_first ? index + data : data + index;
}

std::string sharding(const std::string& place, const std::string& chunk = "[2, 2, 2]") {
    return R"({"name": "sharding_indexed", "configuration": {"chunk_shape": )" + chunk +
           R"(, "codecs": [)" + kBytes +
           R"(, {"name": "zstd"}], "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}],
"index_location": ")" +
           place + R"("}})";
}

TEST_F(ZarrTest, ShardsAreReadByTheirIndex) {
    for (const bool first : {false, true}) {
        write("zarr.json", array3(sharding(first ? "start" : "end"), "[2, 6, 4]"));
        write("c/0/0/0", shard_of(0, first));
        write("c/1/0/0", shard_of(1, first));
        expect_volume();
        write("c/0/0/0", shard_of(0, first, 0));
        expect_volume({}, 7);
    }
    // An index that lies: beyond the file, into itself, of other bytes, with a wrong sum.
    const std::string good = shard_of(0, true);
    write("c/0/0/0", shard_of(0, true, -1, 1000));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrIndexLies));
    write("c/0/0/0", shard_of(0, true, -1, uint64_t{0} - 90));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrIndexLies));
    write("c/0/0/0", shard_of(0, true, -1, uint64_t{0} - 1));
    EXPECT_NE(trouble(store()), "no error");
    std::string flipped = good;
    flipped[3] = static_cast<char>(flipped[3] ^ 1);
    write("c/0/0/0", flipped);
    EXPECT_THAT(trouble(store()), Says(messages::kZarrIndexChecksum));
    write("c/0/0/0", good.substr(0, 50));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrShardShort));
    flipped = good;
    flipped[102] = static_cast<char>(flipped[102] ^ 1);
    write("c/0/0/0", flipped);
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChunkDamaged, "zstd"));
    EXPECT_THAT(trouble(store()), ::testing::HasSubstr("`c/0/0/0`"));
    write("zarr.json", array3(sharding("end", "[2, 4, 2]"), "[2, 6, 4]"));
    EXPECT_THAT(trouble(store()), Says(core::kZarrShardSides));
    write("zarr.json", array3(sharding("end", "[1, 1, 1]"), "[1099511627776, 1099511627776, 4]"));
    EXPECT_THAT(trouble(store()), Says(core::kZarrChunkTooLarge));
}

std::string ome(const std::string& unit, const std::string& more = "") {
    std::string sets;
    for (int level = 0; level < 3; ++level) {
        const double s = 0.5 * (1 << level);
        sets += fmt::format(
            R"({}{{"path": "{}", "coordinateTransformations": [{{"type": "scale", "scale": [1, {}, {}, {}]}}{}]}})",
            level == 0 ? "" : ",", level, s, s, s,
            level == 1 ? R"(, {"type": "translation", "translation": [0, 3, 2, 1]})" : "");
    }
    return R"({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"version": "0.5")" +
           more + R"(, "multiscales": [{"axes": [{"name": "c", "type": "channel"},
{"name": "z", "type": "space", "unit": ")" +
           unit + R"("}, {"name": "y", "type": "space", "unit": ")" + unit +
           R"("}, {"name": "x", "type": "space", "unit": ")" + unit + R"("}], "datasets": [)" +
           sets + "]}]}}}";
}

TEST_F(ZarrTest, ALevelOfOmeZarrIsTakenByThePitch) {
    write("zarr.json", ome("millimeter"));
    for (int level = 0; level < 3; ++level) {
        const int n = 8 >> level;
        write(fmt::format("{}/zarr.json", level),
              array3(kBytes, "[1, 8, 8, 8]", fmt::format("[2, {}, {}, {}]", n, n, n)));
        for (int c = 0; c < 2; ++c) {
            std::string bytes;
            for (int i = 0; i < 512; ++i)
                bytes += number(static_cast<uint64_t>(1000 * level + 100 * c), 2);
            write(fmt::format("{}/c/{}/0/0/0", level, c), bytes);
        }
    }
    const auto level_of = [&](double pitch) {
        VolumeOptions options;
        options.pitch_mm = pitch;
        const auto p = converted(store(), options);
        EXPECT_EQ(p->channels(), 2);
        EXPECT_EQ(p->texels()[1] - p->texels()[0], 1100.0f / 65535 - 1000.0f / 65535)
            << "interleaved; rounded as both are, at level 1";
        return p->texels()[0] * 65535 / 1000;
    };
    const auto nearly = [&](double pitch, float level) {
        VolumeOptions options;
        options.pitch_mm = pitch;
        const auto p = converted(store(), options);
        EXPECT_NEAR(p->texels()[0] * 65535, 1000 * level, 0.01) << pitch;
        EXPECT_NEAR(p->texels()[1] * 65535, 1000 * level + 100, 0.01) << pitch;
        return domain(*p);
    };
    EXPECT_NEAR(level_of(1.0), 1, 1e-4);
    EXPECT_EQ(nearly(0, 0), (std::vector<float>{0, 0, 0, 4, 4, 4}));
    EXPECT_EQ(nearly(0.4, 0), (std::vector<float>{0, 0, 0, 4, 4, 4})) << "none is as fine";
    EXPECT_EQ(nearly(1.9, 1), (std::vector<float>{0.5f, 1.5f, 2.5f, 4, 4, 4}))
        << "a translation is of the centre of the first texel";
    EXPECT_EQ(nearly(2, 2), (std::vector<float>{0, 0, 0, 4, 4, 4}));
    VolumeOptions options;
    options.field = "2";
    EXPECT_NEAR(converted(store(), options)->texels()[0] * 65535, 2000, 0.01);
    options.field = "../s.zarr/2";
    EXPECT_THAT(trouble(store(), options), Says(core::kZarrField));
    // In micrometres, 2 mm are more than all levels have.
    write("zarr.json", ome("micrometer"));
    EXPECT_FLOAT_EQ(nearly(2, 2)[3], 0.004f);
    write("zarr.json", ome("parsec"));
    EXPECT_THAT(trouble(store()), Says(core::kZarrUnit));
    options = {};
    options.unit = "cm";
    EXPECT_FLOAT_EQ(domain(*converted(store(), options))[3], 40);
    // Of labels numbers are as they are stored.
    write("zarr.json", ome("millimeter", R"(, "image-label": {})"));
    EXPECT_EQ(converted(store())->texels()[1], 100);
}

TEST_F(ZarrTest, WhatIsNotTakenIsNamed) {
    const auto says = [&](const std::string& metadata, const auto& row, const std::string& what) {
        write("zarr.json", metadata);
        EXPECT_THAT(trouble(store()), Says(row)) << metadata;
        EXPECT_THAT(trouble(store()), ::testing::HasSubstr(what));
    };
    chunks("c/", "/");
    says(array3(kBytes + R"(, {"name": "lzma"})"), core::kZarrCodec, "`lzma`");
    says(array3(R"({"name": "zstd"})"), core::kZarrCodec, "`zstd`");
    says(array3(""), core::kZarrNoBytes, "line 4");
    says(array3(kBytes, "[2, 2, 2]", "[3, 5, 4]", R"("hologram": {"name": "h"}, )"),
         core::kZarrExtension, "`hologram`");
    says(array3(kBytes, "[2, 2]"), core::kZarrAxesDiffer, "zarr.json");
    says(array3(kBytes, "[2, 0, 2]"), core::kZarrNotSides, "chunk_shape");
    says(array3(kBytes, "[2, 2]", "[5, 4]"), core::kZarrSides, "2 axes");
    says(array3(kBytes, "[1, 1, 1]", "[200, 200, 200]"), core::kZarrTooManyFiles, "8000000");
    says(R"({"zarr_format": 4})", core::kZarrVersion, "version 4");
    says(R"({"zarr_format": 3, "node_type": "group"})", core::kZarrGroup, "zarr.json");
    std::string complex = array3();
    complex.replace(complex.find("uint16"), 6, "complex64");
    says(complex, core::kZarrType, "`complex64`");
    fs::remove(store() / "zarr.json");
    write(".zarray", array2("null", "<M8"));
    EXPECT_THAT(trouble(store()), Says(core::kZarrType, "<M8"));
    write(".zarray", array2(R"({"id": "lz4"})"));
    EXPECT_THAT(trouble(store()), Says(core::kZarrCodec, "lz4"));
}

TEST_F(ZarrTest, DamagedChunksAreNamed) {
    write("zarr.json", array3());
    chunks("c/", "/");
    write("c/1/2/1", chunk_of(1, 2, 1).substr(0, 15));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChunkSize, "15", "16"));
    EXPECT_THAT(trouble(store()), ::testing::HasSubstr("`c/1/2/1`"));
    write("c/1/2/1", std::string(100'000, ' '));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrFileTooLarge));
    write("zarr.json", array3(kBytes + R"(, {"name": "crc32c"})"));
    chunks("c/", "/", [](const std::string& b) { return b + crc(b); });
    write("c/0/0/1", chunk_of(0, 0, 1) + "sums");
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChecksum));
    write("zarr.json", array3(kBytes + R"(, {"name": "gzip"})"));
    chunks("c/", "/", [](const std::string& b) { return deflated(b, 31); });
    write("c/0/0/1", deflated(chunk_of(0, 0, 1), 31) + "more");
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChunkDamaged, "gzip"));
    write("c/0/0/1", deflated(std::string(100'000, ' '), 31));
    EXPECT_THAT(trouble(store()), Says(messages::kZarrChunkDamaged, "gzip")) << "a bomb";
}

TEST_F(ZarrTest, LinksStayBelowTheStore) {
    write("zarr.json", array3());
    chunks("c/", "/");
    // Chunks that are links to one.
    fs::remove(store() / "c/0/0/1");
    fs::create_symlink("0", store() / "c/0/0/1");
    EXPECT_EQ(trouble(store()), "no error");
    folder_.write("secret", chunk_of(0, 0, 1));
    for (const std::string to : {"../../../../secret", "nowhere"}) {
        fs::remove(store() / "c/0/0/1");
        fs::create_symlink(to, store() / "c/0/0/1");
        EXPECT_THAT(trouble(store()), Says(core::kDataFileUnreadable, "c/0/0/1")) << to;
        EXPECT_FALSE(texture::get_volume(store(), {}, 0, 0)) << to;
    }
}

TEST_F(ZarrTest, ChunksAreInTheKeyOfTheCache) {
    write("zarr.json", array3());
    chunks("c/", "/");
    const auto first = texture::get_volume(store(), {}, 0, 0);
    ASSERT_TRUE(first) << first.error().text();
    EXPECT_EQ((*first)->texels()[0], 1.0f / 65535);
    EXPECT_EQ(texture::detached_data(store() / "zarr.json", {}).size(), 12U);
    fs::remove(store() / "c/0/0/0");
    const auto second = texture::get_volume(store(), {}, 0, 0);
    ASSERT_TRUE(second) << second.error().text();
    EXPECT_EQ((*second)->texels()[0], 7.0f / 65535);
}

}  // namespace
}  // namespace openfab::tools
