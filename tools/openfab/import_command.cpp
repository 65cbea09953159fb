// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import FILE -o FOLDER`: makes a world of a mesh with its files, ready to print.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/model/mesh_memory.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/import.h"
#include "tools/openfab/stock.h"
#include "world/printer.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

std::optional<double> unit_mm(const std::string& name) {
    static const std::pair<const char*, double> kUnits[] = {
        {"mm", 1}, {"cm", 10}, {"m", 1000}, {"um", 0.001}, {"in", 25.4}};
    for (const auto& [unit, mm] : kUnits) {
        if (name == unit) return mm;
    }
    return {};
}

Result<void> read_length(const char* option, const std::string& text, std::optional<double>* mm) {
    if (text.empty()) return {};
    const Result<double> length = parse_length_mm(text);
    if (!length) return usage_error(fmt::format("`{}`: {}", option, length.error().text()));
    if (!(*length > 0)) return usage_error(fmt::format("`{}` must be above 0", option));
    *mm = *length;
    return {};
}

Result<void> copy_into(const fs::path& from, const fs::path& to) {
    std::error_code status;
    if (fs::equivalent(from, to, status)) return {};  // it is imported where it lies
    status.clear();
    fs::create_directories(to.parent_path(), status);
    if (!status) fs::copy_file(from, to, fs::copy_options::overwrite_existing, status);
    if (!status) return {};
    return outside_error(
        fmt::format("cannot copy `{}` to `{}`: {}", from.string(), to.string(), status.message()));
}

/// Writes the mesh, its files, pictures and fablet, and the world last.
Result<void> write_all(const fs::path& mesh, const mesh::LoadedMesh& loaded, const Import& import,
                       const fs::path& folder, const fs::path& world) {
    if (Result<void> done = copy_into(mesh, folder / mesh.filename()); !done) return done;
    for (const fs::path& other : loaded.files) {
        const fs::path relative = other.lexically_relative(mesh.parent_path());
        if (Result<void> done = copy_into(other, folder / relative); !done) return done;
    }
    for (const ImportedFile& file : import.files) {
        if (Result<void> done = write_file(folder / file.name, *file.bytes); !done) return done;
    }
    if (Result<void> done =
            write_file(folder / "fab_world.schema.json", stock_text("fab_world.schema.json"));
        !done)
        return done;
    return write_file(world, import.world);
}

}  // namespace

Result<void> run_import(ImportArguments arguments) {
    const fs::path mesh = arguments.file;
    if (!mesh::is_mesh_file(mesh)) {
        return usage_error(fmt::format("`{}` does not have the extension of a mesh; supported: {}",
                                       arguments.file, mesh::mesh_formats()));
    }
    if (!arguments.import.fablet.empty() && !is_stock_fablet(arguments.import.fablet)) {
        return usage_error(fmt::format("there is no stock fablet `{}`; choose from {}",
                                       arguments.import.fablet, stock_fablet_names()));
    }
    if (Result<void> read = read_length("--size", arguments.size, &arguments.import.largest_mm);
        !read)
        return read;
    if (Result<void> read =
            read_length("--picture-size", arguments.picture_size, &arguments.import.picture_mm);
        !read)
        return read;
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    arguments.import.y_up = arguments.up == "y";
    if (!arguments.up.empty() && mesh::format_says_up(mesh)) {
        return usage_error(
            "glTF is y-up by definition, and the mesh is already rotated; leave `--up` out");
    }
    if (Result<world::Printer> printer = world::load_printer(arguments.import.printer); !printer)
        return printer.error();
    const fs::path folder = arguments.folder;
    const fs::path world = folder / (mesh.stem().string() + ".fab.json");
    std::error_code status;
    if (fs::exists(world, status))
        return user_error(
            fmt::format("`{}` exists already; choose another folder", world.string()));

    mesh::MeshOptions options;
    options.name = mesh.stem().string();
    options.unit_mm = unit_mm(arguments.unit);
    options.y_up = arguments.import.y_up;
    options.repair = arguments.import.repair = !arguments.repair.empty();
    options.memory_bytes = *memory;
    Result<mesh::LoadedMesh> loaded = mesh::load_mesh(mesh, options);
    if (!loaded) return loaded.error();
    const int64_t left = *memory - mesh::mesh_bytes(mesh::counts_of(loaded->mesh));
    arguments.import.memory_bytes = left;
    Result<Appearances> appearances = read_appearances(mesh, left);
    if (!appearances) return appearances.error();
    // Before steps that may fail because of something that was left out.
    for (const std::string& warning : loaded->warnings)
        warn(warning);
    for (const std::string& text : appearances->notes)
        note(text);
    Result<Import> import =
        make_import(*loaded, *appearances, mesh.filename().string(), arguments.import);
    if (!import) return import.error();
    for (const std::string& text : import->notes)
        note(text);
    if (Result<void> done = write_all(mesh, *loaded, *import, folder, world); !done) return done;
    for (const auto& [name, number] : loaded->groups)
        say(fmt::format("group {} is {}\n", number, printable(name)));
    say(fmt::format("made {} with the fablet `{}`\nprint it: openfab print {} -o {}\n",
                    world.string(), import->fablet, shell_word(world.string()),
                    shell_word(mesh.stem().string() + ".ofr")));
    return {};
}

}  // namespace openfab::tools
