// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/command_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "backends/formats/formats.h"
#include "base/say.h"
#include "base/talking_program.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/converter.h"

namespace openfab::tools {

void add_memory_option(CLI::App* command, std::string* text) {
    command->add_option("--memory", *text, "memory budget of the whole process (default: 1.5GB)")
        ->type_name("SIZE");
}

void add_set_option(CLI::App* command, std::vector<std::string>* settings) {
    command
        ->add_option("--set", *settings,
                     "of a world, as for its print: OBJECT.UNIFORM=VALUE (repeatable)")
        ->allow_extra_args(false)
        ->type_name("SETTING");
}

void add_world_options(CLI::App* command, std::vector<std::string>* allow,
                       std::vector<std::string>* settings) {
    add_set_option(command, settings);
    command
        ->add_option("--allow", *allow,
                     "a folder that the world may read besides its own (repeatable)")
        ->allow_extra_args(false);
    command->add_flag_callback(
        kProgramsWord, [allow] { allow->emplace_back(kProgramsWord); }, kProgramsHelp);
}

namespace {

// Each add_ function declares a command, which sets `*action` when it is the one given.

void add_new(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand("new", "make a folder with a fablet and a world");
    auto name = std::make_shared<std::string>();
    auto from = std::make_shared<std::string>("starter");
    command->add_option("NAME", *name, "the folder; its last part names the fablet")->required();
    command->add_option("--template", *from, template_names() + " (default: starter)");
    command->callback([name, from, action] {
        *action = [name, from]() -> Result<void> {
            const Result<std::string> made = make_folder(*name, *from);
            if (!made) return made.error();
            say(*made);
            return {};
        };
    });
}

void add_coupon(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "coupon", "print a plate that shows what a printer makes of voxels, and its world");
    auto a = std::make_shared<CouponArguments>();
    command->add_option("--printer", a->printer, "a printer, as `openfab printers` lists them")
        ->required();
    command->add_option("-o,--output", a->folder, "the folder to make")->required();
    command
        ->add_option("--material", a->materials,
                     "a material (repeatable): the plate's first, then the one that stands out "
                     "most; default: the profile's")
        ->allow_extra_args(false);
    command->add_option("--format", a->format, "default: the printer's");
    for (const auto& [option, help] :
         {std::pair("--dpi", "voxels per inch, such as 600x300, where the profile has none"),
          std::pair("--layer", "the thickness of a slice, such as 27um, likewise"),
          std::pair("--voxel", "the size of a voxel, likewise"),
          std::pair("--draft", "voxels so many times as large, for a quick look")}) {
        command->add_option_function<std::string>(
            option,
            [a, option = option](const std::string& value) {
                a->print.emplace_back(option);
                a->print.push_back(value);
            },
            help);
    }
    command->callback([a, action] { *action = [a] { return run_coupon(*a); }; });
}

void add_import(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "import", "make a world from a mesh, its colours and its pictures, or from a print");
    auto a = std::make_shared<ImportArguments>();
    command
        ->add_option("FILE", a->file,
                     "a mesh: " + importable_meshes() +
                         "; .mtlx; .dcm of segments; or a print: .ofr, .gcvf or a folder of slices")
        ->required();
    command->add_option("-o,--output", a->folder, "the folder to make");
    command->add_flag("--list", a->list,
                      "make nothing: show the file's bodies, unit, materials and pictures, and "
                      "what would be omitted");
    command->add_flag("--json", a->json, "with --list: as JSON");
    command->add_option("--fablet", a->import.fablet,
                        "solid, mixed, textured, mapped, painted, graded, shell, lattice, infill "
                        "or relief, for all bodies; default: whatever fits each");
    command->add_flag("--one-material", a->import.one_material, "all bodies of one material");
    command->add_option("--picture", a->import.picture,
                        "an image for textured, mapped or relief, instead of the mesh's own");
    command->add_option("--profile", a->import.profile,
                        "a table of inks from `openfab color bake`, with which textured, mapped "
                        "and painted mix colours; default: a formula");
    command
        ->add_option("--mapping", a->import.mapping,
                     "how a picture lies on the mesh: uv, by its texture coordinates; planar, from "
                     "one side; box, on six sides; triplanar, blended between them")
        ->check(CLI::IsMember({"uv", "planar", "box", "triplanar"}));
    command
        ->add_option("--side", a->import.side,
                     "planar from the front (-y), right, back, left, top or bottom; else the "
                     "largest")
        ->check(CLI::IsMember({"front", "right", "back", "left", "top", "bottom"}));
    command->add_option(
        "--picture-size", a->picture_size,
        "of a mapped picture, which then repeats, such as 20mm; default: as large as the mesh");
    command->add_option("--size", a->size, "of its longest side, such as 60mm; default: as it is");
    command->add_option("--unit", a->unit,
                        "of the file's numbers: mm, cm, m, um or in; of looks of MaterialX a "
                        "length, such as 20mm");
    command->add_option("--mesh", a->mesh, "of looks of MaterialX: what they are put on");
    command->add_option("--up", a->up, "the axis of the file that points up: z, or y")
        ->check(CLI::IsMember({"z", "y"}));
    command->add_option("--repair", a->repair, "winding: close a mesh that is open or inconsistent")
        ->check(CLI::IsMember({"winding"}));
    command->add_flag("--recentre", a->recentre,
                      "move distant parts to the origin, where numbers are precise");
    command->add_option("--tolerance", a->tolerance,
                        "of a STEP file: how far triangles may be from its surfaces, such as "
                        "0.01mm; default: a quarter of the printer's voxel");
    command->add_option("--printer", a->import.printer, "default: generic");
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_import(*a); }; });
}

void add_info(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand("info",
                                           "describe an .ofr file, a .zarr store, a folder of "
                                           "slices, a world, a mesh, a picture or a volume");
    auto file = std::make_shared<std::string>();
    command->add_option("FILE", *file, "an .ofr file, a folder of slices, a .fab.json or a mesh")
        ->required();
    auto allow = std::make_shared<std::vector<std::string>>();
    command
        ->add_option("--allow", *allow,
                     "a folder that a world may read besides its own (repeatable)")
        ->allow_extra_args(false);
    auto memory = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "of a mesh: as JSON");
    add_memory_option(command, memory.get());
    command->callback([file, allow, memory, json, action] {
        *action = [file, allow, memory, json] { return info(*file, *allow, *memory, *json); };
    });
}

void add_verify(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("verify", "check every slice of a print, as it was written");
    auto file = std::make_shared<std::string>();
    command
        ->add_option("FILE", *file,
                     "an .ofr file, or - for standard input; a .zarr store; a folder of slices; an "
                     ".npy, .stl, "
                     ".3mf or .gcvf file of a print")
        ->required();
    auto memory = std::make_shared<std::string>();
    add_memory_option(command, memory.get());
    command->callback(
        [file, memory, action] { *action = [file, memory] { return verify(*file, *memory); }; });
}

/// Declares what `export` and `merge` write; `other` and `more`: files and formats besides a print's.
void add_copy_options(CLI::App* command, ExportOptions* options, const std::string& other,
                      const std::vector<std::string>& more) {
    command->add_option("-o,--output", options->print.output,
                        "a folder, or a file: " + backends::file_extensions() + other);
    // What needs mixtures, which slices have no more, says so itself.
    std::vector<std::string> formats, known;
    for (const backends::Format* format : backends::formats()) {
        known.emplace_back(format->name);
        if (!format->needs_mixtures) formats.emplace_back(format->name);
    }
    formats.insert(formats.end(), more.begin(), more.end());
    known.insert(known.end(), more.begin(), more.end());
    command
        ->add_option("--format", options->print.format,
                     fmt::format("{} (default: by the output's extension, else png)",
                                 fmt::join(formats, ", ")))
        ->check(CLI::IsMember(known).description(fmt::format("{{{}}}", fmt::join(formats, ","))));
    command->add_option("--png", options->png, "rgba or indexed")
        ->check(CLI::IsMember({"rgba", "indexed"}));
    command->add_flag("--flip-x", options->print.flip_x,
                      "mirror the slices, for front ends that mirror them back");
    command
        ->add_option("--preview", options->previews,
                     "FILE.png[,view=top|bottom|front|right|back|left|section|slice:N|"
                     "model:TURN:TILT][,light=transmitted][,cut=x|y|xy]")
        ->allow_extra_args(false);
    add_memory_option(command, &options->memory);
}

void add_export(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand("export",
                                           "write an .ofr file as a folder of PNGs, as meshes or "
                                           "as pictures; a world as functions of 3MF");
    auto options = std::make_shared<ExportOptions>();
    command
        ->add_option("FILE", options->file,
                     "an .ofr file, or - for standard input; or a world, .fab.json")
        ->required();
    command->add_option("--slice", options->slice, "write only slice N, as one picture")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--voxel", options->voxel,
                     "of a world that becomes images: their voxels (default: 256 along it)")
        ->type_name("LENGTH");
    command->add_flag("--composite", options->composite,
                      "of a world: mixtures as in the volumetric extension, which lib3mf 2.5 "
                      "does not read");
    command->add_flag("--allow-programs", options->programs,
                      "of a world that becomes images: run the programs that it names; never use "
                      "it for a stranger's world");
    add_set_option(command, &options->settings);
    add_copy_options(command, options.get(), "; with --slice a .png file", {"vdb"});
    command->callback([options, action] { *action = [options] { return run_export(*options); }; });
}

void add_merge(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("merge", "join the parts of one print, made with --slices");
    auto options = std::make_shared<MergeOptions>();
    command->add_option("FILES", options->files, "complete .ofr files, in any order")->required();
    command->add_flag("--whole", options->whole,
                      "fail where slices of the print are in no file, instead of a warning");
    add_copy_options(command, &options->output, {}, {});
    command->callback([options, action] { *action = [options] { return run_merge(*options); }; });
}

void add_archive(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "archive", "keep all that a print was made from in one file, and print it again elsewhere");
    auto a = std::make_shared<ArchiveArguments>();
    command->add_option("PRINT", a->file, "an .ofr file or folder of slices; or an archive")
        ->required();
    command->add_option("-o,--output", a->output, "the archive, a .zip; with --reprint the print")
        ->required()
        ->type_name("OUT");
    command->add_option("--attach", a->attached, "a report to keep with it (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FILE");
    command->add_option("--operator", a->person, "who is named on the page that is signed")
        ->type_name("NAME");
    command->add_flag("--reprint", a->reprint,
                      "print again, and say whether all voxels are the same");
    command->add_flag(kProgramsWord, a->programs, "of a reprint: run the programs of its world");
    command->add_option("--threads", a->threads, "of a reprint (default: all cores)")
        ->check(CLI::Range(1, 1024))
        ->type_name("N");
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_archive(*a); }; });
}

void add_cache(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "cache", "list, bound or purge what is kept between prints, converted scans among it");
    auto a = std::make_shared<CacheArguments>();
    command->add_flag("--files", a->files, "list each file, those unused longest first");
    CLI::Option* limit =
        command->add_option("--limit", a->limit,
                            "remove what is unused longest until the rest takes this, such as 5GB");
    limit->type_name("SIZE");
    command->add_option("--purge", a->purge, "remove all of a kind")
        ->check(CLI::IsMember(cache_kinds()))
        ->excludes(limit);
    command->callback([a, action] { *action = [a] { return run_cache(*a); }; });
}

void add_printers(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "printers", "list known printers, or show one with the sources of its figures");
    auto name = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    command->add_option("NAME", *name, "a printer, or a .printer.json file");
    command->add_flag("--json", *json, "as JSON");
    command->callback(
        [name, json, action] { *action = [name, json] { return list_printers(*name, *json); }; });
}

void add_property(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "property", "make an OpenFL module from a table of mixtures with a measured property");
    auto a = std::make_shared<PropertyArguments>();
    command->add_option("TABLE", a->table, "a .json file, see docs/how-to/fields.md")->required();
    command->add_option("-o,--output", a->output, "the .fl file (default: standard output)");
    command->add_option("--temperature", a->temperature,
                        "at which values are, where the table has several, such as 23C");
    command->add_option(
        "--rate", a->rate,
        "likewise, such as 0.01/s, 1Hz, or the time in which the load is applied, 100s");
    command->callback([a, action] { *action = [a] { return make_property_module(*a); }; });
}

void add_view(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "view", "show a print (even an unfinished one), a world or a mesh in a browser");
    auto a = std::make_shared<ViewArguments>();
    viewer::ViewOptions& view = a->view;
    command->add_option(
        "FILE", view.file,
        "an .ofr file, a .zarr store, a folder of slices, a world (.fab.json), or a mesh, which "
        "is imported temporarily");
    command
        ->add_option(
            "--new", a->new_folder,
            "make a folder with a fablet and a world as `openfab new` does, and view it with "
            "--watch")
        ->type_name("NAME");
    command
        ->add_option("--template", a->from, "of --new: " + template_names() + " (default: starter)")
        ->type_name("TEMPLATE");
    command->add_option("OTHER", view.compare, "a second print, to see the difference");
    command
        ->add_option(
            "--world", view.world,
            "the world that a print was made from, to see its parts and the dither's input")
        ->type_name("WORLD");
    command
        ->add_option(
            "--fablet", view.fablet,
            "for a mesh that was printed alone, `--world MESH`: the `--fablet` of its print")
        ->type_name("FABLET");
    command->add_flag("--watch", view.watch,
                      "print a world again whenever it changes, and let the page change it");
    command
        ->add_option(
            "--draft", view.draft,
            "of a world: multiply the pitch by N (default: as the part needs, coarse first)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000));
    add_set_option(command, &view.settings);
    command
        ->add_option("--allow", view.allow,
                     "a folder that a world may read besides its own (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FOLDER");
    command->add_flag_callback(
        kProgramsWord, [a] { a->view.allow.emplace_back(kProgramsWord); }, kProgramsHelp);
    command
        ->add_option("--listen", view.address,
                     "the address to listen at (default: 127.0.0.1, this machine alone)")
        ->type_name("ADDRESS");
    command->add_option("--port", view.port, "default: any free one")
        ->type_name("N")
        ->check(CLI::Range(0, 65535));
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_view(*a); }; });
}

void add_receive(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("receive", "receive a streamed print, as a printer would");
    auto a = std::make_shared<ReceiveArguments>();
    command->add_option("--listen", a->listen, "tcp://HOST:PORT, tls://HOST:PORT or unix:PATH")
        ->required();
    command->add_option("-o,--output", a->output, "an .ofr file, or a folder of PNGs")->required();
    command->add_option("--token-file", a->token_file,
                        "a file whose first line senders must know (or OPENFAB_TOKEN); needed if "
                        "other machines can connect");
    command->add_option("--tls-cert", a->tls_certificate,
                        "of tls://: a PEM file with this machine's certificate and its chain");
    command->add_option("--tls-key", a->tls_key, "of tls://: a PEM file with its key");
    command->add_option("--layer-time", a->layer_time,
                        "consume a slice this often, such as 10s, and report late ones");
    command->add_option("--log", a->log, "append who came and what was taken, as JSON");
    command->add_option("--buffer", a->buffer, "slices to buffer for the layer time (default: 20)")
        ->check(CLI::Range(1, 1000));
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_receive(*a); }; });
}

}  // namespace

void add_commands(CLI::App& app, Action* action) {
    add_new(app, action);
    add_coupon(app, action);
    add_specimens(app, action);
    add_import(app, action);
    add_info(app, action);
    add_verify(app, action);
    add_export(app, action);
    add_merge(app, action);
    add_printers(app, action);
    add_archive(app, action);
    add_cache(app, action);
    add_property(app, action);
    add_part_commands(app, action);
    add_view(app, action);
    add_receive(app, action);
}

}  // namespace openfab::tools
