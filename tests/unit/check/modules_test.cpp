// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/frontend/modules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "base/messages.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

class ModuleFiles : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / "openfab_modules_test";
        fs::create_directories(folder_ / "inner");
    }
    void TearDown() override { fs::remove_all(folder_); }
    void write(const std::string& name, const std::string& text) {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    /// Returns the diagnostics of a file.
    std::string check(const std::string& name, const frontend::FrontEndOptions& options = {}) {
        source::SourceManager sources;
        diag::Sink sink;
        std::string fault;
        const auto module = frontend::compile_to_ir(sources, folder_ / name, sink, &fault, options);
        EXPECT_EQ(module.has_value(), sink.errors() == 0 && fault.empty());
        return fault + diag::render_text(sink, sources);
    }

    fs::path folder_;
};

const std::string kProgram =
    "fablet A { @uniform { Material m; } @Volume() { MaterialComposition mc; mc.Set(m, f()); "
    "return mc; } }\n";

TEST_F(ModuleFiles, StandBesideTheImportingFileNotTheProgram) {
    write("main.fl", "import one;\n" + kProgram);
    write("one.fl", "float f() { return 1; }");
    EXPECT_EQ(check("main.fl"), "");
    // `inner/two.fl` is visible from `inner` only.
    write("inner/main.fl", "import two;\n" + kProgram);
    write("inner/two.fl", "import three;\nfloat f() { return g(); }");
    write("inner/three.fl", "float g() { return 1; }");
    EXPECT_EQ(check("inner/main.fl"), "");
    write("main.fl", "import two;\n" + kProgram);
    EXPECT_NE(check("main.fl").find("[unknown-module]"), std::string::npos);
}

TEST_F(ModuleFiles, AFileWinsOverTheLibrary) {
    for (const std::string& name : frontend::library_modules()) {
        write("main.fl", "import " + name + ";\n" + kProgram);
        write(name + ".fl", "float f() { return 1; }");
        EXPECT_EQ(check("main.fl"), "") << name;
    }
}

TEST_F(ModuleFiles, TheProgramIsNoModuleOfItsOwn) {
    write("main.fl", "import main;\n" + kProgram);
    EXPECT_NE(check("main.fl").find("main.fl:1:8: error: module `main` imports itself"),
              std::string::npos);
}

TEST_F(ModuleFiles, AnUnknownOneListsTheLibrary) {
    write("main.fl", "import qqqqqqqqqqqq;\n" + kProgram);
    const std::string text = check("main.fl");
    for (const std::string& name : frontend::library_modules())
        EXPECT_NE(text.find("`" + name + "`"), std::string::npos) << text;
}

TEST_F(ModuleFiles, WhatIsNoFileIsSaidToBeNone) {
    write("main.fl", "import odd;\n" + kProgram);
    const auto fault = [&] {
        const std::string text = check("main.fl");
        EXPECT_NE(text.find("main.fl:1:8: error: module `odd` cannot be read [bad-module]"),
                  std::string::npos)
            << text;
        fs::remove_all(folder_ / "odd.fl");
        return text;
    };
    ASSERT_EQ(mkfifo((folder_ / "odd.fl").c_str(), 0600), 0);
    EXPECT_THAT(fault(), testing::Says(messages::kKindNotAFile, messages::kKindPipe));
    fs::create_directory(folder_ / "odd.fl");
    EXPECT_THAT(fault(), testing::Says(messages::kKindNotAFile, messages::kKindFolder));
    fs::create_symlink("nowhere.fl", folder_ / "odd.fl");
    EXPECT_NE(fault().find("No such file"), std::string::npos);
}

TEST_F(ModuleFiles, CanBeCheckedAlone) {
    write("one.fl", "const float HALF = 0.5;\nfloat f() { return HALF; }");
    EXPECT_EQ(check("one.fl", {.need_fablet = false}), "");
    EXPECT_NE(check("one.fl").find("[no-fablet]"), std::string::npos);
    write("empty.fl", "// nothing\n");
    EXPECT_NE(check("empty.fl", {.need_fablet = false}).find("[no-fablet]"), std::string::npos);
    write("bad.fl", "float f() { return x; }");
    EXPECT_NE(check("bad.fl", {.need_fablet = false}).find("[unknown-name]"), std::string::npos);
}

}  // namespace
}  // namespace openfab::testing
