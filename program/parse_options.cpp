// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "abi/kernel_call.h"
#include "backends/formats/formats.h"
#include "base/command_line.h"
#include "base/talking_program.h"
#include "base/units.h"
#include "program/messages.h"
#include "program/option_texts.h"
#include "program/options.h"
#include "runtime/process/kinds/kinds.h"

namespace openfab::program {

namespace {

constexpr const char* kExamples = R"(Examples:
  {0} card.fab.json -o slices                    a folder of PNGs for the world's printer
  {0} card.fab.json -o card.ofr --draft 4        a quick look, at four times the pitch
  {0} card.fab.json -o card.ofr --preview card.png,light=transmitted
  {0} card.fab.json -o card.3mf --mesh-pitch 0.2mm   a mesh per material
  {0} part.obj -o part.ofr --voxel 0.1mm --set part.scale=2.5
  {0} card.fab.json -o card.ofr --resume         the rest of an interrupted print
  {0} card.fab.json -o - | openfab verify -      a stream of slices
  {0} card.fab.json -o tcp://printer:7000        to `openfab receive`, or a printer's front end

)";

constexpr const char* kUnits =
    R"(Lengths have units (27um, 0.1mm, 1in), sizes too (300MB). Exit codes: 0 done, 1 the input is wrong,
2 usage, 3 disk or pipe failed (whole slices stay), 4 a bug in OpenFab, 130 interrupted.
)";

/// Option texts as typed, before they are parsed.
struct Raw {
    std::string seed, voxel, mesh_pitch, dpi, layer, z, slices, part, memory, progress = "auto",
                                                                              png = "rgba", isa;
    std::string pitch, probe, slabs_in_flight, around, cell, cell_at, lattice, field_origin,
        field_spacing, slab_limit;
    std::vector<std::string> previews;
    std::string crop = "parts", sampling;
    bool no_cull = false;
};

void declare_output(CLI::App& app, Options& o, Raw& raw) {
    app.option_defaults()->group("Output");
    app.add_option(
           "-o,--output", o.output,
           fmt::format(
               "a folder ({}), a file ({}), - for standard output ({}), or a receiver: "
               "tcp://HOST:PORT, tls://HOST:PORT or unix:PATH",
               backends::format_names(
                   ",", [](const auto& f) { return f.kind == backends::FormatKind::kFolder; }),
               backends::file_extensions(),
               backends::format_names("or", [](const auto& f) { return f.streams; })))
        ->type_name("OUT");
    app.add_option(
           "--format", o.format,
           backends::format_names() + " (default: by OUT's extension, else the printer's own)")
        ->type_name("FORMAT");
    app.add_option("--token-file", o.token_file,
                   "a file whose first line is the receiver's token (or OPENFAB_TOKEN)")
        ->type_name("FILE");
    app.add_option("--tls-ca", o.tls_ca,
                   "PEM certificates to check a tls:// receiver's against (default: the "
                   "system's)")
        ->type_name("FILE");
    app.add_option("--preview", raw.previews,
                   "FILE.png[,view=top|bottom|front|right|back|left|section|slice:N|"
                   "model:TURN:TILT][,light=transmitted][,cut=x|y|xy]")
        ->allow_extra_args(false)
        ->type_name("PICTURE");
    app.add_option("--png", raw.png, "rgba or indexed")->check(CLI::IsMember({"rgba", "indexed"}));
    app.add_option("--grey-material", o.grey_material,
                   "the material in the grey pictures of the formats grey and tiff (default: the "
                   "world's first)")
        ->type_name("NAME");
    app.add_flag("--flip-x", o.flip_x, "mirror slices, for front ends that mirror them back");
    app.add_option("--fractions", o.fractions_file,
                   "an .npy file for the materials' fractions in each voxel, before the dither")
        ->type_name("FILE");
    app.add_option("--sampling", raw.sampling,
                   "meaning of these at a coarser pitch than the printer's: volume (means over its "
                   "voxels; the default) or centre (of a voxel's centre alone)")
        ->check(CLI::IsMember({"volume", "centre"}));
    app.add_option("--fractions-supersample", o.fractions_supersample,
                   "make these, and grey pictures (default: 4), the means over the N x N x N parts "
                   "of each voxel")
        ->type_name("N");
    app.add_option("--probe", raw.probe,
                   "print only the materials' fractions in the voxel at this point, in mm, "
                   "before the dither, as JSON")
        ->type_name("X,Y,Z");
    app.add_option("--stats", o.stats_file, "write statistics of the print to this file, as JSON")
        ->type_name("FILE");
}

void declare_part(CLI::App& app, Options& o, Raw& raw) {
    app.option_defaults()->group("Part of a print");
    app.add_option("--draft", o.draft, "multiply the pitch by N, for a quick look")
        ->type_name("N")
        ->option_text("N");
    app.add_option("--voxel", raw.voxel, "print cubic voxels of this size")->type_name("LENGTH");
    app.add_option("--dpi", raw.dpi, "resolution along x and y, such as 600x300")->type_name("DPI");
    app.add_option("--layer", raw.layer, "thickness of a slice")->type_name("LENGTH");
    app.add_option("--mesh-pitch", raw.mesh_pitch,
                   "size of the voxels that meshes are made from (default: 0.1mm)")
        ->type_name("LENGTH");
    app.add_option("--crop", raw.crop,
                   "size of a slice: parts (their bounding box) or tray (the whole tray)")
        ->check(CLI::IsMember({"parts", "tray"}));
    app.add_option("--z", raw.z, "print only the heights A:B above the lowest slice")
        ->type_name("A:B");
    app.add_option("--slices", raw.slices,
                   "print only the slices A:B, B excluded, or A: to the end")
        ->type_name("A:B");
    app.add_option("--part", raw.part,
                   "print only the I-th of N parts, each of about as many slices, for N machines")
        ->type_name("I/N");
    app.add_option(
           "--only-object", o.only_object,
           "print the voxels of this object alone, in the grid of the whole build; of one that "
           "the build does not have, where its mesh lies")
        ->type_name("NAME");
    app.add_flag("--resume", o.resume, "continue an interrupted print after its last whole slice");
}

void declare_material(CLI::App& app, Options& o, Raw& raw) {
    app.option_defaults()->group("World and material");
    app.add_option("--set", o.settings,
                   "OBJECT.UNIFORM=VALUE overrides the world's value (repeatable)")
        ->allow_extra_args(false)
        ->type_name("SETTING");
    app.add_option("--allow", o.allow,
                   "a folder that the world may read besides its own (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FOLDER");
    app.add_flag_callback(
        kProgramsWord, [&o] { o.allow.emplace_back(kProgramsWord); }, kProgramsHelp);
    app.add_option(
        "--dither", o.dither,
        "own (default: the fablet's @Dither if it has one, else blue_noise), blue_noise, "
        "floyd_steinberg, decorrelated, or majority (the largest amount; the default for meshes)");
    app.add_option("--seed", raw.seed, "seed of the dither")->type_name("N");
    app.add_option("--support", o.support,
                   "on, off, or the world's material to make it of (default: as the world says, "
                   "else on if the printer's front end makes none)")
        ->type_name("CHOICE");
}

void declare_machine(CLI::App& app, Options& o) {
    app.option_defaults()->group("Machine");
    app.add_option(
           "--printer", o.printer,
           "a name listed by `openfab printers` (default: the world's), or a .printer.json file")
        ->type_name("PRINTER");
    app.add_option(
           "--process", o.process_file,
           "the machine's effects on a print, as JSON: items replace those of the printer's "
           "profile (docs/process.md)")
        ->type_name("FILE");
    for (const process::Kind* kind : process::kinds()) {
        const process::Option& option = kind->option;
        if (option.name.empty()) continue;
        app.add_option_function<std::string>(
               std::string(option.name),
               [&o, name = std::string(option.name)](const std::string& value) {
                   if (!value.empty()) o.effects[name] = value;
               },
               std::string(option.help))
            ->type_name(std::string(option.value));
    }
    app.add_flag(
        "--as-built", o.as_built,
        "the part as it will come out of the machine: without the process' scale and field, "
        "and with what it does to voxels, which is --bleed both, if it has a bleed");
}

void declare_progress(CLI::App& app, Options& o, Raw& raw) {
    app.option_defaults()->group("Progress and resources");
    app.add_flag("--estimate", o.estimate,
                 "report voxels, memory, time and materials; print nothing");
    app.add_flag("--dry-run", o.dry_run, "check and set up everything; print nothing");
    app.add_option("--progress", raw.progress,
                   "on stderr: auto, plain, json (an object per line) or none")
        ->check(CLI::IsMember({"auto", "plain", "json", "none"}));
    app.add_option("--memory", raw.memory,
                   "memory budget of the whole process (default: 1.5GB, or the print's minimum, up "
                   "to half of the free memory)")
        ->type_name("SIZE");
    app.add_option("--threads", o.threads, "worker threads (default: all cores)")->type_name("N");
    app.add_option(
           "--slab-limit", raw.slab_limit,
           "end a print of which eight slices take longer than this, such as 10min; what is "
           "written stays")
        ->type_name("SECONDS");
    app.add_flag("--no-cache", o.no_cache,
                 "convert pictures and scans for this print alone, and keep nothing of them");
}

/// Options of tests and tools, which the help does not list.
void declare_unlisted(CLI::App& app, Options& o, Raw& raw) {
    app.option_defaults()->group("");
    // Of those that are not listed, a check here could not tell the name.
    app.add_option("--groups-in-flight", raw.slabs_in_flight, "");
    app.add_flag("--any-pitch", o.any_pitch, "");
    app.add_flag("--no-cull", raw.no_cull, "");
    app.add_option("--pitch", raw.pitch, "");
    app.add_option("--isa", raw.isa, "");
    app.add_option("--extents", o.extents_file, "");
    app.add_flag("--solid", o.altered.solid, "");
    app.add_option("--field", o.altered.field, "");
    for (const auto& [name, text] : {std::pair("--around", &raw.around),
                                     {"--cell", &raw.cell},
                                     {"--cell-at", &raw.cell_at},
                                     {"--field-origin", &raw.field_origin},
                                     {"--lattice", &raw.lattice},
                                     {"--field-spacing", &raw.field_spacing}})
        app.add_option(name, *text, "");
}

void declare(CLI::App& app, Options& o, Raw& raw) {
    app.add_option("INPUT", o.input,
                   "a world (.fab.json), or a mesh (.obj, .stl, …) if there is only one fablet")
        ->required();
    declare_output(app, o, raw);
    declare_part(app, o, raw);
    declare_material(app, o, raw);
    declare_machine(app, o);
    declare_progress(app, o, raw);
    declare_unlisted(app, o, raw);
}

/// Returns the help; to a host that takes the slices itself, without what asks for outputs.
std::string help_text(CLI::App* app, const std::string& program, bool needs_output) {
    app->get_formatter()->column_width(28);
    if (needs_output) {
        app->footer(fmt::format(fmt::runtime(kExamples), program) + kUnits);
        return app->help();
    }
    for (const char* option :
         {"--output", "--token-file", "--tls-ca", "--preview", "--fractions", "--sampling",
          "--fractions-supersample", "--probe", "--stats", "--estimate", "--dry-run", "--resume"})
        app->get_option(option)->group("");
    app->footer(kUnits);
    return app->help();
}

/// Reads the text of an option, where it was given.
template <typename T, typename Parse>
Result<void> read(const std::string& text, const Parse& parse, std::optional<T>* value) {
    if (text.empty()) return {};
    Result<T> found = parse(text);
    if (!found) return found.error();
    *value = *found;
    return {};
}

Result<void> read_grid(const Raw& raw, Options* o) {
    const auto length = [](const char* option) {
        return [=](const std::string& text) { return parse_length(option, text); };
    };
    const auto vector = [](const char* option, const char* example) {
        return [=](const std::string& text) { return parse_vector(option, text, example); };
    };
    for (const Result<void>& done : {
             read(raw.voxel, length("--voxel"), &o->voxel_mm),
             read(raw.dpi, parse_dpi, &o->dpi),
             read(raw.layer, length("--layer"), &o->layer_mm),
             read(raw.mesh_pitch, length("--mesh-pitch"), &o->mesh_pitch_mm),
             read(raw.pitch, vector("--pitch", "0.1,0.1,0.1"), &o->pitch_mm),
             read(raw.probe, vector("--probe", "1.5,2,0.25"), &o->probe_mm),
             read(raw.cell, vector("--cell", "8,8,8"), &o->altered.cell_mm),
             read(raw.cell_at, vector("--cell-at", "0.5,0.5,0"), &o->altered.cell_at_mm),
             read(raw.field_origin, vector("--field-origin", "0,0,0"), &o->altered.field_origin_mm),
             read(raw.field_spacing, vector("--field-spacing", "1,1,1"),
                  &o->altered.field_spacing_mm),
             read(raw.lattice, vector("--lattice", "0.1,0.1,0.1"), &o->altered.lattice_mm),
             read(raw.z, parse_heights, &o->z_range_mm),
             read(raw.slices, parse_slices, &o->slices),
             read(raw.part, parse_part, &o->part),
         }) {
        if (!done) return done;
    }
    return {};
}

Result<void> read_texts(const Raw& raw, Options* o) {
    const Result<int64_t> bytes = parse_memory_option(raw.memory);
    if (!bytes) return bytes.error();
    o->memory_bytes = *bytes;
    o->memory_given = !raw.memory.empty();
    if (!raw.seed.empty() && !parse_whole(raw.seed, &o->seed)) {
        return bad_value("--seed", raw.seed, messages::kNotASeed, "7");
    }
    for (const std::string& text : raw.previews) {
        Result<preview::PreviewSpec> spec = preview::parse_preview(text);
        if (!spec) return spec.error();
        o->previews.push_back(std::move(*spec));
    }
    if (!raw.slab_limit.empty()) {
        const bool plain = raw.slab_limit.find_first_not_of("0123456789.") == std::string::npos;
        const Result<double> limit = parse_duration(plain ? raw.slab_limit + "s" : raw.slab_limit);
        if (!limit || *limit <= 0)
            return bad_value("--slab-limit", raw.slab_limit, messages::kNotATime, "10min");
        o->slab_limit_seconds = *limit;
    }
    if (!raw.around.empty() && !parse_whole(raw.around, &o->altered.around))
        return bad_value("--around", raw.around, fmt::format(messages::kNotACount, kMostAround),
                         "1");
    o->progress = raw.progress == "plain"  ? program::ProgressMode::kPlain
                  : raw.progress == "json" ? program::ProgressMode::kJson
                  : raw.progress == "none" ? program::ProgressMode::kNone
                                           : program::ProgressMode::kAuto;
    o->crop_tray = raw.crop == "tray";
    o->png_indexed = raw.png == "indexed";
    o->sample_centres = raw.sampling == "centre";
    o->culling = !raw.no_cull;
    for (const openfab_isa isa : abi::isas()) {
        if (raw.isa == abi::isa_name(isa)) o->isa = isa;
    }
    if (!raw.isa.empty() && !o->isa)
        return bad_value(
            "--isa", raw.isa,
            abi::isas().size() > 1 ? messages::kNoInstructionSet : messages::kOnlySse41, "sse41");
    if (raw.slabs_in_flight.empty()) return {};
    int32_t slabs = 0;
    if (!parse_whole(raw.slabs_in_flight, &slabs))
        return bad_value("--groups-in-flight", raw.slabs_in_flight, messages::kNotSlabs, "8");
    o->slabs_in_flight = slabs;
    return {};
}

bool has_output(const Options& o) {
    return !o.output.empty() || !o.previews.empty() || !o.stats_file.empty() ||
           !o.fractions_file.empty() || o.estimate || o.dry_run || o.probe_mm ||
           !o.extents_file.empty();
}

/// Returns all options that were given.
std::vector<job::OptionWords> words_of(const CLI::App& app) {
    std::vector<job::OptionWords> words;
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0) continue;
        const bool is_flag = option->get_type_size() == 0;
        words.push_back({option->get_name(option->get_positional()),
                         is_flag ? std::vector<std::string>() : option->results()});
    }
    return words;
}

/// Whether the output may be grey pictures: those of a format, or a folder of a printer that takes
/// them, which the world names.
bool may_be_grey(const Options& o) {
    const backends::Format* format = backends::find_format(o.format);
    if (format != nullptr) return format->of_fractions;
    return !o.output.empty() && o.output != "-" && !std::filesystem::path(o.output).has_extension();
}

}  // namespace

Result<Options> parse_options(int argc, const char* const* argv, const std::string& program,
                              bool needs_output) {
    Options options;
    Raw raw;
    CLI::App app("Prints a fab world: slices for a printer, an .ofr file or stream, pictures.",
                 program);
    declare(app, options, raw);
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        options.help = true;
        options.text = help_text(&app, program, needs_output);
        return options;
    } catch (const CLI::ParseError& error) {
        return command_line_error(app, error, program);
    }
    options.words = words_of(app);
    if (Result<void> done = read_grid(raw, &options); !done) return done.error();
    if (Result<void> done = read_texts(raw, &options); !done) return done.error();
    if (Result<void> done = validate_options(options); !done) return done.error();
    const bool averages = options.fractions_supersample.value_or(1) > 1 || !raw.sampling.empty();
    if (needs_output && averages && options.fractions_file.empty() && !may_be_grey(options)) {
        return usage_error(fmt::format(messages::kAboutFractions, raw.sampling.empty()
                                                                      ? "--fractions-supersample"
                                                                      : "--sampling"));
    }
    if (needs_output && !has_output(options)) return usage_error(messages::kNoOutput);
    return options;
}

}  // namespace openfab::program
