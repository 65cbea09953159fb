// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/replace_file.h"
#include "base/say.h"
#include "base/text.h"
#include "tools/openfab/converter.h"
#include "tools/openfab/import_text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"
#include "world/printer.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

struct Segment {
    std::string name, label, color;
    int32_t number = 0;
};

struct Segmentation {
    std::array<double, 3> size_mm{};
    std::vector<Segment> segments;
};

/// Colours of segments without one, and of those whose colour another one has: slices tell materials apart.
std::string free_color(const std::string& wanted, std::set<std::string>* taken) {
    uint32_t color = 0xc0c0c0;
    if (!wanted.empty()) color = static_cast<uint32_t>(std::stoul(wanted.substr(1), nullptr, 16));
    for (;;) {
        const std::string text = fmt::format("#{:06x}", color);
        if (taken->insert(text).second) return text;
        constexpr uint32_t kStep = 0x10305, kAll = 0xffffff;
        color = (color + kStep) & kAll;
    }
}

Result<Segmentation> read_list(const fs::path& file) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return opened.error();
    constexpr int64_t kMost = 100'000'000;
    const Result<std::string> text = opened->read_all(kMost);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    Segmentation out;
    Names names;
    std::set<std::string> taken;
    for (size_t a = 0; a < 3; ++a)
        out.size_mm[a] = root->find("size_mm")->value.items[a].number;
    for (const JsonValue& item : root->find("segments")->value.items) {
        Segment segment;
        segment.number = static_cast<int32_t>(item.find("number")->value.number);
        segment.label = item.find("label")->value.text;
        segment.name = names.unique(
            segment.label.empty() ? fmt::format("segment {}", segment.number) : segment.label);
        const JsonMember* const color = item.find("color");
        segment.color = free_color(color == nullptr ? std::string() : color->value.text, &taken);
        out.segments.push_back(std::move(segment));
    }
    return out;
}

std::string world_text(const Segmentation& scan, const std::string& file,
                       const std::string& printer) {
    std::string fablets, materials, textures, meshes, objects, build;
    const auto& [x, y, z] = scan.size_mm;
    // The border of the box must be outside of the shape.
    const std::string box = fmt::format("[[-0.01, -0.01, -0.01], [{}, {}, {}]]", number(x + 0.01),
                                        number(y + 0.01), number(z + 0.01));
    int32_t priority = 0;
    for (const Segment& segment : scan.segments) {
        const std::string name = json_string(segment.name),
                          comma = priority == 0 ? "" : ",\n        ";
        fablets += fmt::format(
            "{}{}: {{\"source\": \"stock_segment.fl\", \"fablet\": \"Segment\", \"uniforms\": "
            "{{\"field\": {}, \"material\": {}}}}}",
            comma, name, name, name);
        materials += fmt::format("{}{}: {{\"key\": \"{}\"}}", comma, name, segment.color);
        textures += fmt::format(
            "{}{}: {{\"file\": {}, \"segment\": {}, \"origin_mm\": [0, 0, 0], \"wrap\": \"black\", "
            "\"filter\": \"trilinear\"}}",
            comma, name, json_string(file), segment.number);
        meshes += fmt::format("{}{}: {{\"shape\": {}, \"box_mm\": {}}}", comma, name, name, box);
        objects += fmt::format("{}{}: {{\"mesh\": {}, \"fablet\": {}, \"priority\": {}}}", comma,
                               name, name, name, ++priority);
        build += fmt::format("{}{{\"object\": {}}}", comma, name);
    }
    return fmt::format(
        "{{\n    \"$schema\": \"fab_world.schema.json\",\n    \"openfab\": 1,\n    \"printer\": "
        "{},\n"
        "    \"fablets\": {{\n        {}\n    }},\n    \"materials\": {{\n        {}\n    }},\n"
        "    \"textures\": {{\n        {}\n    }},\n    \"meshes\": {{\n        {}\n    }},\n"
        "    \"objects\": {{\n        {}\n    }},\n    \"build\": [\n        {}\n    ]\n}}\n",
        json_string(printer), fablets, materials, textures, meshes, objects, build);
}

}  // namespace

bool is_scan_file(const fs::path& file) {
    return lower_ascii(file.extension().string()) == ".dcm";
}

Result<fs::path> import_scan(const ImportArguments& arguments) {
    if (Result<world::Printer> printer = world::load_printer(arguments.import.printer); !printer)
        return printer.error();
    const fs::path file = arguments.file, folder = arguments.folder;
    const fs::path world = folder / (file.stem().string() + ".fab.json");
    std::error_code status;
    if (fs::exists(world, status))
        return user_error(fmt::format(messages::kFolderExists, world.string()));
    const Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
    if (!scratch) return scratch.error();
    const fs::path list = (*scratch)->path() / "segments.json";
    if (Result<void> listed =
            run_converter(kScanConverter, {"--segments", as_argument(file), list.string()}, file);
        !listed)
        return listed.error();
    const Result<Segmentation> scan = read_list(list);
    if (!scan) return scan.error();
    constexpr size_t kMostMaterials = 254;
    if (scan->segments.size() > kMostMaterials) {
        return user_error(fmt::format(messages::kTooManyMaterials, file.string(),
                                      scan->segments.size(), kMostMaterials));
    }
    fs::create_directories(folder, status);
    const fs::path copy = folder / file.filename();
    if (!fs::equivalent(file, copy, status)) {
        if (Result<void> copied = copy_at_once(file, copy); !copied) return copied.error();
    }
    const std::pair<fs::path, std::string> texts[] = {
        {folder / "stock_segment.fl", std::string(stock_text("stock_segment.fl"))},
        {folder / "fab_world.schema.json", std::string(stock_text("fab_world.schema.json"))},
        {world, world_text(*scan, file.filename().string(), arguments.import.printer)}};
    for (const auto& [path, text] : texts) {
        if (Result<void> done = write_file(path, text); !done) return done.error();
    }
    note(fmt::format(messages::kScanMoved, file.filename().string()));
    if (!arguments.quiet)
        say(fmt::format("made {} of {} segment{}\n", world.string(), scan->segments.size(),
                        scan->segments.size() == 1 ? "" : "s"));
    return world;
}

}  // namespace openfab::tools
