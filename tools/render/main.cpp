// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-render`: pictures of how a print will look. `openfab render` executes this program.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <string>

#include "base/allowance.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/talking_program.h"
#include "base/units.h"
#include "tools/render/messages.h"
#include "tools/render/render.h"

namespace openfab::render {

namespace {

constexpr const char* kFooter = R"(Examples:
  openfab render card.ofr -o card.png --view top
  openfab render card.ofr -o light.png --view top --light behind
  openfab render fish.fab.json -o fish.png --draft 2 --samples 256
)";

/// What is parsed later.
struct Texts {
    std::string size = "800x600";
    std::string time, memory;
};

Result<void> read_size(const std::string& text, FilmOptions* film) {
    constexpr int32_t kMost = 16384;
    const char* const end = text.data() + text.size();
    const auto [x, bad] = std::from_chars(text.data(), end, film->width);
    if (bad == std::errc() && x != end && *x == 'x') {
        const auto [rest, worse] = std::from_chars(x + 1, end, film->height);
        if (worse == std::errc() && rest == end && film->width > 0 && film->height > 0 &&
            film->width <= kMost && film->height <= kMost)
            return {};
    }
    return usage_error(fmt::format(messages::kNoSize, text, kMost));
}

Result<void> complete(const Texts& texts, RenderOptions* options) {
    if (!options->output.ends_with(".png") && !options->output.ends_with(".pfm")) {
        return usage_error(fmt::format(messages::kWritePngOrPfm, options->output));
    }
    if (Result<void> read = read_size(texts.size, &options->film); !read) return read;
    if (!texts.time.empty()) {
        const Result<double> seconds = parse_duration(texts.time);
        if (!seconds) return usage_error(fmt::format(messages::kInTime, seconds.error().text()));
        options->film.seconds = *seconds;
    }
    const Result<int64_t> memory = parse_memory_option(texts.memory);
    if (!memory) return memory.error();
    options->memory_bytes = *memory;
    const Result<std::filesystem::path> programs = program_folder();
    if (!programs) return programs.error();
    options->programs = *programs;
    return {};
}

void declare(CLI::App* app, RenderOptions* o, Texts* texts) {
    app->add_option(
           "FILE", o->input,
           "an .ofr file, a folder of slices, or a world (.fab.json), which is printed first")
        ->required();
    app->add_option("-o,--output", o->output, "the picture: .png, or .pfm for linear light")
        ->required()
        ->type_name("FILE");
    app->add_option("--size", texts->size, "of the picture (default: 800x600)")->type_name("WxH");
    app->add_option("--samples", o->film.samples, "paths per pixel (default: 64)")
        ->type_name("N")
        ->check(CLI::Range(1, 1'000'000));
    app->add_option("--time", texts->time, "end after this time, with fewer samples")
        ->type_name("TIME");
    app->add_option(
        "--view", o->scene.view,
        "top, bottom, front, right, back, left, or model:TURN:TILT, at an angle (default: "
        "model:30:30)");
    app->add_option("--zoom", o->scene.zoom, "enlarge the middle (default: 1)")
        ->check(CLI::Range(0.01, 1000.0));
    app->add_option("--light", o->scene.light,
                    "studio; behind; dome, from everywhere; or one lamp at TURN:TILT, degrees from "
                    "the camera to its left and above it (default: studio)");
    app->add_option("--backdrop", o->scene.backdrop,
                    "colour of the ground, or none (default: #c8c8c8)")
        ->type_name("COLOUR");
    app->add_option("--exposure", o->exposure_stops, "brighten by this many stops (default: 0)")
        ->type_name("STOPS")
        ->check(CLI::Range(-30.0, 30.0));
    app->add_option("--optics", o->optics, "a file of materials' optical properties")
        ->type_name("FILE");
    app->add_option("--roughness", o->roughness,
                    "of the surface, 0 to 1; default: from the optical properties")
        ->check(CLI::Range(0.0, 1.0));
    app->add_option("--draft", o->draft, "of a world: multiply the pitch by N (default: 1)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000));
    app->add_option("--set", o->settings, "of a world: OBJECT.UNIFORM=VALUE (repeatable)")
        ->allow_extra_args(false)
        ->type_name("SETTING");
    app->add_option("--allow", o->allow,
                    "a folder that a world may read besides its own (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FOLDER");
    app->add_flag_callback(
        kProgramsWord, [o] { o->allow.emplace_back(kProgramsWord); }, kProgramsHelp);
    app->add_option("--describe", o->describe, "write camera, lamps and surface to this file, too")
        ->type_name("FILE");
    app->add_option("--seed", o->film.seed, "of the samples (default: 0)")->type_name("N");
    app->add_option("--threads", o->film.threads, "default: all cores")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    app->add_option("--memory", texts->memory,
                    "memory budget of the whole process (default: 1.5GB)")
        ->type_name("SIZE");
    app->add_flag("-q,--quiet", o->quiet, "say nothing but errors");
    app->footer(kFooter);
}

int render_main(int argc, char** argv) {
    prepare_streams();
    CLI::App app("Shows how a print will look: traces light through its voxels.", "openfab render");
    RenderOptions options;
    options.film.threads = usable_cores();
    Texts texts;
    declare(&app, &options, &texts);
    return run_command_line(&app, argc, argv, "openfab render", [&] {
        const Result<void> complete_options = complete(texts, &options);
        return complete_options ? render(options) : complete_options;
    });
}

}  // namespace

}  // namespace openfab::render

int main(int argc, char** argv) {
    return openfab::run_main(openfab::render::render_main, argc, argv);
}
