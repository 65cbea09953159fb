// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab coupon`: the plate of gallery/coupon for a printer, of its materials, printed in its format.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "backends/formats/formats.h"
#include "base/check.h"
#include "base/json_text.h"
#include "base/say.h"
#include "program/options.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/machine_materials.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"
#include "world/edit/world_edit.h"
#include "world/printer.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostMaterials = 6;  // RESINS of gallery/coupon/coupon.fl
constexpr double kLargestVoxelMm = 0.25;

/// Returns the materials, the plate's first, and says which are left out.
Result<std::vector<std::string>> materials_of(const CouponArguments& arguments,
                                              const world::Printer& printer) {
    const size_t most = std::min(kMostMaterials, static_cast<size_t>(printer.max_materials));
    std::vector<std::string> names = arguments.materials;
    if (names.size() > most) {
        return usage_error(fmt::format(messages::kCouponMaterials, kMostMaterials, printer.name,
                                       printer.max_materials, names.size()));
    }
    for (auto name = names.begin(); name != names.end(); ++name) {
        if (std::find(names.begin(), name, *name) != name)
            return usage_error(fmt::format(messages::kCouponMaterialTwice, *name));
    }
    if (!names.empty()) return names;
    for (const world::Ink& ink : printer.inks)
        names.push_back(ink.name);
    put_material_first(&names, 0, "white");
    put_material_first(&names, 1, "black");
    if (names.empty()) {
        names = names_by_look();
        note(messages::kCouponNamesMaterials);
    } else if (names.size() > most) {
        note(fmt::format(
            messages::kCouponLeavesInks,
            fmt::join(names.begin() + static_cast<std::ptrdiff_t>(most), names.end(), ", "), most));
    }
    names.resize(std::min(most, names.size()));
    return names;
}

/// What a print of the coupon is.
struct Print {
    const backends::Format* format = nullptr;
    std::vector<std::string> words;  ///< of its command
    bool mixtures = true;
};

Result<Print> print_of(const CouponArguments& arguments, const world::Printer& printer) {
    Print print;
    const std::string name = arguments.format.empty() ? printer.native_format : arguments.format;
    const fs::path folder = arguments.folder;
    print.format = backends::find_format(name);
    const bool is_folder =
        print.format != nullptr && print.format->kind == backends::FormatKind::kFolder;
    const std::string output = is_folder ? "slices"
                               : print.format == nullptr
                                   ? "coupon"
                                   : fmt::format("coupon{}", print.format->extension);
    print.words = {(folder / "coupon.fab.json").string(), "-o", (folder / output).string(),
                   "--format", name};
    print.words.insert(print.words.end(), arguments.print.begin(), arguments.print.end());
    std::vector<const char*> argv{"openfab coupon"};
    for (const std::string& word : print.words)
        argv.push_back(word.c_str());
    const Result<program::Options> options =
        program::parse_options(static_cast<int>(argv.size()), argv.data(), "openfab coupon");
    if (!options) return options.error();
    OPENFAB_CHECK(print.format != nullptr);  // they were parsed
    const bool meshes = print.format->kind == backends::FormatKind::kMesh;
    print.mixtures = !meshes || print.format->needs_mixtures ||
                     (printer.mesh_colors && print.format->mixture_bytes_per_column != nullptr);
    const Vec3d pitch =
        program::print_pitch(*options, printer.pitch_mm,
                             meshes && (name != printer.native_format || !printer.knows_pitch()));
    if (!(pitch.x > 0 && pitch.y > 0 && pitch.z > 0))
        return usage_error(fmt::format(messages::kCouponNeedsPitch, printer.name));
    if (std::max({pitch.x, pitch.y, pitch.z}) > kLargestVoxelMm * options->draft) {
        return usage_error(
            fmt::format(messages::kCouponTooCoarse, pitch.x, pitch.y, pitch.z, kLargestVoxelMm));
    }
    return print;
}

/// Returns the world's text.
Result<std::string> world_text(const CouponArguments& arguments, const world::Printer& printer,
                               const std::vector<std::string>& names, bool mixtures) {
    Result<world::WorldEdit> edit =
        world::WorldEdit::of_text(std::string(stock_text("coupon.fab.json")), "coupon.fab.json");
    if (!edit) return edit.error();
    std::string list = "[";
    for (const std::string& name : names)
        list += (list.size() > 1 ? ", " : "") + json_string(name);
    Result<void> done =
        edit->set("printer", json_string(fs::path(arguments.printer).filename().string()));
    if (done) done = edit->set("materials", materials_text(names, printer));
    if (done) done = edit->set_uniform("coupon", "resins", list + "]");
    if (done && !mixtures) done = edit->set_uniform("coupon", "mixtures", "0");
    if (!done) return done.error();
    return edit->text();
}

}  // namespace

Result<void> run_coupon(const CouponArguments& arguments) {
    const Result<world::Printer> printer = world::load_printer(arguments.printer);
    if (!printer) return printer.error();
    Result<Print> print = print_of(arguments, *printer);
    if (!print) return print.error();
    const fs::path folder = arguments.folder;
    std::error_code status;
    if (fs::exists(folder, status))
        return user_error(fmt::format(messages::kNameExists, arguments.folder));
    const Result<std::vector<std::string>> names = materials_of(arguments, *printer);
    if (!names) return names.error();
    if (names->size() == 1) {
        note(messages::kCouponOneMaterial);
    } else if (!print->mixtures) {
        note(fmt::format(messages::kCouponNoPairs, print->format->name));
    }
    const Result<std::string> world = world_text(arguments, *printer, *names, print->mixtures);
    if (!world) return world.error();
    std::string fablet(stock_text("coupon.fl"));
    const std::string most = fmt::format("const int RESINS = {};", kMostMaterials);
    const size_t at = fablet.find(most);
    OPENFAB_CHECK_NE(at, std::string::npos);
    fablet.replace(at, most.size(), fmt::format("const int RESINS = {};", names->size()));
    Result<void> written = write_file(folder / "coupon.fl", fablet);
    if (written) written = write_file(folder / "coupon.fab.json", *world);
    if (written) written = copy_profile(arguments.printer, folder);
    if (!written) return written;
    say(fmt::format("{}\n",
                    fmt::format(messages::kCouponMade, (folder / "coupon.fab.json").string(),
                                fmt::join(*names, ", "))));
    return run_print(std::move(print->words));
}

}  // namespace openfab::tools
