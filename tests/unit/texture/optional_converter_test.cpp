// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/optional_converter.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>

#include "base/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tools/texture/command_line.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;

TEST(OptionalConverter, IsKnownByContentThenByName) {
    const testing::TempFolder folder;
    const auto program = [](const fs::path& volume) {
        const OptionalConverter* const found = optional_converter(volume, {});
        return std::string(found == nullptr ? "none" : found->program);
    };
    const std::string slice = std::string(128, '\0') + "DICM";
    EXPECT_EQ(program(folder.write("a", slice)), "openfab-texture-dicom");
    EXPECT_EQ(program(folder.write("b", " BDV" + std::string(4, '\0'))), "openfab-texture-vdb");
    EXPECT_EQ(program(folder.write("c.vdb", "")), "openfab-texture-vdb");
    EXPECT_EQ(program(folder.write("d.dcm", "")), "openfab-texture-dicom");
    EXPECT_EQ(program(folder.write("e.npy", "\x93NUMPY")), "none");
    EXPECT_EQ(program(folder.path() / "missing.png"), "none");
    const auto xdmf = [](const std::string& format) {
        return "<Xdmf><Domain><Grid><Geometry><DataItem Dimensions=\"3\" Format=\"" + format +
               "\">g.h5:/g</DataItem></Geometry></Grid></Domain></Xdmf>";
    };
    EXPECT_EQ(program(folder.write("g.xdmf", xdmf("HDF"))), "openfab-texture-hdf5");
    EXPECT_EQ(program(folder.write("h.xmf", xdmf("Binary"))), "none");
    EXPECT_EQ(program(folder.write("i.xdmf", "<Xdmf>")), "none");
    const std::string hdf("\x89HDF\r\n\x1a\n"), tables(100, '\0');
    EXPECT_EQ(program(folder.write("j.vtkhdf", hdf + tables + "VTKHDF")), "openfab-texture-hdf5");
    EXPECT_EQ(program(folder.write("k.h5", hdf + tables)), "none");
    fs::create_directory(folder.path() / "series");
    for (int i = 0; i < 20; ++i)
        folder.write("series/a" + std::to_string(i), "a note");
    folder.write("series/im1", slice);
    EXPECT_EQ(program(folder.path() / "series"), "openfab-texture-dicom");
}

TEST(OptionalConverter, ThatIsMissingIsNamedWithItsRemedy) {
    const OptionalConverter converter{"openfab-texture-none", "some", "install it"};
    std::string word = "x";
    char* argv[] = {word.data(), nullptr};
    const Error error = execute(converter, argv);
    EXPECT_EQ(error.code, ErrorCode::kOutside);
    EXPECT_EQ(error.text(), fmt::format(messages::kBuiltWithoutReader, "some") + "; install it");
}

TEST(Guarded, PassesErrorsOnAndOutlivesACrash) {
    const auto text = [](const std::function<Result<void>()>& make) {
        const Result<void> done = guarded(100'000'000, "scan", make);
        return done ? "no error" : done.error().text();
    };
    [[maybe_unused]] const auto crashed = [](const std::string& where) {
        return fmt::format(openfab::messages::kReaderCrashed, where, SIGABRT,
                           ::strsignal(SIGABRT)) +
               "; " + openfab::messages::kReaderCrashedHelp;
    };
    EXPECT_EQ(text([] { return Result<void>(); }), "no error");
    EXPECT_EQ(text([] { return Result<void>(user_error("wrong", "do right")); }),
              "wrong; do right");
#ifndef OPENFAB_SANITIZED  // which end otherwise
    EXPECT_EQ(text([]() -> Result<void> { std::abort(); }), crashed("scan"));
    EXPECT_EQ(text([]() -> Result<void> {
                  now_reading("series/im7");
                  std::abort();
              }),
              crashed("scan" + fmt::format(openfab::messages::kWithinFile, "im7")));
#endif
    EXPECT_NE(text([]() -> Result<void> { ::_exit(7); }), "no error");
}

TEST(Guarded, PassesNotesOn) {
    for (const bool fails : {false, true}) {
        ::testing::internal::CaptureStderr();
        const Result<void> done = guarded(100'000'000, "scan", [&]() -> Result<void> {
            tell("one");
            tell("two\nlines");
            return fails ? Result<void>(user_error("wrong")) : Result<void>();
        });
        EXPECT_EQ(::testing::internal::GetCapturedStderr(), "note: one\nnote: two\\nlines\n");
        EXPECT_EQ(done ? "no error" : done.error().text(), fails ? "wrong" : "no error");
    }
}

TEST(Notes, ReachStandardErrorWhileItIsClosedToLibraries) {
    const auto heard = [](const std::function<void()>& act) {
        ::testing::internal::CaptureStderr();
        act();
        return ::testing::internal::GetCapturedStderr();
    };
    const auto make = []() -> Result<void> {
        tell("left out");
        std::fputs("a library's own words\n", stderr);
        return {};
    };
    EXPECT_EQ(heard([&] { EXPECT_EQ(do_quietly(make), 0); }), "note: left out\n");
    EXPECT_EQ(heard([&] { EXPECT_TRUE(guarded(1'000'000'000, "a", make)); }), "note: left out\n");
    EXPECT_EQ(heard([&] {
                  EXPECT_EQ(do_quietly([&] { return guarded(1'000'000'000, "a", make); }), 0);
                  tell("afterwards");
              }),
              "note: left out\nnote: afterwards\n");
}

}  // namespace
}  // namespace openfab::tools
