// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/unit/backends/slice_folder.h"

namespace openfab::testing {
namespace {

/// Also where a slice takes fewer bytes than before, and where there are fewer.
TEST_F(SliceFolder, AnEarlierPrintIsWrittenOver) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    struct stat before {};
    ASSERT_EQ(::stat((scratch_ / "slices/slice_0002.png").c_str(), &before), 0);
    const SamplePrint print = make_letter_f(2, 5);
    ASSERT_TRUE(write(print, {}));
    ASSERT_TRUE(write(print, {}, "fresh"));
    std::map<std::string, std::string> written, fresh;
    for (const auto& entry : fs::directory_iterator(scratch_ / "slices"))
        written[entry.path().filename().string()] = read_file(entry.path());
    for (const auto& entry : fs::directory_iterator(scratch_ / "fresh"))
        fresh[entry.path().filename().string()] = read_file(entry.path());
    EXPECT_EQ(written, fresh);
    struct stat after {};
    ASSERT_EQ(::stat((scratch_ / "slices/slice_0002.png").c_str(), &after), 0);
    EXPECT_EQ(before.st_ino, after.st_ino);  // file systems take long to make new ones
}

TEST_F(SliceFolder, SlicesOfAnEarlierPrintAreGoneFromTheFirstOn) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        raster::FolderSink::create(scratch_ / "slices", {});
    ASSERT_TRUE(sink);
    const SamplePrint print = make_letter_f(2, 5);
    ASSERT_TRUE((*sink)->begin(print.info));
    const auto slices = [&] {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(scratch_ / "slices")) {
            if (entry.path().extension() == ".png") names.push_back(entry.path().filename());
        }
        return names;
    };
    EXPECT_THAT(slices(), ::testing::IsEmpty());
    const std::vector<uint8_t> rows = print.rows(0);
    ASSERT_TRUE((*sink)->commit(0, (*sink)->encode(print.view(0, rows))));
    EXPECT_THAT(slices(), ::testing::ElementsAre("slice_0001.png"));
    ASSERT_TRUE((*sink)->finish({}));
    // With the two notes and the digests.
    EXPECT_EQ(std::distance(fs::directory_iterator(scratch_ / "slices"), {}), 4);
}

/// What other names lead to keeps its bytes.
TEST_F(SliceFolder, CopiesByLinkStayAsTheyAre) {
    ASSERT_TRUE(write(make_sample({40, 30, 9}), {}));
    const std::string slice = read_file(scratch_ / "slices/slice_0001.png");
    fs::create_hard_link(scratch_ / "slices/slice_0001.png", scratch_ / "copy.png");
    fs::rename(scratch_ / "slices/slice_0002.png", scratch_ / "elsewhere.png");
    fs::create_symlink(scratch_ / "elsewhere.png", scratch_ / "slices/slice_0002.png");
    const std::string elsewhere = read_file(scratch_ / "elsewhere.png");
    fs::permissions(scratch_ / "slices/slice_0003.png", fs::perms::owner_read);
    ASSERT_TRUE(write(make_letter_f(2, 5), {}));
    EXPECT_EQ(read_file(scratch_ / "copy.png"), slice);
    EXPECT_EQ(read_file(scratch_ / "elsewhere.png"), elsewhere);
    EXPECT_FALSE(fs::is_symlink(scratch_ / "slices/slice_0002.png"));
    ASSERT_TRUE(write(make_letter_f(2, 5), {}, "fresh"));
    for (const char* name : {"slice_0001.png", "slice_0002.png", "slice_0003.png"})
        EXPECT_EQ(read_file(scratch_ / "slices" / name), read_file(scratch_ / "fresh" / name));
}

TEST_F(SliceFolder, ManifestAndHandoff) {
    const SamplePrint print = make_sample({600, 300, 10});
    raster::FolderOptions options;
    options.handoff = "Use the voxel print utility.";
    ASSERT_TRUE(write(print, options));
    rapidjson::Document manifest;
    manifest.Parse(read_file(scratch_ / "slices/manifest.json").c_str());
    ASSERT_FALSE(manifest.HasParseError());
    EXPECT_TRUE(manifest["complete"].GetBool());
    EXPECT_EQ(manifest["slices"].GetInt(), 10);
    EXPECT_EQ(manifest["pixels"][0].GetInt(), 600);
    EXPECT_EQ(manifest["pixels"][1].GetInt(), 300);
    EXPECT_DOUBLE_EQ(manifest["dpi"][0].GetDouble(), 600);
    EXPECT_DOUBLE_EQ(manifest["dpi"][1].GetDouble(), 300);
    EXPECT_DOUBLE_EQ(manifest["layer_um"].GetDouble(), 27);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][0].GetDouble(), 25.4);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][1].GetDouble(), 25.4);
    EXPECT_DOUBLE_EQ(manifest["size_mm"][2].GetDouble(), 0.27);
    EXPECT_STREQ(manifest["axes"]["image_right"].GetString(), "+x");
    EXPECT_STREQ(manifest["axes"]["image_up"].GetString(), "+y");
    EXPECT_STREQ(manifest["support_made_by"].GetString(), "front_end");
    EXPECT_STREQ(manifest["first_file"].GetString(), "slice_0001.png");
    EXPECT_STREQ(manifest["last_file"].GetString(), "slice_0010.png");
    ASSERT_EQ(manifest["materials"].Size(), 3u);
    const auto& black = manifest["materials"][1];
    EXPECT_STREQ(black["name"].GetString(), "black");
    EXPECT_STREQ(black["color"].GetString(), "#000000ff");
    const auto voxels = static_cast<double>(print.totals().voxels_by_code[2]);
    EXPECT_EQ(black["voxels"].GetDouble(), voxels);
    const double ml = voxels * (2.54 / 600) * (2.54 / 300) * 0.0027;  // in cubic centimetres
    EXPECT_NEAR(black["ml"].GetDouble(), ml, 1e-6);
    EXPECT_NEAR(black["g"].GetDouble(), ml * 1.2, 1e-6);
    char hash[17];
    std::snprintf(hash, sizeof(hash), "%016llx",
                  static_cast<unsigned long long>(print.totals().hash));
    EXPECT_STREQ(manifest["hash"].GetString(), hash);

    const std::string note = read_file(scratch_ / "slices/HANDOFF.txt");
    for (const char* part : {"600 dpi", "300 dpi", "27 um", "white", "RGB   0   0   0",
                             "Use the voxel print utility."}) {
        EXPECT_THAT(note, HasSubstr(part));
    }
    EXPECT_THAT(note, ::testing::Not(HasSubstr("NOT COMPLETE")));
}

/// `sha256sum` checks a folder, and `openfab verify` tells what is missing, other or none of it.
TEST_F(SliceFolder, EveryFileHasItsDigest) {
    for (const raster::SliceFormat format :
         {raster::SliceFormat::kRgba, raster::SliceFormat::kIndexed, raster::SliceFormat::kBitmaps,
          raster::SliceFormat::kGrey8, raster::SliceFormat::kTiff16}) {
        raster::FolderOptions options;
        options.format = format;
        SamplePrint print = make_sample({40, 30, 12});
        print.info.slice_begin = 2;
        ASSERT_TRUE(write(print, options));
        const auto by_others = [&](const std::string& check) {
            return run(
                {"/bin/sh", "-c", "cd '" + (scratch_ / "slices").string() + "' && " + check});
        };
        EXPECT_EQ(by_others("sha256sum --check --strict --quiet SHA256SUMS").exit_code, 0);
        const size_t files = format == raster::SliceFormat::kBitmaps ? 30 : 10;
        rapidjson::Document manifest;
        manifest.Parse(read_file(scratch_ / "slices/manifest.json").c_str());
        ASSERT_EQ(manifest["sha256"].MemberCount(), files);
        const auto& first = *manifest["sha256"].MemberBegin();
        EXPECT_EQ(by_others(std::string("sha256sum ") + first.name.GetString()).out.substr(0, 64),
                  first.value.GetString());

        const auto told = [&] {
            return run({program("openfab"), "verify", (scratch_ / "slices").string()});
        };
        EXPECT_EQ(told().exit_code, 0) << told().err;
        const std::string end = format == raster::SliceFormat::kBitmaps  ? "_2.bmp"
                                : format == raster::SliceFormat::kTiff16 ? ".tif"
                                                                         : ".png";
        const fs::path one = scratch_ / ("slices/slice_0005" + end);
        const std::string bytes = read_file(one);
        const auto wrong = [&](const char* message, const std::string& name) {
            const Outcome outcome = told();
            EXPECT_EQ(outcome.exit_code, 1);
            EXPECT_THAT(outcome.err, HasSubstr(fmt::format(fmt::runtime(message), name)));
        };
        const std::string name = one.filename().string();
        fs::remove(one);
        wrong(tools::messages::kFileMissing, name);
        EXPECT_THAT(run({program("openfab"), "info", (scratch_ / "slices").string()}).out,
                    HasSubstr(fmt::format(tools::messages::kFolderLacksFiles, 1, files, name)));
        fs::copy(scratch_ / ("slices/slice_0006" + end), one);
        wrong(tools::messages::kFileDiffers, name);
        scratch_.write("slices/" + name, bytes);
        const std::string more = "slice_0012_9.bmp";
        scratch_.write("slices/" + more, bytes);
        wrong(tools::messages::kFileOfOther, more);
        fs::remove(scratch_ / ("slices/" + more));
        std::string other = read_file(scratch_ / "slices/HANDOFF.txt");
        scratch_.write("slices/HANDOFF.txt", other + "Print it twice.\n");
        wrong(tools::messages::kFileDiffers, "HANDOFF.txt");
        scratch_.write("slices/HANDOFF.txt", other);
        EXPECT_EQ(told().exit_code, 0) << told().err;
        ASSERT_TRUE(write(print, options, "slices", false));
        EXPECT_EQ(told().exit_code, 1);
    }
}

/// A folder without digests is checked by the voxels of its pictures.
TEST_F(SliceFolder, WithoutDigestsTheHashOfTheVoxelsTells) {
    ASSERT_TRUE(write(make_sample({40, 30, 5}), {}));
    rapidjson::Document manifest;
    std::string text = read_file(scratch_ / "slices/manifest.json");
    text = text.substr(0, text.find(",\n  \"sha256\"")) + "\n}\n";
    scratch_.write("slices/manifest.json", text);
    fs::remove(scratch_ / "slices/SHA256SUMS");
    const auto verify = [&] {
        return run({program("openfab"), "verify", (scratch_ / "slices").string()});
    };
    EXPECT_EQ(verify().exit_code, 0);
    EXPECT_THAT(verify().err, HasSubstr(tools::messages::kWithoutDigests));
    fs::copy(scratch_ / "slices/slice_0003.png", scratch_ / "slices/slice_0002.png",
             fs::copy_options::overwrite_existing);
    EXPECT_EQ(verify().exit_code, 1);
}

TEST_F(SliceFolder, AnInterruptedPrintSaysSo) {
    ASSERT_TRUE(write(make_sample({6, 5, 3}), {}, "slices", false));
    EXPECT_THAT(read_file(scratch_ / "slices/manifest.json"), HasSubstr("\"complete\": false"));
    EXPECT_THAT(read_file(scratch_ / "slices/HANDOFF.txt"), HasSubstr("NOT COMPLETE"));
    EXPECT_TRUE(fs::exists(scratch_ / "slices/slice_0003.png"));
}

TEST_F(SliceFolder, AnEarlierPrintIsReplacedWhole) {
    ASSERT_TRUE(write(make_sample({6, 5, 9}), {}));
    ASSERT_TRUE(write(make_sample({6, 5, 3}), {}));
    EXPECT_TRUE(fs::exists(scratch_ / "slices/slice_0003.png"));
    EXPECT_FALSE(fs::exists(scratch_ / "slices/slice_0004.png"));
}

TEST_F(SliceFolder, NobodysFilesAreLost) {
    fs::create_directories(scratch_ / "slices");
    scratch_.write("slices/letter.txt", "dear");
    Result<void> done = write(make_sample({6, 5, 3}), {});
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
    EXPECT_THAT(done.error().text(), HasSubstr("letter.txt"));
    scratch_.write("plain", "a file");
    EXPECT_THAT(write(make_sample({6, 5, 3}), {}, "plain").error().text(),
                testing::Says(raster::messages::kOutputIsFile));
}

TEST_F(SliceFolder, AFolderThatCannotBeMadeIsTheOutsidesFault) {
    scratch_.write("plain", "a file");
    Result<void> done = write(make_sample({6, 5, 3}), {}, "plain/slices");
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kOutside);
}

TEST_F(SliceFolder, NamesHaveFixedDigits) {
    const auto name = [](int32_t z, int32_t slices, size_t file, raster::SliceFormat format) {
        raster::FolderOptions options;
        options.format = format;
        return raster::slice_file_name(z, file, make_sample({1, 1, slices}).info, options);
    };
    const auto png = raster::SliceFormat::kRgba, bmp = raster::SliceFormat::kBitmaps;
    EXPECT_EQ(name(0, 1, 0, png), "slice_0001.png");
    EXPECT_EQ(name(9998, 9999, 0, png), "slice_9999.png");
    EXPECT_EQ(name(0, 10000, 0, png), "slice_00001.png");
    EXPECT_EQ(name(9999, 10000, 0, png), "slice_10000.png");
    EXPECT_EQ(name(0, 12, 0, bmp), "slice_0001_1.bmp");
    EXPECT_EQ(name(11, 12, 2, bmp), "slice_0012_3.bmp");
    for (const char* ours :
         {"slice_0001.png", "slice_10000.png.part", "slice_0012_3.bmp", "slice_0012_63.bmp.part"})
        EXPECT_TRUE(raster::is_slice_name(ours)) << ours;
    for (const char* other : {"slice_.png", "slice_1.bmp", "slice_1_.bmp", "slice_1_2.png",
                              "slice_1.png.part2", "my_slice_1.png", "slice_1a.png"})
        EXPECT_FALSE(raster::is_slice_name(other)) << other;
}

/// Two a file: more than JSON of other kinds may have.
TEST(SliceManifest, ManifestsHaveDigestsOfVeryManyFiles) {
    constexpr int kFiles = 600'000;
    std::string text = "{";
    for (const char* key : {"sha256", "seals"}) {
        text += fmt::format("\"{}\": {{", key);
        for (int i = 0; i < kFiles; ++i)
            text += fmt::format("{}\"{}\": \"{:064x}\"", i == 0 ? "" : ",", i, i);
        text += "},";
    }
    text += "\"complete\": true}";
    EXPECT_TRUE(raster::manifest_is_complete(text));
    EXPECT_EQ(raster::manifest_seals(text).size(), size_t{kFiles});
}

}  // namespace
}  // namespace openfab::testing
