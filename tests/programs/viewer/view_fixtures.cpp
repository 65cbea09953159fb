// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/programs/viewer/view_fixtures.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "backends/ofr/ofr_sink.h"

namespace openfab::testing {

std::string tile_path(const std::string& values) {
    return "/api/tile?generation=1&print=0&colors=" + std::string(kColorText) + "&" + values;
}

std::string PrintFixture::write(const SamplePrint& print, const std::string& name, bool complete) {
    Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create(path(name));
    EXPECT_TRUE(sink && print.send(sink->get(), complete));
    return path(name);
}

ReadPng PrintFixture::picture(const HttpAnswer& answer) {
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.headers.at("content-type"), "image/png");
    scratch_.write("tile.png", answer.body);
    return read_png(scratch_ / "tile.png");
}

WorldFixture::WorldFixture(const std::string& name, const std::string& fablet, std::string text,
                           const std::string& build)
    : source_(name + ".fl") {
    world_text_ = fmt::format(R"({{
    "openfab": 1, "printer": "generic",
    "fablets": {{"{0}": {{"source": "{0}.fl", "fablet": "{1}"}}}},
    "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000"}}}},
    "meshes": {{"cube": {{"box": [2, 2, 2]}}}},
    "objects": {{
        "cube": {{"mesh": "cube", "fablet": "{0}", "uniforms": {{"a": "white", "b": "black"}}}}
    }},
    "build": {2}
}}
)",
                              name, fablet, build);
    scratch_.write(source_, std::move(text));
    scratch_.write("cube.fab.json", world_text_);
}

bool WorldFixture::is_done(const JsonValue& state) {
    return member(member(state, "live"), "phase").text == "done";
}

bool WorldFixture::has_done(const JsonValue& state, double generation) {
    return is_done(state) && member(state, "generation").number >= generation;
}

HttpAnswer WorldFixture::ask(const Viewer& viewer, const std::string& path, const std::string& text,
                             const std::string& action) {
    JsonText body;
    body.begin_object().member("fablet", 0).member("text", text).end_object();
    std::string json = body.take();
    if (!action.empty()) {
        json.pop_back();
        json += ", \"action\": " + action + "}";
    }
    return viewer.post(path, json);
}

}  // namespace openfab::testing
