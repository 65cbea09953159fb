// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/graph_places.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "base/json_text.h"
#include "base/replace_file.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/source_text.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostPlacesBytes = 4 << 20;

fs::path file_of(const fs::path& fablet) {
    return fs::path(fablet).replace_extension(".graph.json");
}

}  // namespace

std::string graph_places(const fs::path& fablet, const std::vector<fs::path>& roots) {
    std::error_code status;
    const fs::path file = file_of(fablet);
    if (!fs::is_regular_file(file, status)) return "{}";
    const Result<std::string> text = read_source(file, roots);
    const Result<JsonValue> json =
        text ? parse_json(*text, file.filename().string()) : Result<JsonValue>(text.error());
    if (!json || !json->is(JsonValue::Kind::kObject)) return "{}";
    JsonText out;
    out.value(*json);
    return out.take();
}

Result<void> keep_graph_places(const fs::path& fablet, const std::vector<fs::path>& roots,
                               const JsonValue& places) {
    const JsonValue* tabs = member_of(places, "tabs");
    if (tabs == nullptr || !tabs->is(JsonValue::Kind::kObject))
        return user_error(messages::kNoPlaces);
    const fs::path file = file_of(fablet);
    std::error_code status;
    const fs::file_type there = fs::symlink_status(file, status).type();
    if (tabs->members.empty()) {
        if (there == fs::file_type::regular) fs::remove(file, status);
        return {};
    }
    // What is there and is none of these files stays.
    if (there != fs::file_type::not_found &&
        (there != fs::file_type::regular || !read_source(file, roots)))
        return user_error(fmt::format(messages::kPlacesTaken, file.filename().string()));
    JsonText out(JsonText::Layout::kIndentedLists);
    out.value(places);
    std::string text = out.take() + "\n";
    if (text.size() > kMostPlacesBytes) return user_error(messages::kNoPlaces);
    // A file is replaced where there is one.
    if (there == fs::file_type::not_found && !std::ofstream(file, std::ios::app))
        return outside_error(fmt::format(messages::kCannotWrite, file.filename().string()));
    return replace_file(file, text);
}

}  // namespace openfab::viewer
