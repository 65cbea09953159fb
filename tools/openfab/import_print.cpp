// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_print.h"

#include <fmt/format.h>

#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "backends/read/gcvf_print.h"
#include "base/json_text.h"
#include "base/messages.h"
#include "base/replace_file.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "texture/volume.h"
#include "tools/openfab/import_text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"
#include "world/printer.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr const char* kDefaultPrinter = "generic";

std::string three(const Vec3d& v) {
    return fmt::format("[{}, {}, {}]", number(v.x), number(v.y), number(v.z));
}

Vec3d size_mm(const pipeline::PrintInfo& info) {
    return {info.size.x * info.pitch_mm.x, info.size.y * info.pitch_mm.y,
            (info.slice_end - info.slice_begin) * info.pitch_mm.z};
}

/// A fablet that gives each voxel the material of its code.
std::string fablet_text(size_t materials) {
    std::string names, chosen;
    for (size_t m = 1; m <= materials; ++m) {
        names += fmt::format("{}material_{}", m == 1 ? "" : ", ", m);
        chosen += fmt::format("        if (code == {}) mc.Set(material_{}, 1);\n", m, m);
    }
    return fmt::format(
        "// The voxels of a print: each is of the material that its code says, 0 of none.\n"
        "fablet Print {{\n"
        "    @uniform {{\n"
        "        ImageTexture3D codes;\n"
        "        Material {};\n"
        "    }}\n\n"
        "    @Volume(@varying {{ VolumeAttributes attr }})\n"
        "    {{\n"
        "        MaterialComposition mc;\n"
        "        float code = floor(codes.Sample1(attr.voxelCenter, 0) + 0.5);\n"
        "{}"
        "        return mc;\n"
        "    }}\n"
        "}}\n",
        names, chosen);
}

std::string printer_text(const std::string& name, const pipeline::PrintInfo& info) {
    constexpr double kMillimetresAnInch = 25.4, kMicrometres = 1000;
    return fmt::format(
        "{{\"name\": {}, \"dpi\": [{}, {}], \"layer_um\": {}, \"max_materials\": {}}}\n",
        json_string(name), number(kMillimetresAnInch / info.pitch_mm.x),
        number(kMillimetresAnInch / info.pitch_mm.y), number(kMicrometres * info.pitch_mm.z),
        info.materials.size());
}

std::string world_text(const pipeline::PrintInfo& info, const std::string& stem,
                       const std::string& file, const std::string& printer) {
    std::string materials, uniforms;
    Names names;
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const pipeline::SliceMaterial& material = info.materials[m];
        const std::string name = json_string(names.unique(
            material.name.empty() ? fmt::format("material {}", m + 1) : material.name));
        const auto& [r, g, b, alpha] = material.key;
        std::string more;
        if (material.density_g_cm3 > 0)
            more += fmt::format(", \"density_g_cm3\": {}", number(material.density_g_cm3));
        if (!material.channel.empty())
            more += fmt::format(", \"channel\": {}", json_string(material.channel));
        materials += fmt::format(
            "{}{}: {{\"key\": \"#{:02x}{:02x}{:02x}\", \"preview\": "
            "\"#{:02x}{:02x}{:02x}{:02x}\"{}}}",
            m == 0 ? "" : ",\n        ", name, r, g, b, material.preview[0], material.preview[1],
            material.preview[2], material.preview[3], more);
        uniforms += fmt::format(", \"material_{}\": {}", m + 1, name);
    }
    // A box stands on z = 0, its middle at x = y = 0.
    const Vec3d size = size_mm(info), middle{size.x / 2, size.y / 2, 0};
    const Vec3d lowest{info.origin_mm.x, info.origin_mm.y,
                       info.origin_mm.z + info.slice_begin * info.pitch_mm.z};
    const std::string name = json_string(stem);
    return fmt::format(
        "{{\n    \"$schema\": \"fab_world.schema.json\",\n    \"openfab\": 1,\n    \"printer\": "
        "{},\n"
        "    \"fablets\": {{\"print\": {{\"source\": {}, \"fablet\": \"Print\"}}}},\n"
        "    \"materials\": {{\n        {}\n    }},\n"
        "    \"textures\": {{\"codes\": {{\"file\": {}, \"origin_mm\": {}, \"wrap\": \"black\", "
        "\"filter\": "
        "\"nearest\"}}}},\n"
        "    \"meshes\": {{\"box\": {{\"box\": {}}}}},\n"
        "    \"objects\": {{{}: {{\"mesh\": \"box\", \"fablet\": \"print\", \"uniforms\": "
        "{{\"codes\": "
        "\"codes\"{}}}}}}},\n"
        "    \"build\": [{{\"object\": {}, \"translate_mm\": {}}}]\n}}\n",
        json_string(printer), json_string(stem + ".fl"), materials, json_string(file),
        three({-middle.x, -middle.y, 0}), three(size), name, uniforms, name,
        three(lowest + middle));
}

/// Copies a file, or the files of a folder that are slices or say what they are.
Result<void> copy_print(const fs::path& from, const fs::path& to) {
    std::error_code status;
    if (fs::equivalent(from, to, status)) return {};
    if (!fs::is_directory(from, status)) return copy_at_once(from, to);
    const Result<std::vector<fs::path>> files = texture::volume_files(from);
    if (!files) return files.error();
    fs::create_directories(to, status);
    for (const fs::path& file : *files) {
        if (Result<void> copied = copy_at_once(file, to / file.filename()); !copied) return copied;
    }
    return {};
}

}  // namespace

bool is_print_path(const fs::path& path) {
    std::error_code ignored;
    return prints::is_gcvf(path.string()) || lower_ascii(path.extension().string()) == ".ofr" ||
           (fs::is_directory(path, ignored) && fs::exists(path / texture::kPrintManifest, ignored));
}

Result<fs::path> import_print(const ImportArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    fs::path file = arguments.file;
    if (file.filename().empty()) file = file.parent_path();  // `slices/`
    const fs::path folder = arguments.folder;
    const std::string stem = file.stem().string();
    const fs::path world = folder / (stem + ".fab.json");
    std::error_code status;
    if (fs::exists(world, status))
        return user_error(fmt::format(messages::kFolderExists, world.string()));
    const Result<std::unique_ptr<prints::PrintFile>> print =
        prints::PrintFile::open(file.string(), *memory);
    if (!print) return print.error();
    const pipeline::PrintInfo& info = (*print)->info();
    const int32_t planned = info.slice_end - info.slice_begin;
    if ((*print)->whole_slices() < planned)
        return user_error(fmt::format(messages::kSlicesMissing, file.string(),
                                      (*print)->whole_slices(), planned));
    if (info.materials.empty())
        return user_error(fmt::format(messages::kPrintOfNothing, file.string()));
    std::string printer = arguments.import.printer;
    const bool own = printer == kDefaultPrinter;
    if (own) {
        printer = stem + ".printer.json";
    } else if (Result<world::Printer> known = world::load_printer(printer); !known) {
        return known.error();
    }
    fs::create_directories(folder, status);
    if (Result<void> copied = copy_print(file, folder / file.filename()); !copied)
        return copied.error();
    std::vector<std::pair<fs::path, std::string>> texts{
        {folder / (stem + ".fl"), fablet_text(info.materials.size())},
        {folder / "fab_world.schema.json", std::string(stock_text("fab_world.schema.json"))},
        {world, world_text(info, stem, file.filename().string(), printer)}};
    if (own) texts.emplace(texts.begin(), folder / printer, printer_text(stem, info));
    for (const auto& [path, text] : texts) {
        if (Result<void> done = write_file(path, text); !done) return done.error();
    }
    if (!arguments.quiet)
        say(fmt::format("made {} of {} x {} x {} voxels\n", world.string(), info.size.x,
                        info.size.y, planned));
    return world;
}

}  // namespace openfab::tools
