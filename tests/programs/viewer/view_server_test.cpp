// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` as a server: nobody else is answered, and what is asked wrongly is refused.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <thread>

#include "backends/ofr/messages.h"
#include "backends/read/messages.h"
#include "tests/programs/viewer/view_fixtures.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/viewer/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class ViewServer : public PrintFixture {};

TEST_F(ViewServer, ThePageComesWithoutATokenAndRunsNothingButItself) {
    const Viewer viewer({write(print_, "a.ofr")});
    for (const auto& [name, type] : {std::pair{"/", "text/html; charset=utf-8"},
                                     {"/main.js", "text/javascript; charset=utf-8"},
                                     {"/style.css", "text/css; charset=utf-8"},
                                     {"/icon.svg", "image/svg+xml"}}) {
        const HttpAnswer answer = viewer.ask("GET", name, {viewer.host_header()});
        EXPECT_EQ(answer.status, 200) << name;
        EXPECT_EQ(answer.headers.at("content-type"), type);
        EXPECT_THAT(answer.headers.at("content-security-policy"), HasSubstr("default-src 'none'"));
        EXPECT_EQ(answer.headers.count("access-control-allow-origin"), 0u);
    }
    // Nothing in it comes from elsewhere.
    EXPECT_EQ(viewer.get("/").body.find("http"), std::string::npos);
    for (const char* nowhere :
         {"/../a.ofr", "/%2e%2e/a.ofr", "/a.ofr", "//etc/passwd", "/main.js/"})
        EXPECT_EQ(viewer.get(nowhere).status, 404) << nowhere;
}

TEST_F(ViewServer, WithoutTheTokenOrUnderAnotherNameNothingIsAnswered) {
    const Viewer viewer({write(print_, "a.ofr")});
    const std::vector<std::string> all = {"/api/state",
                                          tile_path("axis=z&at=0&lu=0&lv=0&u=0&v=0"),
                                          "/api/pick?generation=1&print=0&x=0&y=0&z=0",
                                          "/api/slice?generation=1&print=0&z=0",
                                          "/api/volume?generation=1&print=0&colors=00000000",
                                          "/api/live",
                                          "/api/source?fablet=0"};
    for (const std::string& path : all) {
        EXPECT_EQ(viewer.ask("GET", path, {viewer.host_header()}).status, 403) << path;
        EXPECT_EQ(viewer.ask("GET", path, {viewer.host_header(), "X-OpenFab-Token: "}).status, 403);
        std::string wrong = viewer.token_header();
        wrong.back() = wrong.back() == '0' ? '1' : '0';
        EXPECT_EQ(viewer.ask("GET", path, {viewer.host_header(), wrong}).status, 403) << path;
    }
    for (const char* path : {"/api/set", "/api/source", "/api/edit", "/api/try", "/api/print"})
        EXPECT_EQ(viewer.ask("POST", path, {viewer.host_header()}, "{}").status, 403) << path;
    const std::string port = std::to_string(viewer.port());
    for (const std::string& host : std::vector<std::string>{
             "evil.example:" + port, "127.0.0.1.evil.example:" + port, "127.0.0.1:1", "127.0.0.1",
             "", "localhost", "192.168.0.1:" + port, "evil.example:80@127.0.0.1:" + port}) {
        const HttpAnswer answer = viewer.ask("GET", "/", {"Host: " + host, viewer.token_header()});
        EXPECT_EQ(answer.status, 421) << host;
    }
    for (const std::string& origin : std::vector<std::string>{
             "null", "http://evil.example", "http://127.0.0.1", "https://127.0.0.1:" + port,
             "http://localhost:" + port, "http://127.0.0.1:" + port}) {
        const HttpAnswer answer =
            viewer.ask("GET", "/api/state",
                       {"Host: 127.0.0.1:" + port, "Origin: " + origin, viewer.token_header()});
        EXPECT_EQ(answer.status, origin == "http://127.0.0.1:" + port ? 200 : 403) << origin;
    }
    EXPECT_EQ(viewer.ask("GET", "/", {}).status, 421);
    EXPECT_EQ(viewer.ask("GET", "/", {"Host: localhost:" + port}).status, 200);
    for (const char* method : {"PUT", "DELETE", "OPTIONS", "PATCH"}) {
        EXPECT_EQ(
            viewer.ask(method, "/api/state", {viewer.host_header(), viewer.token_header()}).status,
            405)
            << method;
    }
}

TEST_F(ViewServer, WrongRequestsAreAnsweredAndNothingBreaks) {
    const Viewer viewer({write(print_, "a.ofr")});
    const std::string fine = "axis=z&at=0&lu=0&lv=0&u=0&v=0";
    const std::vector<std::pair<std::string, int>> wrong = {
        {tile_path("axis=w&at=0&lu=0&lv=0&u=0&v=0"), 400},
        {tile_path("axis=z&at=-1&lu=0&lv=0&u=0&v=0"), 400},
        {tile_path("axis=z&at=37&lu=0&lv=0&u=0&v=0"), 404},
        {tile_path("axis=x&at=517&lu=0&lv=0&u=0&v=0"), 404},
        {tile_path("axis=z&at=99999999999999999999&lu=0&lv=0&u=0&v=0"), 400},
        {tile_path("axis=z&at=0x1&lu=0&lv=0&u=0&v=0"), 400},
        {tile_path("axis=z&at=0&lu=13&lv=0&u=0&v=0"), 400},
        {tile_path("axis=z&at=0&lu=0&lv=-1&u=0&v=0"), 400},
        {tile_path("axis=z&at=0&lu=0&lv=0&u=2&v=0"), 404},
        {tile_path("axis=z&at=0&lu=12&lv=12&u=2048&v=2048"), 404},
        {tile_path("axis=z&at=0&lu=0&lv=0&u=0&v=0&coarse=4"), 400},
        {tile_path("axis=y&at=0&lu=0&lv=0&u=0&v=0&coarse=65"), 400},
        {tile_path("axis=z&at=0&lu=0&lv=0&u=0"), 400},
        {"/api/tile?generation=1&print=0&" + fine, 400},
        {"/api/tile?generation=1&print=0&colors=&" + fine, 400},
        {"/api/tile?generation=1&print=0&colors=0000000&" + fine, 400},
        {"/api/tile?generation=1&print=0&colors=0000000g&" + fine, 400},
        {"/api/tile?generation=1&print=0&colors=" + std::string(8 * 257, '0') + "&" + fine, 400},
        {"/api/tile?generation=2&print=0&colors=00000000&" + fine, 409},
        {"/api/tile?generation=1&print=1&colors=00000000&" + fine, 404},
        {"/api/tile?generation=1&print=diff&colors=00000000&" + fine, 404},
        {"/api/tile?generation=1&print=../a.ofr&colors=00000000&" + fine, 400},
        {"/api/pick?generation=1&print=0&x=517&y=0&z=0", 404},
        {"/api/pick?generation=1&print=0&x=0&y=0", 400},
        {"/api/slice?generation=1&print=0&z=37", 422},
        {"/api/volume?generation=1&print=diff&colors=00000000", 404},
        {"/api/volume?generation=1&print=0&colors=00000000&known=x", 400},
        {"/api/live", 404},
        {"/api/", 404},
        {"/api/tile/", 404}};
    for (const auto& [path, status] : wrong) {
        const HttpAnswer answer = viewer.get(path);
        EXPECT_EQ(answer.status, status) << path << "\n" << answer.body;
        EXPECT_NE(member(answer.json(), "error").text, "") << path;
    }
    EXPECT_EQ(viewer.post("/api/set", "{}").status, 404);
    EXPECT_EQ(viewer.post("/api/state2", "{}").status, 404);
    EXPECT_EQ(viewer.get("/" + std::string(20000, 'x')).status, 414);
    EXPECT_EQ(viewer.get(tile_path(fine)).status, 200);
}

TEST_F(ViewServer, OversizeAndMalformedRequestsAreRefused) {
    const Viewer viewer({write(print_, "a.ofr")});
    EXPECT_EQ(viewer.post("/api/set", std::string(5 << 20, ' ')).status, 413);
    const std::string head = "POST /api/set HTTP/1.1\r\nConnection: close\r\n" +
                             viewer.host_header() + "\r\n" + viewer.token_header() + "\r\n";
    send_raw(viewer.port(), head + "Content-Length: 99999999999999\r\n\r\n");
    std::string chunked = head + "Transfer-Encoding: chunked\r\n\r\n";
    for (int i = 0; i < 80; ++i)
        chunked += "10000\r\n" + std::string(0x10000, ' ') + "\r\n";
    send_raw(viewer.port(), chunked + "0\r\n\r\n");
    send_raw(viewer.port(), std::string(1000, '\0') + "\r\n\r\n");
    send_raw(viewer.port(), "GET\r\n\r\n");
    std::string many = "GET / HTTP/1.1\r\nConnection: close\r\n" + viewer.host_header() + "\r\n";
    for (int i = 0; i < 1000; ++i)
        many += fmt::format("X-{}: y\r\n", i);
    EXPECT_THAT(send_raw(viewer.port(), many + "\r\n").substr(0, 13), HasSubstr(" 4"));
    EXPECT_EQ(viewer.get("/api/state").status, 200);
}

TEST_F(ViewServer, RangesAreIgnored) {
    const Viewer viewer({write(print_, "a.ofr")});
    std::string ranges = "Range: bytes=0-";
    for (int i = 1; i < 1000; ++i)
        ranges += fmt::format(",{}-", i);
    for (const std::string& range : {std::string("Range: bytes=5-9"), ranges}) {
        const HttpAnswer page = viewer.ask("GET", "/plane.js", {viewer.host_header(), range});
        EXPECT_EQ(page.status, 200);
        EXPECT_EQ(page.body, viewer.ask("GET", "/plane.js", {viewer.host_header()}).body);
        const HttpAnswer state =
            viewer.ask("GET", "/api/state", {viewer.host_header(), viewer.token_header(), range});
        EXPECT_EQ(state.status, 200);
        state.json();
    }
}

/// As long as the new one is not answered: a server that waits for the others hangs, which ctest
/// ends.
TEST_F(ViewServer, SilentAndSlowConnectionsKeepNoNewOneFromItsAnswer) {
    const Viewer viewer({write(print_, "a.ofr")});
    std::vector<int> others;
    for (int i = 0; i < 500; ++i) {
        others.push_back(connect_to(viewer.port()));
        if (i >= 400) send_bytes(others.back(), "GET /api/state HTTP/1.1\r\nX: ");
    }
    std::atomic<bool> answered{false};
    std::thread slow([&] {
        while (!answered) {
            for (size_t i = 400; i < others.size(); ++i)
                send_bytes(others[i], "y");
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    });
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(viewer.get("/api/state").status, 200);
    answered = true;
    slow.join();
    for (const int other : others)
        ::close(other);
}

TEST_F(ViewServer, WhatCannotBeShownIsRefusedWithAReason) {
    scratch_.write("text.ofr", "not a print");
    std::filesystem::create_directory(path("odd"));
    scratch_.write("odd/manifest.json", R"({"pixels": [8, 1e30], "slices_planned": 1})");
    const std::string print = write(print_, "a.ofr");
    const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
        {{path("none.ofr")}, viewer::messages::kCannotOpen},
        {{path("none.fab.json"), "--watch"}, viewer::messages::kCannotOpen},
        {{path("text.ofr")}, ofr::messages::kNotOfr},
        {{scratch_.path().string()}, prints::messages::kNoFolderOfSlices},
        {{path("odd")}, prints::messages::kManifestOfOther},
        {{print, path("none.ofr")}, viewer::messages::kCannotOpen},
        {{print, "--watch"}, viewer::messages::kWatchIsForWorld},
        {{print, "--world", "cube.obj"}, viewer::messages::kWorldIsNoWorld},
        {{print, "--fablet", "solid"}, viewer::messages::kFabletIsForMesh},
        {{print, "--world", "cube.fab.json", "--fablet", "solid"},
         viewer::messages::kFabletIsForMesh},
        {{path("none.fab.json"), "--fablet", "solid"}, viewer::messages::kFabletIsForPrint},
        {{print, "--listen", "example.org"}, viewer::messages::kNotAnAddressHere},
        {{print, "--port", "70000"}, "--port"},
        {{print, "--memory", "20kB"}, "memory"}};
    for (const auto& [arguments, message] : wrong) {
        std::vector<std::string> argv = {program("openfab"), "view"};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        const Outcome outcome = run(argv);
        EXPECT_NE(outcome.exit_code, 0);
        EXPECT_THAT(outcome.err, testing::Says(message));
    }
}

/// It serves, or says that it cannot; `timeout` ends what serves with 124.
TEST_F(ViewServer, WithoutMemoryForThreadsItEndsWithAMessage) {
    scratch_.write(
        "a.fl",
        "fablet A {\n    @uniform { Material a; }\n    @Volume(@varying { VolumeAttributes "
        "attr }) { MaterialComposition mc; mc.Set(a, 1); return mc; }\n}\n");
    scratch_.write("cube.fab.json", R"({"openfab": 1, "printer": "generic",
"fablets": {"a": {"source": "a.fl", "fablet": "A"}}, "materials": {"white": {"key": "#ffffff"}},
"meshes": {"cube": {"box": [2, 2, 2]}},
"objects": {"cube": {"mesh": "cube", "fablet": "a", "uniforms": {"a": "white"}}}, "build": [{"object": "cube"}]})");
    int refused = 0;
    for (const std::string& file : {write(print_, "a.ofr"), path("cube.fab.json")}) {
        for (int megabytes = 60; megabytes <= 240; megabytes += 20) {
            const Outcome outcome =
                run({"/bin/bash", "-c",
                     fmt::format("ulimit -v {}; exec timeout 1 '{}' view '{}'", 1000 * megabytes,
                                 program("openfab").string(), file)});
            // 127: not even its libraries find room.
            EXPECT_THAT(outcome.exit_code, ::testing::AnyOf(3, 124, 127))
                << megabytes << outcome.err;
            if (outcome.exit_code != 3) continue;
            ++refused;
            EXPECT_THAT(outcome.err, HasSubstr("error: "));
            EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("http")));  // refused before
            EXPECT_THAT(outcome.err, ::testing::AnyOf(HasSubstr("ulimit -v"), HasSubstr("memory")));
        }
    }
    EXPECT_GT(refused, 0);
}

TEST_F(ViewServer, TwoServersNeverShareAPort) {
    const std::string file = write(print_, "a.ofr");
    const Viewer viewer({file});
    const Outcome second =
        run({program("openfab"), "view", file, "--port", std::to_string(viewer.port())});
    EXPECT_EQ(second.exit_code, 3);
    EXPECT_THAT(second.err, testing::Says(viewer::messages::kIsItTaken));
}

}  // namespace
}  // namespace openfab::testing
