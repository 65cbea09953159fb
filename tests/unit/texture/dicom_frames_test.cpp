// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What the next frame of a file means: another place, or another time, echo, detector, energy window.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "tests/support/says/says.h"
#include "tests/unit/texture/dicom_groups.h"
#include "tools/dicom/messages.h"

namespace openfab::tools {
namespace {

/// Frames whose texels are all of one number, `100 * volume + slice`.
class DicomFrames : public DicomTest {
  protected:
    static Slice plain(size_t frames) {
        Slice slice;
        slice.width = slice.height = 1;
        slice.intercept = 0;
        slice.frames = frames;
        slice.position = {0.5, 0.5, 1};
        return slice;
    }
    void expect_values(const std::vector<float>& values, const VolumeOptions& options = {}) {
        const auto p = converted(options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), values);
    }
    void expect_several(const char* name, const std::string& values, const char* key) {
        EXPECT_EQ(trouble(),
                  fmt::format(messages::kFramesOfSeveral, name, values) + "; " +
                      (key[0] == '\0' ? std::string(messages::kFramesOfSeveralHelp)
                                      : fmt::format(messages::kFramesOfSeveralChoose, key)));
    }
    static VolumeOptions choosing(const std::string& key, double value) {
        VolumeOptions options;
        (key == "time"            ? options.time
         : key == "echo"          ? options.echo
         : key == "detector"      ? options.detector
         : key == "energy_window" ? options.energy_window
                                  : options.phase) = value;
        return options;
    }
};

/// What is said of a frame of the second volume, and how people see it.
struct Kind {
    std::function<std::string(int volume)> group;
    const char* name;
    const char* values;
    const char* key;
    std::pair<uint32_t, uint32_t> tag;
};

std::vector<Kind> kinds() {
    const auto real_in = [](uint32_t group, uint32_t item, uint32_t in, uint32_t at, double step) {
        return [=](int volume) {
            return sequence(group, item, {element(in, at, "FD", real(step * volume))});
        };
    };
    return {
        {[](int volume) {
             return sequence(
                 0x20, 0x9111,
                 {element(0x20, 0x9128, "UL", number(static_cast<uint64_t>(volume), 4))});
         },
         "times",
         "1, 2",
         "time",
         {0x20, 0x9128}},
        {real_in(0x18, 0x9114, 0x18, 0x9082, 2.5),
         "echoes",
         "1 (2.5), 2 (5)",
         "echo",
         {0x18, 0x9082}},
        {real_in(0x18, 0x9117, 0x18, 0x9087, 400), "b values", "400, 800", "", {0x18, 0x9087}},
        {real_in(0x18, 0x9118, 0x20, 0x9153, 40),
         "phases",
         "1 (40), 2 (80)",
         "phase",
         {0x20, 0x9153}},
        {[](int volume) {
             return sequence(0x18, 0x9226,
                             {element(8, 0x9208, "CS", volume == 1 ? "MAGNITUDE" : "PHASE")});
         },
         "components",
         "`MAGNITUDE`, `PHASE`",
         "",
         {8, 0x9208}},
    };
}

TEST_F(DicomFrames, OfSeveralVolumesOneIsChosen) {
    for (const Kind& kind : kinds()) {
        for (const bool interleaved : {false, true}) {
            SCOPED_TRACE(fmt::format("{} {}", kind.name, interleaved));
            Slice slice = plain(6);
            slice.is_placed = false;
            std::vector<std::string> items;
            for (int k = 0; k < 6; ++k) {
                const int volume = interleaved ? k % 2 + 1 : k / 3 + 1;
                const int place = interleaved ? k / 2 : k % 3;
                items.push_back(at_z(1 + 2 * place) + straight() + kind.group(volume));
                slice.pixels.push_back(static_cast<uint32_t>(100 * volume + place));
            }
            slice.groups = sequence(0x5200, 0x9230, items);
            write("frames", slice.bytes());
            expect_several(kind.name, kind.values, kind.key);
            if (kind.key[0] == '\0') continue;
            expect_values({100, 101, 102}, choosing(kind.key, 1));
            expect_values({200, 201, 202}, choosing(kind.key, 2));
            EXPECT_EQ(trouble(choosing(kind.key, 3)),
                      fmt::format(messages::kNoneChosen, kind.key, 3.0, kind.name, kind.values));
        }
    }
}

TEST_F(DicomFrames, VolumesInDifferentPlacesAreNotJoined) {
    for (const Kind& kind : kinds()) {
        if (kind.key == std::string("phase")) continue;  // places may be seen at different ones
        SCOPED_TRACE(kind.name);
        Slice slice = plain(4);
        slice.is_placed = false;
        std::vector<std::string> items;
        for (int k = 0; k < 4; ++k) {
            items.push_back(at_z(1 + 2 * k) + straight() + kind.group(k / 2 + 1));
            slice.pixels.push_back(static_cast<uint32_t>(k));
        }
        slice.groups = sequence(0x5200, 0x9230, items);
        write("frames", slice.bytes());
        expect_several(kind.name, kind.values, kind.key);
        if (kind.key[0] != '\0') expect_values({2, 3}, choosing(kind.key, 2));
    }
}

TEST_F(DicomFrames, APositionThatAllShareIsThatOfEach) {
    for (const Kind& kind : kinds()) {
        for (const bool distance : {false, true}) {
            SCOPED_TRACE(kind.name);
            Slice slice = plain(2);
            slice.is_placed = false;
            slice.pixels = {100, 200};
            std::string shared = at_z(3) + straight();
            if (distance)
                shared +=
                    sequence(0x28, 0x9110,
                             {element(0x18, 0x50, "DS", "3") + element(0x18, 0x88, "DS", "3") +
                              element(0x28, 0x30, "DS", "1\\1")});
            slice.groups = sequence(0x5200, 0x9229, {shared}) +
                           sequence(0x5200, 0x9230, {kind.group(1), kind.group(2)});
            write("frames", slice.bytes());
            expect_several(kind.name, kind.values, kind.key);
            if (kind.key[0] != '\0') expect_values({200}, choosing(kind.key, 2));
            // Without a word of what tells them apart.
            slice.groups = sequence(0x5200, 0x9229, {shared}) + sequence(0x5200, 0x9230, {"", ""});
            write("frames", slice.bytes());
            EXPECT_THAT(trouble(), testing::Says(messages::kSliceAtSamePlace));
        }
    }
}

TEST_F(DicomFrames, ADimensionOfAnotherKindIsNamed) {
    Slice slice = plain(2);
    slice.is_placed = false;
    slice.pixels = {100, 200};
    const std::string index = element(0x20, 0x9165, "AT", tags({{0x18, 0x9073}})) +
                              element(0x20, 0x9421, "LO", "durations");
    const auto values = [](uint64_t value) {
        return sequence(0x20, 0x9111, {element(0x20, 0x9157, "UL", number(value, 4))});
    };
    const std::string shared = sequence(0x5200, 0x9229, {at_z(3) + straight()});
    slice.groups =
        sequence(0x20, 0x9222, {index}) + shared + sequence(0x5200, 0x9230, {values(1), values(2)});
    write("frames", slice.bytes());
    expect_several("durations", "1, 2", "");
}

TEST_F(DicomFrames, NuclearMedicineSaysWhichSliceEachFrameIs) {
    struct List {
        uint32_t item;
        const char* name;
        const char* key;
    };
    for (const List& list :
         {List{0x70, "times", "time"}, List{0x10, "energy windows", "energy_window"},
          List{0x20, "detectors", "detector"}, List{0x30, "phases", "phase"},
          List{0x100, "times", "time"}, List{0x60, "R-R intervals", ""}}) {
        SCOPED_TRACE(list.name);
        Slice slice = plain(6);
        slice.pixels = {100, 101, 102, 200, 201, 202};
        const std::string slices = shorts({1, 2, 3, 1, 2, 3}), volumes = shorts({1, 1, 1, 2, 2, 2});
        slice.groups = element(0x18, 0x88, "DS", "3") +
                       element(0x28, 9, "AT", tags({{0x54, list.item}, {0x54, 0x80}})) +
                       element(0x54, list.item, "US", volumes) + element(0x54, 0x80, "US", slices);
        write("frames", slice.bytes());
        expect_several(list.name, "1, 2", list.key);
        if (list.key[0] != '\0') {
            expect_values({200, 201, 202}, choosing(list.key, 2));
            EXPECT_EQ(origin(*converted(choosing(list.key, 2))), (Vec3d{0, 0, -0.5}));
        }
    }
    // The lists say the same without a pointer.
    Slice unsaid = plain(4);
    unsaid.pixels = {102, 100, 202, 200};
    unsaid.groups = element(0x18, 0x88, "DS", "3") +
                    element(0x54, 0x70, "US", shorts({1, 1, 2, 2})) +
                    element(0x54, 0x80, "US", shorts({2, 1, 2, 1}));
    write("frames", unsaid.bytes());
    expect_several("times", "1, 2", "time");
    expect_values({200, 202}, choosing("time", 2));
    // Slices in another order than their frames, and without a distance but their thickness.
    Slice slice = plain(3);
    slice.pixels = {102, 100, 101};
    slice.groups = element(0x18, 0x50, "DS", "2") + element(0x28, 9, "AT", tags({{0x54, 0x80}})) +
                   element(0x54, 0x80, "US", shorts({3, 1, 2}));
    write("frames", slice.bytes());
    expect_values({100, 101, 102});
    EXPECT_EQ(told(), "note: " + fmt::format(messages::kContiguous, "frames") + "\n");
    slice.groups = element(0x18, 0x50, "DS", "2") + element(0x28, 9, "AT", tags({{0x54, 0x80}})) +
                   element(0x54, 0x80, "US", shorts({1, 2}));
    write("frames", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kFrameList, "slices", "3"));
    // Views from around are no slices.
    slice.groups = element(0x18, 0x50, "DS", "2") + element(0x18, 0x88, "DS", "2") +
                   element(0x28, 9, "AT", tags({{0x54, 0x90}})) +
                   element(0x54, 0x90, "US", shorts({1, 2, 3}));
    write("frames", slice.bytes());
    expect_several("angular views", "1, 2, 3", "");
}

TEST_F(DicomFrames, FramesThatFollowInTimeAreNoSlices) {
    const std::string thick = element(0x18, 0x50, "DS", "3") + element(0x18, 0x88, "DS", "3");
    for (const uint32_t item : {0x1063, 0x1065}) {
        for (const bool pointed : {true, false}) {
            Slice slice = plain(3);
            slice.pixels = {10, 20, 30};
            slice.groups = thick + element(0x18, item, "DS", item == 0x1063 ? "40" : "0\\40\\40");
            if (pointed) slice.groups += element(0x28, 9, "AT", tags({{0x18, item}}));
            write("cine", slice.bytes());
            expect_several("times", "1, 2, 3", "time");
            expect_values({20}, choosing("time", 2));
        }
    }
    Slice slice = plain(3);
    slice.pixels = {10, 20, 30};
    slice.groups = thick + element(0x28, 9, "AT", tags({{0x18, 0x1234}}));
    write("cine", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kFrameIncrement, "0018", "1234"));
    // The thickness of a plane is no distance.
    slice.groups = element(0x18, 0x50, "DS", "3");
    write("cine", slice.bytes());
    EXPECT_THAT(trouble(), HasSubstr(messages::kNoSliceSpacing));
}

TEST_F(DicomFrames, SliceLocationsArePlaces) {
    Slice slice = plain(3);
    slice.pixels = {10, 30, 20};
    slice.groups =
        element(0x18, 0x2005, "DS", "5\\9\\7") + element(0x28, 9, "AT", tags({{0x18, 0x2005}}));
    write("frames", slice.bytes());
    expect_values({10, 20, 30});
    EXPECT_EQ(origin(*converted()), (Vec3d{0, 0, 0}));
}

TEST_F(DicomFrames, UltrasoundLiesInItsVolume) {
    Slice slice = plain(3);
    slice.is_placed = false;
    std::vector<std::string> items;
    for (const int k : {2, 1, 0}) {
        slice.pixels.push_back(static_cast<uint32_t>(10 * k));
        items.push_back(
            sequence(0x20, 0x930e,
                     {element(0x20, 0x9301, "FD", real(0.5) + real(0.5) + real(1 + 2.0 * k))}));
    }
    std::string axes;
    for (const double one : {1, 0, 0, 0, 1, 0})
        axes += real(one);
    slice.groups =
        sequence(0x5200, 0x9229, {sequence(0x20, 0x930f, {element(0x20, 0x9302, "FD", axes)})}) +
        sequence(0x5200, 0x9230, items);
    write("us", slice.bytes());
    expect_values({0, 10, 20});
    EXPECT_EQ(origin(*converted()), (Vec3d{0, 0, 0}));
    EXPECT_EQ(told(), "note: " + fmt::format(messages::kPlaceOfVolume, "us") + "\n");
}

TEST_F(DicomFrames, StacksOfAFileAreListed) {
    Slice slice = plain(4);
    slice.is_placed = false;
    slice.pixels = {1, 2, 3, 4};
    std::vector<std::string> items;
    for (int k = 0; k < 4; ++k) {
        items.push_back(at_z(1 + 2 * k + (k > 1 ? 40 : 0)) + straight() +
                        sequence(0x20, 0x9111, {element(0x20, 0x9056, "SH", k > 1 ? "2" : "1")}));
    }
    slice.groups = sequence(0x5200, 0x9230, items);
    write("frames", slice.bytes());
    EXPECT_THAT(trouble(), testing::Says(messages::kNotOfOneSeries, "grid"));
    VolumeOptions options;
    options.field = "1/2";
    expect_values({3, 4}, options);
}

TEST_F(DicomFrames, FilesInOnePlaceAreToldApart) {
    struct Said {
        const char* name;
        const char* key;
        const char* values;
        std::function<std::string(int volume, int place)> element_of;
    };
    const std::vector<Said> all{
        {"echoes", "echo", "1, 2",
         [](int volume, int) { return element(0x18, 0x86, "IS", std::to_string(volume)); }},
        {"times", "time", "1, 2",
         [](int volume, int) { return element(0x20, 0x100, "IS", std::to_string(volume)); }},
        // Slices are taken one after the other, so that no two are of the same time.
        {"times", "time", "1 (100), 2 (140)",
         [](int volume, int place) {
             return element(0x18, 0x1060, "DS", std::to_string(60 + 40 * volume + place));
         }},
        {"echoes", "echo", "1 (2.5), 2 (5)",
         [](int volume, int) { return element(0x18, 0x81, "DS", decimals({2.5 * volume})); }},
        {"image types", "", "`M`, `P`",
         [](int volume, int) { return element(8, 8, "CS", volume == 1 ? "M" : "P"); }},
    };
    for (const Said& said : all) {
        SCOPED_TRACE(said.values);
        for (int k = 0; k < 6; ++k) {
            Slice slice = plain(1);
            slice.position.z = 1 + 2 * (k % 3);
            slice.pixels = {static_cast<uint32_t>(100 * (k / 3 + 1) + k % 3)};
            slice.groups = said.element_of(k / 3 + 1, k % 3);
            write(fmt::format("im{}", k), slice.bytes());
        }
        expect_several(said.name, said.values, said.key);
        if (said.key[0] == '\0') continue;
        expect_values({100, 101, 102}, choosing(said.key, 1));
        expect_values({200, 201, 202}, choosing(said.key, 2));
        EXPECT_THAT(trouble(choosing(said.key, 3)),
                    testing::Says(messages::kNoneChosen, said.key, "3"));
    }
    EXPECT_EQ(trouble(choosing("detector", 1)),
              fmt::format(messages::kNothingToChoose, "detector") + "; " + messages::kLeaveItOut);
}

}  // namespace
}  // namespace openfab::tools
