// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import FILE -o FOLDER`: makes a world of a mesh with its files, ready to print.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "backends/formats/formats.h"
#include "base/input_file.h"
#include "base/messages.h"
#include "base/own_folder.h"
#include "base/replace_file.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/load/pictures.h"
#include "mesh/model/mesh_memory.h"
#include "texture/cache.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/converter.h"
#include "tools/openfab/import.h"
#include "tools/openfab/import_print.h"
#include "tools/openfab/import_scan.h"
#include "tools/openfab/import_text.h"
#include "tools/openfab/list_mesh.h"
#include "tools/openfab/messages.h"
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
    if (!(*length > 0)) return usage_error(fmt::format(messages::kMustBeAboveZero, option));
    *mm = *length;
    return {};
}

Result<void> copy_into(const fs::path& from, const fs::path& to) {
    std::error_code status;
    if (fs::equivalent(from, to, status)) return {};  // it is imported where it lies
    status.clear();
    fs::create_directories(to.parent_path(), status);
    if (!status) return copy_at_once(from, to);
    return outside_error(
        fmt::format(openfab::messages::kCannotCopy, from.string(), to.string(), status.message()));
}

/// Writes the mesh, its files, pictures and fablet, and the world last.
Result<void> write_all(const fs::path& mesh, const mesh::LoadedBodies& loaded, const Import& import,
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

/// Reads the pictures that the file's looks and fields have; those that do not fit are notes of the import.
Result<Pictures> read_pictures_of(const fs::path& mesh, const mesh::LoadedBodies& loaded,
                                  const ImportedFields& fields, int64_t memory_bytes) {
    std::set<std::string> sheets;
    fields.add_sources(&sheets);
    std::set<std::string> named = sheets;
    for (const mesh::Look& look : loaded.looks) {
        if (look.picture) named.insert(look.picture->source);
    }
    const std::vector<std::string> sources(named.begin(), named.end());
    Pictures pictures;
    if (sources.empty()) return pictures;
    const Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
    if (!scratch) return scratch.error();
    const Result<void> read = mesh::read_pictures(
        mesh, sources, std::max<int64_t>(memory_bytes, 0),
        [&](size_t i, Result<std::string> bytes) {
            // What the print would refuse is told here. TGA files are known by their names alone.
            const fs::path copy =
                (*scratch)->path() / plain_name(fs::path(sources[i]).filename().string());
            Result<void> readable = bytes ? write_file(copy, *bytes) : bytes.error();
            if (readable && sheets.contains(sources[i])) {
                // Of hundreds of sheets each check would be a process; the print reads them soon.
                if (!bytes->starts_with("\x89PNG")) readable = user_error(messages::kNotAPng);
            } else if (readable) {
                readable = texture::check_picture(copy);
            }
            if (readable) {
                pictures.emplace(sources[i],
                                 std::make_shared<const std::string>(std::move(*bytes)));
            } else {
                pictures.emplace(sources[i], readable.error());
            }
        });
    if (!read) return read.error();
    return pictures;
}

/// Checks the arguments that do not depend on the file, and fills in what they say.
Result<mesh::MeshOptions> read_arguments(ImportArguments* arguments) {
    const fs::path mesh = arguments->file;
    if (const std::string other = mesh::other_mesh_format(mesh); !other.empty())
        return usage_error(fmt::format("`{}` is {}", arguments->file, other));
    if (!mesh::is_mesh_file(mesh)) {
        return usage_error(
            fmt::format(messages::kNoMeshExtension, arguments->file, importable_meshes()));
    }
    ImportOptions& import = arguments->import;
    if (!import.fablet.empty() && find_stock_fablet(import.fablet) == nullptr) {
        return usage_error(
            fmt::format(messages::kNoStockFablet, import.fablet, stock_fablet_names()));
    }
    if (import.one_material && !import.fablet.empty() && import.fablet != "solid")
        return usage_error(messages::kOneMaterialIsForSolid);
    if (Result<void> read = read_length("--size", arguments->size, &import.largest_mm); !read)
        return read.error();
    if (Result<void> read =
            read_length("--picture-size", arguments->picture_size, &import.picture_mm);
        !read)
        return read.error();
    const Result<int64_t> memory = parse_memory_option(arguments->memory);
    if (!memory) return memory.error();
    import.y_up = arguments->up == "y";
    if (!arguments->up.empty() && mesh::format_says_up(mesh)) {
        return usage_error(messages::kGltfIsYUp);
    }
    mesh::MeshOptions options;
    options.name = mesh.stem().string();
    options.unit_mm = unit_mm(arguments->unit);
    options.y_up = import.y_up;
    options.repair = import.repair = !arguments->repair.empty();
    options.recentre = arguments->recentre;
    options.memory_bytes = *memory;
    return options;
}

/// Loads the bodies of a file, and finds its lattices of beams, which may be all that it has.
Result<mesh::LoadedBodies> load_all(const fs::path& mesh, const mesh::MeshOptions& options,
                                    std::vector<mesh::LatticeInfo>* lattices) {
    Result<mesh::LoadedBodies> loaded = mesh::load_bodies(mesh, options);
    const auto is_told = [](const mesh::LeftOut& left) {
        return left.kind == mesh::LeftOutKind::kLattices;
    };
    if (loaded && std::ranges::none_of(loaded->left_out, is_told)) return loaded;
    Result<mesh::LoadedLattices> found = mesh::load_lattices(
        mesh, {.unit_mm = options.unit_mm, .body = {}, .memory_bytes = options.memory_bytes});
    if (!found || found->lattices.empty()) return loaded;
    if (!loaded && found->has_meshes) return loaded;
    if (options.recentre) return usage_error(messages::kRecentreWithLattices);
    *lattices = std::move(found->lattices);
    if (!loaded) {
        mesh::LoadedBodies alone;
        alone.unit_mm = found->unit_mm;
        alone.unit_note = options.unit_mm ? "given" : "as the file says";
        loaded = std::move(alone);
    }
    // They are objects of the world.
    std::erase_if(loaded->left_out, is_told);
    for (mesh::LeftOut& left : found->left_out) {
        const bool known = std::ranges::any_of(
            loaded->left_out, [&](const mesh::LeftOut& other) { return other.what == left.what; });
        if (!known) loaded->left_out.push_back(std::move(left));
    }
    return loaded;
}

/// Adds the level sets of a file, which may be all that it has, and the fablets of bodies.
Result<mesh::LoadedBodies> load_fields_too(const fs::path& mesh, const mesh::MeshOptions& options,
                                           Result<mesh::LoadedBodies> loaded,
                                           ImportArguments* arguments) {
    ImportOptions& import = arguments->import;
    Result<ImportedFields> fields = load_fields(mesh, options, loaded ? &*loaded : nullptr);
    if (!fields) return fields.error();
    if (fields->empty()) return loaded;
    if (!loaded && fields->has_meshes) return loaded;
    if (options.recentre || import.largest_mm)
        return usage_error(
            fmt::format(messages::kIsForMeshes, options.recentre ? "--recentre" : "--size"));
    if (!loaded) {
        mesh::LoadedBodies alone;
        alone.unit_mm = fields->unit_mm;
        alone.unit_note = options.unit_mm ? "given" : "as the file says";
        loaded = std::move(alone);
    }
    without_fields(&loaded->left_out);
    for (mesh::LeftOut& left : fields->left_out) {
        const bool known = std::ranges::any_of(
            loaded->left_out, [&](const mesh::LeftOut& other) { return other.what == left.what; });
        if (!known) loaded->left_out.push_back(std::move(left));
    }
    import.fields = std::move(*fields);
    return loaded;
}

/// `has_size`: what there is to say of the unit and the size is settled.
void tell(const fs::path& mesh, const mesh::LoadedBodies& loaded, bool has_size) {
    const auto tell_all = [&](const auto& of) {
        for (const std::string& warning : of.warnings)
            if (!has_size || std::ranges::count(of.of_size, warning) == 0) warn(warning);
    };
    tell_all(loaded);
    for (const mesh::LoadedMesh& body : loaded.bodies)
        tell_all(body);
    for (const mesh::LeftOut& left : loaded.left_out)
        note(fmt::format("{}: {}", mesh.filename().string(), mesh::describe(left)));
}

/// "of 3 bodies with the fablets `solid` and `textured`".
std::string summary(const mesh::LoadedBodies& loaded, const Import& import) {
    std::string fablets;
    for (size_t i = 0; i < import.fablets.size(); ++i) {
        const bool last = i > 0 && i + 1 == import.fablets.size();
        fablets += fmt::format("{}`{}`", i == 0 ? "" : last ? " and " : ", ", import.fablets[i]);
    }
    const std::string bodies =
        loaded.bodies.size() <= 1 ? "" : fmt::format(messages::kOfBodies, loaded.bodies.size());
    return fmt::format(messages::kSummaryFablets, bodies, import.fablets.size() == 1 ? "" : "s",
                       fablets);
}

}  // namespace

Result<fs::path> import_mesh(ImportArguments arguments) {
    const Result<mesh::MeshOptions> options = read_arguments(&arguments);
    if (!options) return options.error();
    const Result<world::Printer> printer = world::load_printer(arguments.import.printer);
    if (!printer) return printer.error();
    arguments.import.mesh_colors = printer->mesh_colors;
    if (const std::string& picture = arguments.import.picture; !picture.empty()) {
        if (Result<void> readable = texture::check_picture(picture); !readable)
            return readable.error();
    }
    const fs::path mesh = arguments.file, folder = arguments.folder;
    const fs::path world = folder / (mesh.stem().string() + ".fab.json");
    std::error_code status;
    if (fs::exists(world, status))
        return user_error(fmt::format(messages::kFolderExists, world.string()));

    Result<mesh::LoadedBodies> loaded = load_all(mesh, *options, &arguments.import.lattices);
    loaded = load_fields_too(mesh, *options, std::move(loaded), &arguments);
    if (!loaded) return loaded.error();
    int64_t left = options->memory_bytes;
    for (const mesh::LoadedMesh& body : loaded->bodies)
        left -= mesh::mesh_bytes(mesh::counts_of(body.mesh));
    arguments.import.memory_bytes = left;
    // Before steps that may fail because of something that was left out.
    tell(mesh, *loaded, arguments.import.largest_mm.has_value());
    const Result<Pictures> pictures =
        read_pictures_of(mesh, *loaded, arguments.import.fields, left);
    if (!pictures) return pictures.error();
    for (const std::string& text : leave_out_unreadable(*pictures, &loaded->looks))
        note(text);
    Result<Import> import =
        make_import(*loaded, *pictures, mesh.filename().string(), arguments.import);
    if (!import) return import.error();
    for (const std::string& text : import->notes)
        note(text);
    if (Result<void> done = write_all(mesh, *loaded, *import, folder, world); !done)
        return done.error();
    if (arguments.quiet) return world;
    if (loaded->bodies.size() == 1) {
        for (const auto& [name, number] : loaded->bodies[0].groups)
            say(fmt::format(messages::kGroupIs, number, printable(name)));
    }
    say(fmt::format("made {} {}\n", world.string(), summary(*loaded, *import)));
    return world;
}

namespace {

/// The first option that was given and means nothing for what is no mesh; empty: none.
std::string_view option_of_meshes(const ImportArguments& a) {
    const ImportOptions& import = a.import;
    const std::pair<std::string_view, bool> given[] = {{"--list", a.list},
                                                       {"--json", a.json},
                                                       {"--fablet", !import.fablet.empty()},
                                                       {"--one-material", import.one_material},
                                                       {"--picture", !import.picture.empty()},
                                                       {"--mapping", !import.mapping.empty()},
                                                       {"--side", !import.side.empty()},
                                                       {"--picture-size", !a.picture_size.empty()},
                                                       {"--size", !a.size.empty()},
                                                       {"--up", !a.up.empty()},
                                                       {"--repair", !a.repair.empty()},
                                                       {"--recentre", a.recentre},
                                                       {"--tolerance", !a.tolerance.empty()}};
    for (const auto& [name, is_given] : given)
        if (is_given) return name;
    return {};
}

/// Looks of MaterialX are read by its own package, in the Python that is on the PATH; replaces this process.
Error import_materialx(const ImportArguments& arguments) {
    std::string_view name = option_of_meshes(arguments);
    if (name.empty() && !arguments.memory.empty()) name = "--memory";
    if (!name.empty()) return usage_error(fmt::format(messages::kMeansNothingForLooks, name));
    constexpr const char* kRun =
        "import os, sys\n"
        // A stranger's folder may hold modules.
        "sys.path[:] = [p for p in sys.path if p not in ('', os.getcwd())]\n"
        "try:\n"
        "    from openfab import materialx\n"
        "except ImportError:\n"
        "    print('error: looks of MaterialX are read by the Python package openfab, which "
        "python3 does not "
        "have; docs/without_text.md says how without it', file=sys.stderr)\n"
        "    sys.exit(3)\n"
        "sys.exit(materialx.main(sys.argv[1:]))\n";
    std::vector<std::string> words{
        "python3", "-c", kRun, as_argument(arguments.file), "--printer", arguments.import.printer};
    const std::pair<const char*, const std::string*> more[] = {
        {"--output", &arguments.folder},
        {"--unit", &arguments.unit},
        {"--mesh", &arguments.mesh},
        {"--profile", &arguments.import.profile}};
    for (const auto& [name, value] : more) {
        if (value->empty()) continue;
        words.emplace_back(name);
        words.push_back(*value);
    }
    std::vector<char*> argv;
    for (const std::string& word : words)
        argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    ::execvp(argv[0], argv.data());
    return outside_error(messages::kMaterialXWantsPython);
}

/// The budget of a converter; the usual one is said, too, for an option without a value takes the next word.
std::string memory_word(const ImportArguments& arguments) {
    constexpr const char* kUsual = "8GB";
    return "--memory=" + (arguments.memory.empty() ? kUsual : arguments.memory);
}

/// The extension of a print: a mesh for a printer that makes voxels of its own.
std::string extension_for(const std::string& printer) {
    const Result<world::Printer> known = world::load_printer(printer);
    const bool has_own = known && (known->mesh_colors || !known->knows_pitch());
    const backends::Format* native =
        has_own ? backends::find_format(known->native_format) : nullptr;
    const bool is_mesh = native != nullptr && native->kind == backends::FormatKind::kMesh;
    return is_mesh ? std::string(native->extension) : ".ofr";
}

/// Makes a 3MF file of the solids, in a folder that is removed, and goes on with that.
Result<void> import_step(ImportArguments arguments) {
    std::optional<double> tolerance;
    if (Result<void> read = read_length("--tolerance", arguments.tolerance, &tolerance); !read)
        return read;
    if (!arguments.unit.empty() || !arguments.up.empty())
        return usage_error(messages::kStepSaysUnit);
    const Result<world::Printer> printer = world::load_printer(arguments.import.printer);
    if (!printer) return printer.error();
    const Vec3d& pitch = printer->pitch_mm;
    if (!tolerance)
        tolerance = printer->knows_pitch() ? std::min({pitch.x, pitch.y, pitch.z}) / 4 : 0.01;
    const Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
    if (!scratch) return scratch.error();
    const fs::path solids =
        (*scratch)->path() / (fs::path(arguments.file).stem().string() + ".3mf");
    if (Result<void> made = run_converter(
            kStepConverter,
            {"--output=" + solids.string(), fmt::format("--tolerance={:.9g}mm", *tolerance),
             memory_word(arguments), "--", arguments.file},
            arguments.file);
        !made)
        return made;
    arguments.file = solids.string();
    arguments.tolerance.clear();
    return run_import(std::move(arguments));
}

/// Makes an OBJ file of the shapes, with its materials and pictures, and goes on with that.
Result<void> import_vrml(ImportArguments arguments) {
    const Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
    if (!scratch) return scratch.error();
    const fs::path obj = (*scratch)->path() / (fs::path(arguments.file).stem().string() + ".obj");
    if (Result<void> made = run_converter(
            kVrmlConverter,
            {"--output=" + obj.string(), memory_word(arguments), "--", arguments.file},
            arguments.file);
        !made)
        return made;
    arguments.file = obj.string();
    return run_import(std::move(arguments));
}

/// Makes an OBJ file of the meshes in mm, with their materials and pictures, and goes on with that.
Result<void> import_usd(ImportArguments arguments) {
    if (!arguments.unit.empty() || !arguments.up.empty())
        return usage_error(messages::kUsdSaysUnit);
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    if (const Result<InputFile> opened = InputFile::open(arguments.file); !opened)
        return with_context(opened.error(),
                            fmt::format(openfab::messages::kCannotRead, arguments.file));
    const Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
    if (!scratch) return scratch.error();
    const fs::path obj = (*scratch)->path() / (fs::path(arguments.file).stem().string() + ".obj");
    if (Result<void> made = run_usd_reader(arguments.file, obj, *memory); !made) return made;
    arguments.file = obj.string();
    return run_import(std::move(arguments));
}

}  // namespace

Result<void> run_import(ImportArguments arguments) {
    if (arguments.file.ends_with(".mtlx")) return import_materialx(arguments);
    if (!arguments.mesh.empty()) return usage_error(messages::kMeshIsForLooks);
    const std::string& unit = arguments.unit;
    if (const auto units = {"", "mm", "cm", "m", "um", "in"};
        std::find(units.begin(), units.end(), unit) == units.end())
        return usage_error(fmt::format(messages::kUnitIsAWord, unit));
    if (is_step_file(arguments.file)) return import_step(std::move(arguments));
    if (is_vrml_file(arguments.file)) return import_vrml(std::move(arguments));
    if (is_usd_file(arguments.file)) return import_usd(std::move(arguments));
    const bool is_print = is_print_path(arguments.file);
    if (is_print) {
        std::string_view name = option_of_meshes(arguments);
        if (name.empty() && !unit.empty()) name = "--unit";
        if (name.empty() && !arguments.import.profile.empty()) name = "--profile";
        if (!name.empty()) return usage_error(fmt::format(messages::kMeansNothingForPrints, name));
    }
    if (!arguments.tolerance.empty()) return usage_error(messages::kToleranceIsForStep);
    if (arguments.list) {
        const Result<mesh::MeshOptions> options = read_arguments(&arguments);
        if (!options) return options.error();
        return list_mesh(arguments.file, {options->unit_mm, options->y_up, options->repair,
                                          arguments.json, options->memory_bytes});
    }
    if (arguments.json) return usage_error(messages::kJsonIsForList);
    if (arguments.folder.empty()) return usage_error(messages::kNameTheFolder);
    const std::string stem = fs::path(arguments.file).stem().string();
    const bool is_scan = is_scan_file(arguments.file);
    const std::string file = stem + extension_for(arguments.import.printer);
    const Result<fs::path> world = is_print  ? import_print(arguments)
                                   : is_scan ? import_scan(arguments)
                                             : import_mesh(std::move(arguments));
    if (!world) return world.error();
    say(fmt::format(messages::kPrintIt, shell_word(world->string()), shell_word(file)));
    return {};
}

}  // namespace openfab::tools
