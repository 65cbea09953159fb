// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// GCVF files, unpacked by Python's zipfile and read by OpenImageIO, expat and our reader of meshes.

#include <OpenImageIO/imageio.h>
#include <expat.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>

#include "backends/gcvf/gcvf_sink.h"
#include "backends/gcvf/messages.h"
#include "backends/raster/folder_sink.h"
#include "mesh/load/load_mesh.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

/// The texts of an XML file by the paths of their elements, in order.
struct XmlTexts {
    std::map<std::string, std::vector<std::string>> texts;
    std::vector<std::string> path;
    std::string text;

    static XmlTexts read(const std::string& bytes) {
        XmlTexts out;
        XML_Parser parser = XML_ParserCreate(nullptr);
        XML_SetUserData(parser, &out);
        XML_SetElementHandler(
            parser,
            [](void* user, const XML_Char* name, const XML_Char**) {
                auto* x = static_cast<XmlTexts*>(user);
                x->path.push_back(x->path.empty() ? name : x->path.back() + "/" + name);
                x->text.clear();
            },
            [](void* user, const XML_Char*) {
                auto* x = static_cast<XmlTexts*>(user);
                x->texts[x->path.back()].push_back(x->text);
                x->path.pop_back();
            });
        XML_SetCharacterDataHandler(parser, [](void* user, const XML_Char* text, int size) {
            static_cast<XmlTexts*>(user)->text.append(text, static_cast<size_t>(size));
        });
        EXPECT_EQ(XML_Parse(parser, bytes.data(), static_cast<int>(bytes.size()), 1), XML_STATUS_OK)
            << bytes;
        XML_ParserFree(parser);
        return out;
    }
};

class Gcvf : public ::testing::Test {
  protected:
    Result<void> write(const SamplePrint& print, bool flip_x = false, bool complete = true,
                       const std::string& name = "part.gcvf") {
        gcvf::GcvfSink sink(scratch_ / name, flip_x);
        return print.send(&sink, complete);
    }
    /// Unpacks the file into a new folder.
    fs::path unpack(const std::string& folder = "unpacked") {
        const fs::path to = scratch_ / folder;
        const Outcome outcome = run({"/usr/bin/python3", "-m", "zipfile", "-e",
                                     (scratch_ / "part.gcvf").string(), to.string()});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return to;
    }
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
            names.push_back(entry.path().filename().string());
        return names;
    }

    ScratchFolder scratch_;
};

TEST_F(Gcvf, SlicesAreThoseOfAFolderOfPngs) {
    for (const int32_t bits : {4, 8}) {
        for (const bool flip : {false, true}) {
            SamplePrint print = make_sample({13, 7, 20}, bits);
            print.info.slice_begin = 3;
            print.info.slice_end = 18;
            ASSERT_TRUE(write(print, flip));
            raster::FolderOptions options;
            options.flip_x = flip;
            auto sink = raster::FolderSink::create(scratch_ / "slices", options);
            ASSERT_TRUE(sink);
            ASSERT_TRUE(print.send(sink->get()));
            const fs::path unpacked = unpack();
            for (int32_t z = 3; z < 18; ++z) {
                EXPECT_EQ(read_file(unpacked / fmt::format("slice_{}.png", z - 3)),
                          read_file(scratch_ / "slices" / fmt::format("slice_{:04}.png", z + 1)))
                    << z;
            }
            EXPECT_EQ(std::distance(fs::directory_iterator(unpacked), {}), 15 + 4);
            fs::remove_all(unpacked);
        }
    }
}

TEST_F(Gcvf, TheConfigurationHasTheNumbersOfThePrint) {
    SamplePrint print = make_sample({13, 7, 9});
    print.info.slice_begin = 2;
    ASSERT_TRUE(write(print));
    const XmlTexts xml = XmlTexts::read(read_file(unpack() / "ConfigFile.xml"));
    const auto texts = [&](const std::string& name) {
        const auto found = xml.texts.find("GCVF/" + name);
        return found == xml.texts.end() ? std::vector<std::string>() : found->second;
    };
    EXPECT_THAT(texts("Version"), ElementsAre("2"));
    EXPECT_THAT(texts("Resolution/XDpi"), ElementsAre("600"));
    EXPECT_THAT(texts("Resolution/YDpi"), ElementsAre("300"));
    EXPECT_THAT(texts("Resolution/SliceThicknessNanoMeter"), ElementsAre("27000"));
    EXPECT_THAT(texts("SliceDimensions/SliceWidth"), ElementsAre("13"));
    EXPECT_THAT(texts("SliceDimensions/SliceHeight"), ElementsAre("7"));
    EXPECT_THAT(texts("SliceRange/StartIndex"), ElementsAre("0"));
    EXPECT_THAT(texts("SliceRange/NumberOfSlices"), ElementsAre("7"));
    EXPECT_THAT(texts("BitDepth"), ElementsAre("4"));
    EXPECT_THAT(texts("MaxNumberOfColors"), ElementsAre("6"));
    EXPECT_THAT(texts("DataSemantics"), ElementsAre("Materials"));
    EXPECT_THAT(texts("CreationMode"), ElementsAre("MODEL_ONLY"));
    EXPECT_THAT(texts("ImageFilePrefix"), ElementsAre("slice_"));
    EXPECT_THAT(texts("MaterialList/BackGroundMaterialRGBA"), ElementsAre("0 0 0 0"));
    EXPECT_THAT(texts("MaterialList/Material/Name"), ElementsAre("white", "black", "clear \"x\""));
    EXPECT_THAT(texts("MaterialList/Material/RGBA"),
                ElementsAre("255 255 255 255", "0 0 0 255", "10 200 30 255"));
    std::vector<std::string> counts;
    for (uint8_t code = 1; code < 4; ++code) {
        counts.push_back(
            std::to_string(std::count(print.codes.begin() + 2 * 13 * 7, print.codes.end(), code)));
    }
    EXPECT_EQ(texts("MaterialList/Material/VoxelCount"), counts);
}

/// An F in the lower slices and its stem alone in the upper ones.
SamplePrint stepped_f() {
    SamplePrint print = make_letter_f(10, 30);
    for (int32_t z = 12; z < 30; ++z) {
        for (int32_t y = 0; y < 70; ++y) {
            for (int32_t x = 10; x < 50; ++x)
                print.at(x, y, z) = 0;
        }
    }
    print.info.slice_begin = 3;
    return print;
}

TEST_F(Gcvf, TheHeightMapHasTheHighestSliceOfEachColumn) {
    const SamplePrint print = stepped_f();
    for (const bool flip : {false, true}) {
        ASSERT_TRUE(write(print, flip));
        const fs::path unpacked = unpack(flip ? "flipped" : "straight");
        const auto in = OIIO::ImageInput::open((unpacked / "Zbuffer.png").string());
        ASSERT_NE(in, nullptr);
        ASSERT_EQ(in->spec().width, 50);
        ASSERT_EQ(in->spec().height, 70);
        ASSERT_EQ(in->spec().nchannels, 1);
        ASSERT_EQ(in->spec().format, OIIO::TypeDesc::UINT16);
        std::vector<uint16_t> tops(50 * 70);
        ASSERT_TRUE(in->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, tops.data()));
        for (int32_t y = 0; y < 70; ++y) {
            for (int32_t x = 0; x < 50; ++x) {
                const int32_t expected = x < 10 ? 26 : print.at(x, y, 3) != 0 ? 8 : 0;
                const int32_t column = flip ? 49 - x : x;
                ASSERT_EQ(tops[static_cast<size_t>((69 - y) * 50 + column)], expected)
                    << x << ' ' << y;
            }
        }
    }
}

/// Closed, in millimetres of build space, and by less than 8 voxels larger than the print.
TEST_F(Gcvf, TheMeshHoldsThePrint) {
    SamplePrint print = stepped_f();
    print.info.origin_mm = {1, 2, 3};
    ASSERT_TRUE(write(print));
    const Result<mesh::LoadedMesh> mesh = mesh::load_mesh(unpack() / "Mesh.stl", {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_TRUE(mesh->checks.edges.fine());
    Box3d box;
    double volume = 0;
    for (const Vec3d& p : mesh->mesh.positions)
        box.add(p);
    for (const auto& t : mesh->mesh.triangles) {
        const auto at = [&](int c) { return mesh->mesh.positions[static_cast<size_t>(t[c])]; };
        volume += dot(at(0), cross(at(1), at(2))) / 6;
    }
    const Vec3d lo{1, 2, 3.3}, hi{6, 9, 6};
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(box.lo[a], lo[a], 1e-5);
        EXPECT_NEAR(box.hi[a], hi[a], 1e-5);
    }
    // By cells of 8 voxels from slice 3 on: the columns of the stem end at x = 16 and go to the top;
    // the top bar is y >= 56, the middle one 24 <= y < 40, which end at x = 50 and 32 and, at slice
    // 12, in the second cell.
    const double voxels = 16 * 70 * 27 + 34 * 14 * 16 + 16 * 16 * 16;
    EXPECT_NEAR(volume, voxels * 1e-3, 0.01);
}

TEST_F(Gcvf, TheBoxIsThatOfThePrintedVoxels) {
    SamplePrint print = make_sample({13, 7, 9});
    print.info.slice_begin = 2;
    ASSERT_TRUE(write(print));
    const std::string bytes = read_file(unpack() / "MeshBbx.ktn");
    std::array<float, 6> box{};
    ASSERT_EQ(bytes.size(), sizeof box);
    std::memcpy(box.data(), bytes.data(), sizeof box);
    EXPECT_THAT(box, ElementsAre(0, 0, 0, 13, 7, 7));
}

TEST_F(Gcvf, APrintThatEndsEarlyLeavesWhatWasThere) {
    scratch_.write("part.gcvf", "earlier");
    const Result<void> done = write(make_sample({20, 20, 20}), false, false);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kInterrupted);
    EXPECT_THAT(done.error().text(), testing::Says(gcvf::messages::kEndedEarly));
    EXPECT_THAT(files(), UnorderedElementsAre("part.gcvf"));
    EXPECT_EQ(read_file(scratch_ / "part.gcvf"), "earlier");
}

TEST_F(Gcvf, AFullDiskLeavesNothing) {
    const SamplePrint print = make_sample({60, 60, 30});
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    for (const rlim_t limit : {1u << 10, 20u << 10}) {
        const rlimit small{limit, before.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
        const Result<void> done = write(print);
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
        ASSERT_FALSE(done) << limit;
        EXPECT_EQ(done.error().code, ErrorCode::kOutside);
        EXPECT_THAT(files(), UnorderedElementsAre()) << limit;
    }
    std::signal(SIGXFSZ, ignored);
    EXPECT_TRUE(write(print));
}

TEST_F(Gcvf, WhatItCannotHoldIsRefused) {
    SamplePrint many = make_sample({4, 4, 4});
    while (many.info.materials.size() < 7) {
        const auto key = static_cast<uint8_t>(many.info.materials.size());
        many.info.materials.push_back({"more", {key, 0, 0, 255}, {}, 1, ""});
    }
    SamplePrint same = make_sample({4, 4, 4});
    same.info.materials[1].key = same.info.materials[0].key;
    SamplePrint high = make_sample({4, 4, 4});
    high.info.size.z = high.info.slice_end = 70'000;
    const std::pair<SamplePrint*, ::testing::Matcher<std::string>> cases[] = {
        {&many, Says(gcvf::messages::kTooManyMaterials, 7, 6)},
        {&same, Says(gcvf::messages::kSameKeys)},
        {&high, Says(gcvf::messages::kTooManySlices, 70'000, 65'536)}};
    for (const auto& [print, why] : cases) {
        gcvf::GcvfSink sink(scratch_ / "part.gcvf", false);
        const Result<void> begun = sink.begin(print->info);
        ASSERT_FALSE(begun);
        EXPECT_EQ(begun.error().code, ErrorCode::kUserInput);
        EXPECT_THAT(begun.error().text(), why);
    }
    EXPECT_THAT(files(), UnorderedElementsAre());
}

TEST_F(Gcvf, TheSameBytesEachTime) {
    const SamplePrint print = make_sample({23, 14, 11});
    ASSERT_TRUE(write(print, false, true, "a.gcvf"));
    ASSERT_TRUE(write(print, false, true, "b.gcvf"));
    EXPECT_TRUE(read_file(scratch_ / "a.gcvf") == read_file(scratch_ / "b.gcvf"));
}

}  // namespace
}  // namespace openfab::testing
