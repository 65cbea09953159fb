// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab verify` of the formats that are one file: whole ones pass, damaged ones do not.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "mesh/read/zip_file.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

/// Returns where a byte of the contents is: of a package one of a part, not of the headers between them.
size_t data_at(const std::string& bytes, std::mt19937* random) {
    const std::string header("PK\3\4", 4);
    const size_t middle = bytes.size() / 4 + (*random)() % (bytes.size() / 4);
    if (!bytes.starts_with(header)) return middle;
    const size_t at = bytes.rfind(header, middle);
    const auto number = [&](size_t from, int count) {
        size_t value = 0;
        for (int i = count - 1; i >= 0; --i)
            value = value << 8 | static_cast<uint8_t>(bytes[at + from + static_cast<size_t>(i)]);
        return value;
    };
    return at + 30 + number(26, 2) + number(28, 2) + std::min<size_t>(number(18, 4) / 2, 20);
}

class Verify : public ::testing::Test {
  protected:
    Verify() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        scratch_.write("w.fab.json", SimpleWorld{"Skin", R"({"sphere": 4})"}.text());
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome verify(const std::string& name) {
        return run({program("openfab"), "verify", path(name)});
    }

    ScratchFolder scratch_;
};

TEST_F(Verify, DamageInAnyFormatIsFound) {
    std::mt19937 random(5);
    for (const char* output : {"a.stl", "a.3mf", "a.gcvf"}) {
        const Outcome printed = run({test_program("openfab_test_print_4"), path("w.fab.json"),
                                     std::string(output) == "a.gcvf" ? "--voxel" : "--mesh-pitch",
                                     "0.2mm", "-o", path(output)});
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        int files = 0;
        for (const auto& entry : std::filesystem::directory_iterator(path(""))) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with("a") ||
                entry.path().extension() != std::filesystem::path(output).extension())
                continue;
            ++files;
            const std::string bytes = read_file(entry.path());
            EXPECT_EQ(verify(name).exit_code, 0) << verify(name).err;
            for (int i = 0; i < 5; ++i) {
                std::string damaged = bytes;
                char& byte = damaged[data_at(bytes, &random)];
                byte = static_cast<char>(byte ^ (1 << i));
                scratch_.write(name, damaged);
                EXPECT_EQ(verify(name).exit_code, 1) << name;
            }
            scratch_.write(name, bytes.substr(0, bytes.size() - 40));
            EXPECT_EQ(verify(name).exit_code, 1) << name;
            scratch_.write(name, bytes);
        }
        EXPECT_GE(files, 1);
    }
}

/// Each picture of a GCVF has its checksum, also in the wrong place.
TEST_F(Verify, APackageHasAllSlicesInTheirPlaces) {
    for (const char* flip : {"false", "true"}) {
        const Outcome printed =
            run({test_program("openfab_test_print_4"), path("w.fab.json"), "--voxel", "0.2mm", "-o",
                 path("a.gcvf"), std::string("--flip-x=") + flip});
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        const Outcome fine = verify("a.gcvf");
        EXPECT_EQ(fine.exit_code, 0) << fine.err;
        EXPECT_THAT(fine.err, Says(tools::messages::kPackageSlicesWhole));
        const std::string bytes = read_file(path("a.gcvf"));
        const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "a.gcvf");
        ASSERT_TRUE(zip);
        std::vector<std::pair<std::string, std::string>> parts;
        for (const std::string& name : zip->names())
            parts.emplace_back(name, *zip->read(name, 1 << 24));
        const auto find = [&](const std::string& name) {
            return std::find_if(parts.begin(), parts.end(),
                                [&](const auto& part) { return part.first == name; });
        };
        std::swap(find("slice_6.png")->second, find("slice_9.png")->second);
        ASSERT_NE(find("slice_6.png")->second, find("slice_9.png")->second);
        scratch_.write("a.gcvf", zip_archive(parts));
        EXPECT_EQ(verify("a.gcvf").exit_code, 1);
        EXPECT_THAT(verify("a.gcvf").err, Says(tools::messages::kHashDiffers));
        std::swap(find("slice_6.png")->second, find("slice_9.png")->second);
        scratch_.write("a.gcvf", zip_archive(parts));
        EXPECT_EQ(verify("a.gcvf").exit_code, 0) << verify("a.gcvf").err;
        int last = 0;
        while (find(fmt::format("slice_{}.png", last + 1)) != parts.end())
            ++last;
        parts.erase(find(fmt::format("slice_{}.png", last)));
        scratch_.write("a.gcvf", zip_archive(parts));
        EXPECT_THAT(verify("a.gcvf").err, Says(tools::messages::kPackageLacksSlice));
    }
}

/// The files of an STL are of one print.
TEST_F(Verify, MeshesOfTwoPrintsAreTold) {
    const auto print = [&](const std::string& output, const char* pitch) {
        const Outcome printed = run({test_program("openfab_test_print_4"), path("w.fab.json"),
                                     "--mesh-pitch", pitch, "-o", path(output)});
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
    };
    print("a.stl", "0.4mm");
    std::filesystem::create_directory(path("other"));
    print("other/a.stl", "0.5mm");
    print("b.stl", "0.5mm");  // another output beside it
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path("other")))
        names.push_back(entry.path().filename().string());
    ASSERT_EQ(names.size(), 2U);
    for (const std::string& name : names)
        EXPECT_EQ(verify(name).exit_code, 0) << verify(name).err;
    std::filesystem::copy(path("other/" + names[0]), path(names[0]),
                          std::filesystem::copy_options::overwrite_existing);
    for (const std::string& name : names) {
        EXPECT_EQ(verify(name).exit_code, 1);
        EXPECT_THAT(verify(name).err, Says(tools::messages::kMeshOfOtherPrint));
    }
}

/// Of another program's file nothing more is known than its size.
TEST_F(Verify, AMeshOfOthersHasNoDigest) {
    std::string bytes(84, ' ');
    bytes[80] = 1;
    bytes[81] = bytes[82] = bytes[83] = 0;
    scratch_.write("theirs.stl", bytes + std::string(50, '\0'));
    const Outcome outcome = verify("theirs.stl");
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.err,
                HasSubstr(fmt::format(tools::messages::kMeshWithoutDigest, path("theirs.stl"), 1)));
    scratch_.write("theirs.stl", bytes);
    EXPECT_EQ(verify("theirs.stl").exit_code, 1);
}

TEST_F(Verify, APackageHasToBeOne) {
    const std::string any = zip_archive({{"a", "a"}, {"b", "b"}});
    for (const char* name : {"any.3mf", "any.gcvf"}) {
        scratch_.write(name, any);
        EXPECT_EQ(verify(name).exit_code, 1) << name;
    }
}

// Both hold the digests of a folder: one without the other is not what was written.
TEST_F(Verify, AManifestWithoutItsDigestsIsTold) {
    const Outcome printed = run({test_program("openfab_test_print_4"), path("w.fab.json"),
                                 "--voxel", "0.4mm", "--format", "png", "-o", path("slices")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    ASSERT_EQ(verify("slices").exit_code, 0);
    std::string manifest = read_file(path("slices/manifest.json"));
    const size_t begin = manifest.find("\"sha256\"");
    ASSERT_NE(begin, std::string::npos);
    manifest.replace(begin, 8, "\"sha255\"");
    scratch_.write("slices/manifest.json", manifest);
    const Outcome outcome = verify("slices");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, Says(tools::messages::kManifestWithoutDigests));
}

}  // namespace
}  // namespace openfab::testing
