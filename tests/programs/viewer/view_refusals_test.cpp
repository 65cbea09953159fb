// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` of a world: what is refused, and what ends.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <thread>

#include "runtime/part/messages.h"
#include "tests/programs/viewer/view_world.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "tools/viewer/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

/// The processes other than this one that have `text` in their command line.
std::vector<std::string> processes_with(const std::string& text) {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        const std::string name = entry.path().filename();
        if (name.find_first_not_of("0123456789") != std::string::npos ||
            name == std::to_string(::getpid()))
            continue;
        const std::string line = read_file(entry.path() / "cmdline");
        if (line.find(text) != std::string::npos) found.push_back(line);
    }
    return found;
}

TEST_F(ViewWorld, WhatIsWrongIsRefusedAndChangesNothing) {
    const Viewer viewer({world(), "--watch"}, cache());
    const JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    const std::vector<std::tuple<std::string, std::string, int>> wrong = {
        {"/api/set", "", 400},
        {"/api/set", "[]", 400},
        {"/api/set", "{", 400},
        {"/api/set", std::string(100, '['), 400},
        {"/api/set", R"({"object": "cube", "uniform": "share"})", 400},
        {"/api/set", R"({"object": "cube", "uniform": 1, "value": 1})", 400},
        {"/api/set", R"({"object": "ball", "uniform": "share", "value": 1})", 422},
        {"/api/set", R"({"object": "cube", "uniform": "none", "value": 1})", 422},
        {"/api/set", R"({"object": "cube", "uniform": "share=1 --output x", "value": 1})", 422},
        {"/api/set", R"({"object": "cube", "uniform": "share", "value": {"a": 1}})", 422},
        {"/api/set", R"({"object": "cube", "uniform": "share", "value": []})", 422},
        {"/api/set", R"({"object": "cube", "uniform": "share", "value": null})", 422},
        {"/api/draft", R"({"draft": -1})", 400},
        {"/api/draft", R"({"draft": 1.5})", 400},
        {"/api/draft", R"({"draft": 1001})", 400},
        {"/api/draft", R"({"draft": "4"})", 400},
        {"/api/check", R"({"fablet": 1, "text": ""})", 422},
        {"/api/check", R"({"fablet": -1, "text": ""})", 400},
        {"/api/check", R"({"fablet": "../halves.fl", "text": ""})", 400},
        {"/api/source", R"({"fablet": 0, "text": "x"})", 400},
        {"/api/source", R"({"fablet": 0, "text": "x", "stamp": "0"})", 422},
        {"/api/source", R"({"fablet": 7, "text": "x", "stamp": "0"})", 422},
        {"/api/source",
         R"({"fablet": 0, "text": ")" + std::string(3 << 20, 'x') + R"(", "stamp": "0"})", 413},
        {"/api/nothing", "{}", 404}};
    for (const auto& [path, body, status] : wrong) {
        const HttpAnswer answer = viewer.post(path, body);
        EXPECT_EQ(answer.status, status) << path << " " << body.substr(0, 80) << "\n"
                                         << answer.body;
    }
    for (const char* path :
         {"/api/source?fablet=1", "/api/source?fablet=x", "/api/source", "/api/set", "/api/write"})
        EXPECT_NE(viewer.get(path).status, 200) << path;
    EXPECT_EQ(read_file(world()), world_text());
    EXPECT_EQ(read_file(scratch_ / "halves.fl"), kFablet);
    const JsonValue after = viewer.get("/api/state").json();
    EXPECT_EQ(member(after, "generation").number, member(state, "generation").number);
    // Out of the uniform's limits: the print says so, with the rule.
    ASSERT_EQ(
        viewer.post("/api/set", R"({"object": "cube", "uniform": "share", "value": 2})").status,
        200);
    const JsonValue failed = viewer.wait_for(
        [](const JsonValue& s) { return member(member(s, "live"), "phase").text == "failed"; });
    EXPECT_THAT(member(member(failed, "live"), "message").text, HasSubstr("share"));
    // It is told at the uniform, once.
    const JsonValue details = viewer.get("/api/live").json();
    EXPECT_THAT(member(uniform_of(details, "share"), "trouble").text,
                Says(part::messages::kIsGivenNumber, "float share", "Halves", 2));
    EXPECT_EQ(uniform_of(details, "a").find("trouble"), nullptr);
    EXPECT_EQ(member(details, "message").text, "");
    // What the print refused is not written: the world would not print any more.
    EXPECT_FALSE(member(member(failed, "live"), "writable").boolean);
    const HttpAnswer written = viewer.post("/api/write", "{}");
    EXPECT_NE(written.status, 200);
    EXPECT_THAT(written.body, HasSubstr("failed"));
    EXPECT_EQ(read_file(world()), world_text());
    ASSERT_EQ(viewer.post("/api/revert", "{}").status, 200);
    viewer.wait_for([&](const JsonValue& s) { return has_done(s, 2); });
}

TEST_F(ViewWorld, ASourceThatBecomesALinkIsNotFollowedOutOfTheWorldsFolder) {
    const ScratchFolder elsewhere;
    elsewhere.write("secret.fl", "// a secret\n");
    const Viewer viewer({world(), "--watch"}, cache());
    viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    ASSERT_EQ(viewer.get("/api/source?fablet=0").status, 200);
    std::filesystem::remove(scratch_ / "halves.fl");
    std::filesystem::create_symlink(elsewhere / "secret.fl", scratch_ / "halves.fl");
    const HttpAnswer answer = viewer.get("/api/source?fablet=0");
    EXPECT_NE(answer.status, 200);
    EXPECT_EQ(answer.body.find("a secret"), std::string::npos);
}

TEST_F(ViewWorld, PrintsEndWithAServerThatIsKilled) {
    // A print of minutes.
    std::string large = world_text();
    large.replace(large.find("[2, 2, 2]"), 9, "[200, 200, 200]");
    large.replace(large.find("[3, 0, 0]"), 9, "[300, 0, 0]");
    scratch_.write("cube.fab.json", large);
    for (const int signal : {SIGHUP, SIGKILL}) {
        RunOptions options;
        options.signal = signal;
        options.environment = {{"OPENFAB_CACHE", cache()}};
        options.interrupt_when = [&](int, const Outcome&) {
            return processes_with(world()).size() >= 2;  // the server and its print
        };
        const Outcome outcome =
            run({program("openfab"), "view", world(), "--watch", "--draft", "1"}, options);
        EXPECT_EQ(outcome.exit_code, signal == SIGKILL ? 128 + SIGKILL : 130) << outcome.err;
        // Until ctest's limit.
        while (!processes_with(world()).empty())
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

TEST_F(ViewWorld, WithoutWatchNothingIsWritten) {
    const Viewer viewer({world(), "--set", "cube.share=1"}, cache());
    const JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    EXPECT_EQ(share(state), 1);
    EXPECT_FALSE(member(member(state, "live"), "watch").boolean);
    for (const char* path :
         {"/api/set", "/api/draft", "/api/revert", "/api/write", "/api/check", "/api/source"})
        EXPECT_EQ(viewer.post(path, "{}").status, 403) << path;
}

}  // namespace
}  // namespace openfab::testing
