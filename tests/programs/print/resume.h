// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print that tests kill, and what is left of it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "backends/boundary/messages.h"
#include "backends/common/messages.h"
#include "backends/common/part_file.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/ofr/ofr_sink.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/messages.h"
#include "base/sha256.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

#ifdef OPENFAB_SANITIZED
constexpr int kRounds = 1;
constexpr const char* kPitch = "0.2mm";
constexpr const char *kThird = "1", *kSixth = "2";  ///< drafts with about as many slices
#else
constexpr int kRounds = 5;
constexpr const char* kPitch = "0.08mm";
constexpr const char *kThird = "3", *kSixth = "6";
#endif
constexpr int kKillsARound = 4;

using Files = std::map<std::string, std::string>;

/// Maps names to contents.
inline Files files_of(const fs::path& folder) {
    Files files;
    if (!fs::exists(folder)) return files;  // killed before it was created
    for (const auto& entry : fs::directory_iterator(folder))
        files[entry.path().filename().string()] = read_file(entry.path());
    return files;
}

class Resume : public ::testing::Test {
  protected:
    Resume() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        write_world("world.fab.json", R"({"sphere": 26})");
    }
    void write_world(const std::string& name, const std::string& mesh,
                     const std::string& black = "#000000", const std::string& place = "") {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1,
  "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "Skin"}}}},
  "materials": {{
    "white": {{"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
    "black": {{"key": "{}", "preview": "#101010ff", "density_g_cm3": 1.18}}
  }},
  "meshes": {{"ball": {}}},
  "objects": {{"thing": {{"mesh": "ball", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "thing"{}}}]
}}
)",
                                         black, mesh, place));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments, const RunOptions& options = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path("world.fab.json"),
                                      "--voxel", kPitch};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return run(argv, options);
    }
    /// Kills the print with SIGKILL, unless it ends sooner.
    Outcome killed_print(std::vector<std::string> arguments, int after_us) {
        RunOptions options;
        options.signal = SIGKILL;
        options.interrupt_when = [after_us](int elapsed_ms, const Outcome&) {
            const int left = after_us - elapsed_ms * 1000;
            if (left > 5000) return false;
            std::this_thread::sleep_for(std::chrono::microseconds(std::max(left, 0)));
            return true;
        };
        return print(std::move(arguments), options);
    }
    /// Returns the number of complete slices of a file; fails if its header is unreadable.
    int whole_slices(const std::string& name) {
        const Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(path(name));
        if (!reader) {
            EXPECT_THAT(reader.error().text(),
                        ::testing::AnyOf(testing::Says(ofr::messages::kTooShort),
                                         testing::Says(ofr::messages::kCutShortInHeader),
                                         testing::Says(ofr::messages::kCannotOpen)));
            return 0;
        }
        Result<bool> more = true;
        while ((more = (*reader)->next()) && *more) {
        }
        const int whole = (*reader)->whole_slices();
        if (!more) {
            const Outcome info = run({program("openfab"), "info", path(name)});
            EXPECT_EQ(info.exit_code, 0) << info.err;
            EXPECT_THAT(info.out, testing::Says(tools::messages::kSlicesWhole, whole));
        }
        return whole;
    }
    /// An undisturbed print of the same world, and its duration.
    int undisturbed(const std::vector<std::string>& arguments) {
        const auto start = std::chrono::steady_clock::now();
        const Outcome outcome = print(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return static_cast<int>(std::chrono::duration_cast<std::chrono::microseconds>(
                                    std::chrono::steady_clock::now() - start)
                                    .count());
    }

    ScratchFolder scratch_;
    std::mt19937 random_{20260101};
};

}  // namespace openfab::testing
