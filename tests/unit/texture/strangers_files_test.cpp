// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Untrusted files: what they can make the converter and the cache read, and the memory they can
// take.

#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <libdeflate.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "base/input_file.h"
#include "base/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "texture/messages.h"
#include "texture/volume.h"
#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/messages.h"

extern char** environ;

namespace openfab::tools {
namespace {

using ::testing::HasSubstr;
using texture::Pyramid;
namespace fs = std::filesystem;

constexpr int64_t kMemory = 300'000'000;

std::string read_bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A grey PNG of zeros, one bit a pixel.
std::string one_bit_png(uint32_t side) {
    const auto chunk = [](const std::string& kind, const std::string& data) {
        const auto big_endian = [](uint32_t n) {
            return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16),
                               static_cast<char>(n >> 8), static_cast<char>(n)};
        };
        const std::string body = kind + data;
        return big_endian(static_cast<uint32_t>(data.size())) + body +
               big_endian(libdeflate_crc32(0, body.data(), body.size()));
    };
    const std::string rows(size_t{side} * (1 + side / 8), '\0');
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    std::string packed(libdeflate_zlib_compress_bound(c, rows.size()), '\0');
    packed.resize(
        libdeflate_zlib_compress(c, rows.data(), rows.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(c);
    const char high = static_cast<char>(side >> 8), low = static_cast<char>(side);
    const std::string header = {0, 0, high, low, 0, 0, high, low, 1, 0, 0, 0, 0};
    return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", packed) + chunk("IEND", "");
}

std::string gzip(const std::string& bytes) {
    libdeflate_compressor* c = libdeflate_alloc_compressor(6);
    std::string packed(libdeflate_gzip_compress_bound(c, bytes.size()), '\0');
    packed.resize(
        libdeflate_gzip_compress(c, bytes.data(), bytes.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(c);
    return packed;
}

class StrangersFiles : public ::testing::Test {
  protected:
    StrangersFiles() {
        ::setenv("OPENFAB_CACHE", (folder_.path() / "cache").c_str(), 1);
        ::setenv("OPENFAB_HELPER", testing::test_program("texture_test_helper").c_str(), 1);
        fs::create_directory(folder_.path() / "world");
    }
    fs::path picture(const std::string& name, const std::string& format, int side = 4) {
        const fs::path file = folder_.path() / name;
        const auto out = OIIO::ImageOutput::create(format);
        const OIIO::ImageSpec spec(side, side, 3, OIIO::TypeDesc::UINT8);
        const std::vector<uint8_t> pixels(static_cast<size_t>(3 * side * side), 128);
        EXPECT_TRUE(out->open(file.string(), spec)) << out->geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
        out->close();
        return file;
    }
    std::string error_of(const fs::path& file, int64_t memory = kMemory) {
        const Result<void> made =
            make_pyramid_file(file, folder_.path() / "out.oftx", {}, {memory, {}});
        return made ? "no error" : made.error().text();
    }
    /// Reads a header in the folder `world`.
    std::string error_of_volume(const std::string& name, int64_t memory = kMemory) {
        const Result<void> made = make_volume_file(folder_.path() / "world" / name,
                                                   folder_.path() / "out.oftx", {}, {memory, {}});
        return made ? "no error" : made.error().text();
    }
    fs::path header(const std::string& name, const std::string& more,
                    const std::string& sizes = "2 2 2") {
        return folder_.write("world/" + name, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " +
                                                  sizes + "\n" + more + "\n\n");
    }

    testing::TempFolder folder_;
};

TEST_F(StrangersFiles, FormatsAreToldByContentAndOnlyThoseOfPictures) {
    for (const char* format : {"png", "jpeg", "tiff", "openexr", "hdr", "pnm", "bmp", "targa"})
        EXPECT_EQ(error_of(picture(std::string(format) + ".avi", format)), "no error") << format;
    for (const char* format : {"iff", "ico"}) {
        EXPECT_THAT(error_of(picture("p.png", format)),
                    testing::Says(messages::kNotASupportedPicture, "PNG, JPEG"))
            << format;
    }
    // A playlist, by which a player would open what it names.
    const fs::path list = folder_.write(
        "list.avi", "#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:0\n#EXTINF:10.0,\nfile:///etc/passwd\n");
    EXPECT_THAT(error_of(list), testing::Says(messages::kNotASupportedPicture));
}

TEST_F(StrangersFiles, WhatIsNoFileIsNotOpened) {
    const fs::path pipe = folder_.path() / "pipe.png";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(error_of(pipe),
                testing::Says(openfab::messages::kKindNotAFile, openfab::messages::kKindPipe));
    EXPECT_THAT(error_of("/dev/zero"),
                testing::Says(openfab::messages::kKindNotAFile, openfab::messages::kKindDevice));
    const Result<uint64_t> key = texture::content_key(pipe, {});
    ASSERT_FALSE(key);
    EXPECT_THAT(key.error().text(),
                testing::Says(openfab::messages::kKindNotAFile, openfab::messages::kKindPipe));
}

TEST_F(StrangersFiles, SizesAreKnownBeforeMemoryIsTaken) {
    const fs::path large = folder_.write("large.png", one_bit_png(16384));
    ASSERT_LT(fs::file_size(large), 50'000u);
    EXPECT_THAT(error_of(large),
                testing::Says(messages::kTakesTooMuchMemory, "4.29 GB", "300 MB", "4300"));
    EXPECT_EQ(error_of(folder_.write("small.png", one_bit_png(1024))), "no error");

    header("bomb.nrrd", "encoding: gzip", "1000 1000 700");
    std::ofstream(folder_.path() / "world/bomb.nrrd", std::ios::app | std::ios::binary)
        << std::string(787'000, 'x');
    EXPECT_THAT(error_of_volume("bomb.nrrd"),
                testing::Says(messages::kTakesTooMuchMemory, "9.60 GB"));
    // Larger than its bytes can decompress to.
    header("thin.nrrd", "encoding: gzip\n\n" + gzip(std::string(100, 'x')), "256 256 64");
    EXPECT_THAT(error_of_volume("thin.nrrd"), testing::Says(messages::kCompressedOfOtherSize));
    header("more.nrrd", "encoding: gzip\n\n" + gzip(std::string(9, 'x')));
    EXPECT_THAT(error_of_volume("more.nrrd"), testing::Says(messages::kCompressedOfOtherSize));
    header("whole.nrrd", "encoding: gzip\n\n" + gzip(std::string(8, 'x')));
    EXPECT_EQ(error_of_volume("whole.nrrd"), "no error");
}

#ifndef OPENFAB_SANITIZED
TEST_F(StrangersFiles, TheConverterTakesLessThanThePyramid) {
    const std::string out = (folder_.path() / "out.oftx").string();
    // kB that the converter takes for a square picture of one channel, filtered.
    const auto peak_of = [&](int side) {
        const std::string file = folder_.write("grey.png", one_bit_png(side)).string();
        std::vector<std::string> words = {testing::test_program("texture_test_helper"),
                                          "texture",
                                          file,
                                          "-o",
                                          out,
                                          "--space",
                                          "data"};
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        pid_t child = 0;
        EXPECT_EQ(::posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ), 0);
        int status = 0;
        rusage used{};
        EXPECT_EQ(::wait4(child, &status, 0, &used), child);
        EXPECT_EQ(status, 0);
        return used.ru_maxrss;
    };
    // What its libraries take depends on the system.
    const long libraries = peak_of(16);
    const long all = peak_of(4096);
    EXPECT_GT(fs::file_size(out), 250'000'000u);
    EXPECT_LT(all - libraries, 67'000) << "kB, a quarter of the pyramid; libraries " << libraries;
}
#endif

TEST_F(StrangersFiles, DataFilesLieBelowTheFolderOfTheirHeader) {
    folder_.write("secret.raw", "12345678");
    folder_.write("world/own.raw", "12345678");
    fs::create_symlink("../secret.raw", folder_.path() / "world/link.raw");
    ASSERT_EQ(::mkfifo((folder_.path() / "world/pipe").c_str(), 0600), 0);
    const std::string raw = "encoding: raw\ndata file: ";
    const std::vector<std::pair<std::string, std::string>> refused = {
        {"../secret.raw", openfab::messages::kNotBelow},
        {(folder_.path() / "secret.raw").string(), openfab::messages::kNotBelow},
        {"link.raw", openfab::messages::kNotBelow},
        {"/dev/zero",
         fmt::format(openfab::messages::kKindNotAFile, openfab::messages::kKindDevice)},
        {"pipe", fmt::format(openfab::messages::kKindNotAFile, openfab::messages::kKindPipe)}};
    for (const auto& [data, why] : refused) {
        const fs::path file = header("h.nhdr", raw + data);
        EXPECT_THAT(error_of_volume("h.nhdr"), testing::Says(why)) << data;
        const auto volume = texture::get_volume(file, {}, 0, 0);
        ASSERT_FALSE(volume);
        EXPECT_EQ(volume.error().code, ErrorCode::kUserInput);
        EXPECT_THAT(volume.error().text(),
                    HasSubstr(fmt::format(texture::messages::kDataFileUnreadable, data)));
    }
    header("h.nhdr", raw + "own.raw");
    EXPECT_EQ(error_of_volume("h.nhdr"), "no error");
    // A folder above that is allowed.
    const fs::path above = header("h.nhdr", raw + "../secret.raw");
    EXPECT_TRUE(texture::get_volume(above, {}, 0, 0, {kMemory, {without_links(folder_.path())}}));
}

TEST_F(StrangersFiles, DataBesideAHeaderAreInTheKeyOfTheCache) {
    const fs::path file = header("h.nhdr", "encoding: raw\ndata file: d.raw");
    folder_.write("world/d.raw", "\x01\x01\x01\x01\x01\x01\x01\x01");
    const auto first = texture::get_volume(file, {}, 0, 0);
    ASSERT_TRUE(first) << first.error().text();
    EXPECT_FLOAT_EQ((*first)->texels()[0], 1.0f / 255);
    folder_.write("world/d.raw", "\x02\x02\x02\x02\x02\x02\x02\x02");
    const auto second = texture::get_volume(file, {}, 0, 0);
    ASSERT_TRUE(second);
    EXPECT_FLOAT_EQ((*second)->texels()[0], 2.0f / 255);
}

TEST_F(StrangersFiles, PatternsTakeTimeInProportion) {
    const std::string name(200, '0');
    folder_.write("world/" + name + "x.png", "");
    std::string pattern;
    for (int i = 0; i < 40; ++i)
        pattern += "*0";
    // Trying all ways to match would not end.
    EXPECT_FALSE(texture::volume_files(folder_.path() / "world" / (pattern + ".png")));
    EXPECT_TRUE(texture::volume_files(folder_.path() / "world" / (pattern + "x.png")));
    pattern.clear();
    for (int i = 0; i < 40; ++i)
        pattern += "%d";
    EXPECT_FALSE(texture::volume_files(folder_.path() / "world" / (pattern + ".png")));
    EXPECT_TRUE(texture::volume_files(folder_.path() / "world" / (pattern + "x*")));
}

TEST_F(StrangersFiles, ADamagedPyramidIsMadeAgain) {
    const fs::path file = picture("p.png", "png");
    const auto first = texture::get_pyramid(file, {}, 0, 0);
    ASSERT_TRUE(first);
    const float texel = (*first)->texels()[0];
    const Result<fs::path> cache = texture::cache_folder();
    ASSERT_TRUE(cache);
    const fs::path entry = *cache / texture::cache_name(*texture::content_key(file, {}));
    const std::string whole = read_bytes(entry);
    for (const size_t at : {whole.size() - 1, whole.size() / 2, size_t{68}, size_t{33}}) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x40);
        fs::remove(entry);  // the mapping above keeps the old one
        std::ofstream(entry, std::ios::binary) << damaged;
        EXPECT_FALSE(Pyramid::open(entry, 0, 0)) << at;
        const auto again = texture::get_pyramid(file, {}, 0, 0);
        ASSERT_TRUE(again);
        EXPECT_EQ((*again)->texels()[0], texel);
        EXPECT_TRUE(read_bytes(entry) == whole);
    }
}

TEST_F(StrangersFiles, WhatAConverterLeftBehindIsCleared) {
    ASSERT_TRUE(texture::get_pyramid(picture("a.png", "png"), {}, 0, 0));
    const fs::path cache = *texture::cache_folder();
    const fs::path left = cache / "0123456789abcdef.oftx.tmp-abcdef";
    const fs::path held = cache / "0123456789abcdef.oftx.tmp-ghijkl";
    std::ofstream(left) << "half";
    std::ofstream(held) << "half";
    const int at_work = ::open(held.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_EQ(::flock(at_work, LOCK_EX), 0);
    ASSERT_TRUE(texture::get_pyramid(picture("b.png", "png", 5), {}, 0, 0));
    EXPECT_FALSE(fs::exists(left));
    EXPECT_TRUE(fs::exists(held)) << "its converter is at work";
    ::close(at_work);
    ASSERT_TRUE(texture::get_pyramid(picture("c.png", "png", 6), {}, 0, 0));
    EXPECT_FALSE(fs::exists(held));
}

TEST_F(StrangersFiles, ACacheThatOthersCanWriteIsNotUsed) {
    const fs::path file = picture("p.png", "png");
    const fs::path cache = folder_.path() / "cache";
    ASSERT_TRUE(texture::get_pyramid(file, {}, 0, 0));
    fs::permissions(cache, fs::perms(0777));
    const Result<fs::path> folder = texture::cache_folder();
    ASSERT_FALSE(folder);
    EXPECT_THAT(folder.error().text(),
                HasSubstr(fmt::format(texture::messages::kFolderNotUsed, cache.string()) +
                          fmt::format(openfab::messages::kOthersCanWrite,
                                      openfab::messages::kItself, 0777)));
    const auto before = fs::last_write_time(cache);
    const auto made = texture::get_pyramid(file, {"data", false}, 0, 0);
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_FLOAT_EQ((*made)->texels()[0], 128.0f / 255) << "the file has gone, the mapping has not";
    EXPECT_EQ(fs::last_write_time(cache), before);
    // Nor is one below a folder that others can write.
    fs::permissions(cache, fs::perms(0700));
    EXPECT_TRUE(texture::cache_folder());
    fs::permissions(folder_.path(), fs::perms(0777));
    EXPECT_FALSE(texture::cache_folder());
    fs::permissions(folder_.path(), fs::perms(01777));
    EXPECT_TRUE(texture::cache_folder()) << "sticky, as /tmp is";
    // And no shared folder is trusted by default.
    for (const char* name : {"OPENFAB_CACHE", "XDG_CACHE_HOME", "HOME"})
        ::unsetenv(name);
    EXPECT_FALSE(texture::cache_folder());
    EXPECT_TRUE(texture::get_pyramid(file, {}, 0, 0));
}

}  // namespace
}  // namespace openfab::tools
