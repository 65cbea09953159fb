// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiles every .fl file of pass/, warn/ and fail/ and compares its diagnostics with those that
// its comments expect. With OPENFAB_UPDATE=1 in the environment the comments are rewritten instead;
// review what changed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "compiler/frontend/frontend.h"
#include "tests/support/lang/expectations.h"
#include "tests/support/places/places.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

fs::path folder() {
    return source_dir() / "tests" / "lang";
}

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> programs(const char* kind) {
    std::vector<fs::path> out;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder() / kind)) {
        if (entry.path().extension() == ".fl") out.push_back(entry.path());
    }
    std::sort(out.begin(), out.end());
    return out;
}

struct Compiled {
    source::SourceManager sources;
    diag::Sink sink;
    bool ok = false;
};

void compile(const std::string& name, const std::string& text, Compiled* out) {
    const uint32_t file = out->sources.add(name, text, folder() / "modules");
    const std::optional<ir::Module> module = frontend::compile_to_ir(out->sources, file, out->sink);
    out->ok = module.has_value();
    if (!module) return;
    for (const ir::Fablet& fablet : module->fablets) {
        EXPECT_EQ(ir::verify(fablet.surface), "") << name;
        EXPECT_EQ(ir::verify(fablet.volume), "") << name;
    }
}

void update(const fs::path& path) {
    for (int round = 0; round < 2; ++round) {
        const std::string text = read(path);
        Compiled c;
        compile(path.filename().string(), text, &c);
        std::ofstream(path, std::ios::binary) << with_expectations(text, c.sink, c.sources);
    }
}

void check(const char* kind) {
    const std::vector<fs::path> files = programs(kind);
    ASSERT_FALSE(files.empty());
    for (const fs::path& path : files) {
        SCOPED_TRACE(path.filename().string());
        if (std::getenv("OPENFAB_UPDATE") != nullptr) update(path);
        const std::string text = read(path);
        Compiled c;
        compile(path.filename().string(), text, &c);
        EXPECT_EQ(difference(expected_diagnostics(text), actual_diagnostics(c.sink, c.sources)),
                  "");
        EXPECT_EQ(c.ok, c.sink.errors() == 0);
        EXPECT_EQ(c.sink.errors() != 0, std::string_view(kind) == "fail");
        EXPECT_EQ(c.sink.errors() + c.sink.warnings() == 0, std::string_view(kind) == "pass");
    }
}

TEST(Lang, Pass) {
    check("pass");
}
TEST(Lang, Warn) {
    check("warn");
}
TEST(Lang, Fail) {
    check("fail");
}

/// Returns the word in the last brackets of a message.
std::string id_of(const std::string& line) {
    const size_t open = line.rfind(" [");
    return line.back() == ']' && open != std::string::npos
               ? line.substr(open + 2, line.size() - open - 3)
               : "";
}

TEST(Lang, EveryIdHasATest) {
    std::set<std::string> tested;
    for (const char* kind : {"warn", "fail"}) {
        for (const fs::path& path : programs(kind)) {
            for (const std::string& line : expected_diagnostics(read(path)))
                tested.insert(id_of(line));
        }
    }
    // Diagnostics that a program cannot cause are tested elsewhere.
    std::string others;
    for (const char* name : {"golden/frontend/frontend_golden_test.cpp",
                             "exec/build_command_test.cpp", "python/test_jacobian.py"}) {
        others += read(folder().parent_path() / name);
    }
    for (int id = 0; id < static_cast<int>(diag::Id::kCount); ++id) {
        const std::string text = diag::id_text(static_cast<diag::Id>(id));
        if (others.find("[" + text + "]") != std::string::npos) continue;
        EXPECT_EQ(tested.count(text), 1u) << "no test expects [" << text << "]";
    }
}

}  // namespace
}  // namespace openfab::testing
