// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Stores of Zarr: what is written, by any number of writers, what is read back, and what is refused. That other
// programs read the same voxels is checked by tests/python/test_zarr.py.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <random>

#include "backends/common/messages.h"
#include "backends/read/print_file.h"
#include "backends/zarr/coarser.h"
#include "backends/zarr/layout.h"
#include "backends/zarr/messages.h"
#include "backends/zarr/shard.h"
#include "backends/zarr/store.h"
#include "backends/zarr/whole_store.h"
#include "backends/zarr/zarr_sink.h"
#include "base/crc32c.h"
#include "runtime/pipeline/print_hash.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
constexpr int64_t kMemory = int64_t{1} << 30;

/// A print with chunks of void, of one material, and of noise.
SamplePrint make_blocks(Vec3i size, int32_t bits = 4) {
    SamplePrint print = make_sample(size, bits);
    std::mt19937 random(7);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const int32_t block = (x / 128 + y / 128 + z / 16) % 3;
                print.at(x, y, z) = static_cast<uint8_t>(block == 2 ? random() % 4 : 2 * block);
            }
        }
    }
    return print;
}

SamplePrint part_of(SamplePrint print, int32_t begin, int32_t end) {
    print.info.slice_begin = begin;
    print.info.slice_end = end;
    return print;
}

Result<void> write(const fs::path& path, const SamplePrint& print, bool complete = true) {
    zarr::ZarrSink sink(path, false);
    return print.send(&sink, complete);
}

/// Writes as `openfab print --resume` does; returns the slices that were kept.
Result<int32_t> resume(const fs::path& path, const SamplePrint& print) {
    zarr::ZarrSink sink(path, true);
    if (Result<void> begun = sink.begin(print.info); !begun) return begun.error();
    const Result<int32_t> kept = sink.resume([&](const pipeline::SliceView& slice) {
        const size_t bytes = slice.row_bytes * static_cast<size_t>(slice.height);
        EXPECT_EQ(std::vector<uint8_t>(slice.data, slice.data + bytes), print.rows(slice.z));
        return true;
    });
    if (!kept) return kept;
    for (int32_t z = print.info.slice_begin + *kept; z < print.info.slice_end; ++z) {
        const std::vector<uint8_t> rows = print.rows(z);
        if (Result<void> done = sink.commit(z, sink.encode(print.view(z, rows))); !done)
            return done.error();
    }
    if (Result<void> done = sink.finish(print.totals()); !done) return done.error();
    return kept;
}

/// Returns all files of a store but the writers' lists, by their names.
std::map<std::string, std::string> files_of(const fs::path& path) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(path)) {
        if (entry.is_regular_file() && entry.path().extension() != ".list")
            files[fs::relative(entry.path(), path).string()] = read_file(entry.path());
    }
    return files;
}

void flip_byte(const fs::path& file, size_t at) {
    std::string bytes = read_file(file);
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
}

/// Fails the test where a slice differs from that of `print`; returns the first error of reading.
std::string read_back(const fs::path& path, const SamplePrint& print) {
    const auto file = prints::PrintFile::open(path.string(), kMemory);
    if (!file) return file.error().text();
    prints::SliceBuffers buffers;
    for (int32_t z = print.info.slice_begin; z < print.info.slice_end; ++z) {
        if (Result<void> read = (*file)->read_slice(z, &buffers); !read) return read.error().text();
        EXPECT_EQ(buffers.rows, print.rows(z)) << "slice " << z;
    }
    return {};
}

class Zarr : public ::testing::Test {
  protected:
    fs::path path(const std::string& name = "print.zarr") const { return scratch_ / name; }
    ScratchFolder scratch_;
};

TEST_F(Zarr, RoundTripOfSidesThatAreNoMultiples) {
    for (const Vec3i size : {Vec3i{1, 1, 1}, {13, 6, 9}, {129, 257, 17}, {300, 128, 20}}) {
        for (const int32_t bits : {4, 8}) {
            const SamplePrint print = make_blocks(size, bits);
            const fs::path store = path(fmt::format("{}-{}.zarr", size.x, bits));
            const Result<void> written = write(store, print);
            ASSERT_TRUE(written) << written.error().text();
            EXPECT_EQ(read_back(store, print), "");
            const auto file = prints::PrintFile::open(store.string(), kMemory);
            ASSERT_TRUE(file) << file.error().text();
            const pipeline::PrintInfo& info = (*file)->info();
            EXPECT_EQ(info.size, size);
            EXPECT_EQ(info.pitch_mm, print.info.pitch_mm);
            EXPECT_EQ(info.origin_mm, print.info.origin_mm);
            EXPECT_EQ(info.bits, bits);
            EXPECT_EQ(info.seed, print.info.seed);
            EXPECT_EQ(info.provenance, print.info.provenance);
            ASSERT_EQ(info.materials.size(), print.info.materials.size());
            EXPECT_EQ(info.materials[2].name, print.info.materials[2].name);
            EXPECT_EQ(info.materials[2].key, print.info.materials[2].key);
            EXPECT_EQ(info.materials[2].density_g_cm3, print.info.materials[2].density_g_cm3);
            const auto totals = (*file)->totals();
            ASSERT_TRUE(totals);
            EXPECT_EQ(totals->hash, print.totals().hash);
            EXPECT_EQ(totals->voxels_by_code, print.totals().voxels_by_code);
        }
    }
}

TEST_F(Zarr, AnyWritersMakeTheSameBytes) {
    const SamplePrint print = make_blocks({300, 260, 61});
    ASSERT_TRUE(write(path("one.zarr"), print));
    // In any order, the middle one twice.
    for (const auto& [begin, end] : {std::pair(40, 61), {0, 16}, {16, 40}, {16, 40}}) {
        const Result<void> written = write(path("three.zarr"), part_of(print, begin, end));
        ASSERT_TRUE(written) << written.error().text();
    }
    EXPECT_EQ(files_of(path("three.zarr")), files_of(path("one.zarr")));
    EXPECT_EQ(read_back(path("three.zarr"), print), "");
    EXPECT_TRUE(fs::exists(path("three.zarr") / zarr::kManifestFile));
}

/// The most frequent code of 2 x 2 x 2 voxels, the lowest of several: counted one by one.
SamplePrint coarser(const SamplePrint& finer) {
    SamplePrint coarse = finer;
    const Vec3i& size = finer.info.size;
    coarse.info.size = {(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2};
    coarse.codes.assign(static_cast<size_t>(coarse.info.size.x) *
                            static_cast<size_t>(coarse.info.size.y) *
                            static_cast<size_t>(coarse.info.size.z),
                        0);
    for (int32_t z = 0; z < coarse.info.size.z; ++z) {
        for (int32_t y = 0; y < coarse.info.size.y; ++y) {
            for (int32_t x = 0; x < coarse.info.size.x; ++x) {
                std::map<uint8_t, int> counts;
                for (int32_t k = 2 * z; k < std::min(2 * z + 2, size.z); ++k)
                    for (int32_t j = 2 * y; j < std::min(2 * y + 2, size.y); ++j)
                        for (int32_t i = 2 * x; i < std::min(2 * x + 2, size.x); ++i)
                            ++counts[finer.at(i, j, k)];
                uint8_t most = counts.begin()->first;
                for (const auto& [code, count] : counts)
                    if (count > counts[most]) most = code;
                coarse.at(x, y, z) = most;
            }
        }
    }
    return coarse;
}

TEST_F(Zarr, EachLevelHasTheMostFrequentCodes) {
    SamplePrint print = make_blocks({4099, 3, 37});
    ASSERT_TRUE(write(path(), print));
    const Result<zarr::Store> store = zarr::Store::open(path());
    ASSERT_TRUE(store) << store.error().text();
    const Result<std::vector<zarr::ShardList>> lists = store->lists();
    ASSERT_TRUE(lists);
    const auto manifest = zarr::read_manifest(*store);
    ASSERT_TRUE(manifest && *manifest);
    ASSERT_EQ(store->levels().size(), 6u);  // 4099, 2050, 1025, 513, 257, 129
    for (size_t level = 0; level < store->levels().size(); ++level) {
        if (level > 0) print = coarser(print);
        EXPECT_EQ(store->levels()[level].size, print.info.size);
        std::vector<uint8_t> codes, planes;
        for (int32_t shard = 0; shard < store->levels()[level].shards(); ++shard) {
            const zarr::ShardDigest digest =
                level < zarr::kSlabLevels ? lists->front().slabs[static_cast<size_t>(shard)][level]
                                          : (*manifest)->coarse.at(zarr::shard_key(level, shard));
            const auto bytes = store->read_shard(level, shard, digest);
            ASSERT_TRUE(bytes) << bytes.error().text();
            ASSERT_TRUE(
                store->decode(level, shard, *bytes, store->planes_of(level, shard), &planes));
            codes.insert(codes.end(), planes.begin(), planes.end());
        }
        EXPECT_EQ(codes, print.codes) << "level " << level;
    }
}

TEST(ZarrLevels, RowsOfAnyWidthAreHalvedByCounting) {
    std::mt19937 random(3);
    for (int32_t width = 1; width < 300; ++width) {
        SamplePrint rows = make_sample({width, 2, 2}, 8);
        for (uint8_t& code : rows.codes)
            code = static_cast<uint8_t>(random() % 3 == 0 ? 254 : random() % 3);
        std::vector<uint8_t> out(static_cast<size_t>((width + 1) / 2));
        const uint8_t* const first = rows.codes.data();
        zarr::halve_rows({first, first + width, first + 2 * width, first + 3 * width}, width,
                         out.data());
        EXPECT_EQ(out, coarser(rows).codes) << width;
    }
}

TEST(ZarrShard, CrcIsThatOfTheStandard) {
    // RFC 3720, B.4: 32 bytes of zeros, of ones, and ascending.
    std::vector<uint8_t> bytes(32, 0);
    EXPECT_EQ(crc32c(bytes), 0x8a9136aaU);
    std::fill(bytes.begin(), bytes.end(), uint8_t{0xff});
    EXPECT_EQ(crc32c(bytes), 0x62a8ab43U);
    for (size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<uint8_t>(i);
    EXPECT_EQ(crc32c(bytes), 0x46dd794eU);
}

TEST_F(Zarr, VoidShardsHaveNoFile) {
    SamplePrint print = make_sample({40, 30, 24});
    std::fill(print.codes.begin(), print.codes.end(), uint8_t{0});
    print.at(3, 4, 20) = 1;
    ASSERT_TRUE(write(path(), print));
    EXPECT_FALSE(fs::exists(path() / "0/c/0/0/0"));
    EXPECT_FALSE(fs::exists(path() / "0/c/1/0/0"));
    EXPECT_TRUE(fs::exists(path() / "0/c/2/0/0"));
    EXPECT_EQ(read_back(path(), print), "");
}

TEST_F(Zarr, ResumesBehindTheFirstShardThatIsNotWhole) {
    const SamplePrint print = make_blocks({140, 130, 45});
    ASSERT_TRUE(write(path(), print));
    const auto whole = files_of(path());
    struct Damage {
        const char* what;
        std::string file;
        int32_t kept;
    };
    for (const auto& [what, file, kept] : std::vector<Damage>{{"cut", "0/c/2/0/0", 16},
                                                              {"flipped", "0/c/1/0/0", 8},
                                                              {"gone", "0/c/3/0/0", 24},
                                                              {"empty", "0/c/0/0/0", 0},
                                                              {"none", "", 45}}) {
        const fs::path shard = path() / file;
        if (what == std::string("cut")) fs::resize_file(shard, fs::file_size(shard) / 2);
        if (what == std::string("flipped")) flip_byte(shard, fs::file_size(shard) / 3);
        if (what == std::string("gone")) fs::remove(shard);
        if (what == std::string("empty")) fs::resize_file(shard, 0);
        EXPECT_EQ(read_back(path(), print).empty(), file.empty()) << what;
        const Result<int32_t> went_on = resume(path(), print);
        ASSERT_TRUE(went_on) << what << ": " << went_on.error().text();
        EXPECT_EQ(*went_on, kept) << what;
        EXPECT_EQ(files_of(path()), whole) << what;
        EXPECT_EQ(read_back(path(), print), "") << what;
    }
}

TEST_F(Zarr, NothingThatIsThereIsWrittenTwice) {
    const SamplePrint print = make_blocks({140, 130, 45});
    ASSERT_TRUE(write(path(), print, false));
    std::map<std::string, ino_t> before;
    struct stat status {};
    for (const auto& [name, bytes] : files_of(path())) {
        ASSERT_EQ(::stat((path() / name).c_str(), &status), 0);
        before[name] = status.st_ino;
    }
    // A kill between a shard and its line in the list: the shard is there, the line is not.
    const fs::path list = path() / zarr::list_name(0, 45);
    fs::resize_file(list, fs::file_size(list) - 10);
    const Result<int32_t> kept = resume(path(), print);
    ASSERT_TRUE(kept) << kept.error().text();
    EXPECT_EQ(*kept, 40);
    for (const auto& [name, inode] : before) {
        ASSERT_EQ(::stat((path() / name).c_str(), &status), 0);
        EXPECT_EQ(status.st_ino, inode) << name;
    }
    EXPECT_TRUE(fs::exists(path() / zarr::kManifestFile));
}

TEST_F(Zarr, AnotherPrintIsRefusedAndLosesNothing) {
    const SamplePrint print = make_blocks({40, 30, 24});
    ASSERT_TRUE(write(path(), print));
    const auto before = files_of(path());
    SamplePrint other = print;
    other.info.seed = 5;
    Result<void> refused = write(path(), other);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), Says(zarr::messages::kOtherPrint));
    EXPECT_THAT(refused.error().text(), ::testing::HasSubstr("seed"));
    const Result<int32_t> resumed = resume(path(), other);
    ASSERT_FALSE(resumed);
    EXPECT_THAT(resumed.error().text(), Says(backends::messages::kResumeRefused));
    refused = write(path(), part_of(print, 8, 24));
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), Says(zarr::messages::kOthersSlices));
    EXPECT_FALSE(fs::exists(path() / zarr::list_name(8, 24)));
    EXPECT_EQ(files_of(path()), before);
    // A shard that another print owns, under the same name.
    for (uint8_t& code : other.codes)
        code = code == 2 ? 1 : code;
    ASSERT_TRUE(write(path("other.zarr"), other));
    fs::copy_file(path("other.zarr") / "0/c/2/0/0", path() / "0/c/2/0/0",
                  fs::copy_options::overwrite_existing);
    EXPECT_THAT(read_back(path(), print), Says(zarr::messages::kShardDiffers));
}

TEST_F(Zarr, AShardThatIsTooLargeToBeOneIsNotRead) {
    SamplePrint print = make_blocks({40, 30, 8});
    print.at(0, 0, 0) = 1;
    ASSERT_TRUE(write(path(), print));
    fs::resize_file(path() / "0/c/0/0/0", 200'000);
    const std::string bytes = read_file(path() / "0/c/0/0/0");
    const zarr::ShardDigest digest =
        zarr::digest_of({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    std::string list = read_file(path() / zarr::list_name(0, 8));
    list.resize(list.find('\n') + 1);
    std::ofstream(path() / zarr::list_name(0, 8)) << list << zarr::slab_line(0, {digest});
    EXPECT_THAT(read_back(path(), print), Says(zarr::messages::kShardDamaged));
}

TEST_F(Zarr, RangesEndWithSlabs) {
    const SamplePrint print = make_sample({9, 8, 20});
    const Result<void> refused = write(path(), part_of(print, 4, 11));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
    EXPECT_THAT(refused.error().text(), Says(zarr::messages::kNotAtSlabs));
    EXPECT_THAT(refused.error().text(), ::testing::HasSubstr("--slices 0:16"));
    EXPECT_FALSE(fs::exists(path()));
}

TEST_F(Zarr, StoresThatAreNoneOfOursAreNamed) {
    const SamplePrint print = make_sample({9, 8, 20});
    std::ofstream(path("file.zarr")) << "x";
    EXPECT_THAT(write(path("file.zarr"), print).error().text(),
                Says(zarr::messages::kOutputIsFile));
    fs::create_directories(path("folder.zarr"));
    std::ofstream(path("folder.zarr") / "mine.txt") << "x";
    EXPECT_THAT(write(path("folder.zarr"), print).error().text(),
                Says(zarr::messages::kOtherFiles));
    fs::create_directories(path("old.zarr"));
    std::ofstream(path("old.zarr") / ".zgroup") << R"({"zarr_format": 2})";
    EXPECT_THAT(read_back(path("old.zarr"), print), Says(zarr::messages::kOtherVersion));
    fs::create_directories(path("alien.zarr"));
    std::ofstream(path("alien.zarr") / "zarr.json")
        << R"({"zarr_format": 3, "node_type": "group", "attributes": {}})";
    EXPECT_THAT(read_back(path("alien.zarr"), print), Says(zarr::messages::kNoPrint));
    ASSERT_TRUE(write(path(), print));
    const fs::path array = path() / "0/zarr.json";
    std::string text = read_file(array);
    text.replace(text.find("zstd"), 4, "gzip");
    std::ofstream(array) << text;
    EXPECT_THAT(read_back(path(), print), Says(zarr::messages::kOtherArray));
    EXPECT_THAT(read_back(path(), print), ::testing::HasSubstr("codecs"));
}

TEST_F(Zarr, AFileThatIsBeingWrittenIsReadAsFarAsItGoes) {
    const SamplePrint print = make_blocks({140, 130, 45});
    zarr::ZarrSink sink(path(), false);
    ASSERT_TRUE(sink.begin(print.info));
    const auto file = prints::PrintFile::open(path().string(), kMemory);
    ASSERT_TRUE(file) << file.error().text();
    EXPECT_EQ((*file)->whole_slices(), 0);
    for (int32_t z = 0; z < 45; ++z) {
        const std::vector<uint8_t> rows = print.rows(z);
        ASSERT_TRUE(sink.commit(z, sink.encode(print.view(z, rows))));
        EXPECT_EQ((*file)->look_again(), z % 8 == 7 || z == 44);
        EXPECT_EQ((*file)->whole_slices(), z == 44 ? 45 : (z + 1) / 8 * 8);
    }
    EXPECT_FALSE((*file)->totals());
    // Two writers of one range.
    zarr::ZarrSink second(path(), false);
    EXPECT_THAT(second.begin(print.info).error().text(), Says(backends::messages::kBeingWritten));
    ASSERT_TRUE(sink.finish(print.totals()));
    EXPECT_TRUE((*file)->look_again());
    EXPECT_TRUE((*file)->totals());
}

}  // namespace
}  // namespace openfab::testing
