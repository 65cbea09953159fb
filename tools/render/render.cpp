// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/render.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <utility>

#include "backends/common/output_file.h"
#include "base/clock.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/talking_program.h"
#include "base/text.h"
#include "base/units.h"
#include "client/child.h"
#include "client/print_words.h"
#include "program/interrupt.h"
#include "program/output_check.h"
#include "tools/render/messages.h"
#include "tools/render/optics.h"
#include "tools/render/read_print.h"

namespace openfab::render {

namespace {

namespace fs = std::filesystem;

constexpr double kWriteSeconds = 10;  ///< between versions of a file that is not ready
constexpr double kSaySeconds = 2;

bool is_world(const std::string& input) {
    return input.ends_with(".json");
}

/// Prints a world into `ofr` by `openfab print`, beside this program.
Result<void> print_world(const RenderOptions& options, const fs::path& folder,
                         const fs::path& ofr) {
    std::vector<std::string> argv{(options.programs / "openfab").string(),
                                  "print",
                                  as_argument(options.input),
                                  "-o",
                                  ofr.string(),
                                  "--draft",
                                  std::to_string(options.draft),
                                  "--memory",
                                  fmt::format("{}B", options.memory_bytes),
                                  "--threads",
                                  std::to_string(options.film.threads),
                                  "--any-pitch",
                                  "--progress",
                                  "plain"};
    for (const std::string& one : options.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& one : options.settings)
        argv.insert(argv.end(), {"--set", one});
    if (!options.quiet) say(messages::kPrintingWorld);
    const fs::path err = folder / "print.err";
    const Result<void> done = client::run(argv, folder / "print.out", err);
    constexpr int64_t kMostSaid = 64 << 10;
    if (done && !options.quiet)
        say(client::words_of(client::end_of_file(err, kMostSaid), true).text);
    return done;
}

Result<OpticsTable> read_optics(const std::string& file) {
    constexpr size_t kMostBytes = 4 << 20;
    Result<std::string> text = read_text_file(file, kMostBytes);
    if (!text) return text.error();
    return parse_optics(*text, file);
}

void say_about(const ReadPrint& print, const Optics& optics) {
    const Vec3i& cell = print.cell;
    if (cell.x * cell.y * cell.z > 1) {
        const Vec3d& mm = print.volume.pitch_mm();
        note(fmt::format(messages::kVoxelsTakenTogether, cell.x, cell.y, cell.z, mm.x, mm.y, mm.z));
    }
    if (print.slices < print.info.slice_end - print.info.slice_begin) {
        note(fmt::format(messages::kPrintNotComplete, print.slices,
                         print.info.slice_end - print.info.slice_begin));
    }
    if (!optics.guessed.empty()) {
        note(fmt::format(messages::kLightGuessed, fmt::join(optics.guessed, ", ")));
    }
}

/// Traces until all is done, and writes what there is now and then.
Result<void> make_picture(const RenderOptions& options, const Tracer& tracer,
                          const std::atomic<bool>& stop) {
    Film film(options.film);
    Result<void> written;
    const double start = seconds_now();
    double said = start;
    double wrote = start;
    int32_t done = 0;
    {
        const program::DeferredInterrupt deferred;
        film.trace(tracer, stop, [&](int32_t samples) {
            done = samples;
            const double now = seconds_now();
            if (!options.quiet && now - said >= kSaySeconds) {
                said = now;
                say(fmt::format("{} of {} samples a pixel, {:.3g} M paths/s\n", samples,
                                options.film.samples,
                                static_cast<double>(film.paths()) / (now - start) * 1e-6));
            }
            if (now - wrote >= kWriteSeconds && samples < options.film.samples) {
                written = write_picture(film, options.output, options.exposure_stops);
                wrote = seconds_now();
            }
            return written.has_value();
        });
        const double seconds = seconds_now() - start;
        if (!written) return written;
        if (film.paths() == 0)
            return Error{ErrorCode::kInterrupted, messages::kNothingTraced, "", {}};
        written = write_picture(film, options.output, options.exposure_stops);
        if (!written) return written;
        if (!options.quiet) {
            say(fmt::format("{}: {} x {}, {} samples a pixel, {:.3g} M paths in {} ({:.3g} M/s)\n",
                            printable(options.output), options.film.width, options.film.height,
                            film.fewest(), static_cast<double>(film.paths()) * 1e-6,
                            format_seconds(seconds),
                            static_cast<double>(film.paths()) / seconds * 1e-6));
        }
    }
    if (stop) {
        return Error{ErrorCode::kInterrupted,
                     fmt::format(messages::kInterruptedPicture, options.output),
                     "",
                     {}};
    }
    return {};
}

/// Refuses outputs that are inputs.
Result<void> check_files(const RenderOptions& options) {
    std::vector<program::NamedOutput> outputs{{"-o", options.output}};
    if (!options.describe.empty()) outputs.push_back({"--describe", options.describe});
    std::vector<fs::path> inputs{options.input};
    if (!options.optics.empty()) inputs.emplace_back(options.optics);
    return program::check_outputs(outputs, inputs);
}

}  // namespace

Result<void> render(const RenderOptions& options) {
    const std::atomic<bool>& stop =
        program::install_interrupt(exit_code(ErrorCode::kInterrupted), "error: interrupted\n");
    if (Result<void> apart = check_files(options); !apart) return apart;
    // Mistakes are told before a world is printed.
    SceneOptions scene_options = options.scene;
    scene_options.aspect = static_cast<double>(options.film.width) / options.film.height;
    if (Result<Scene> trial = make_scene(scene_options, {{0, 0, 0}, {1, 1, 1}}); !trial)
        return trial.error();
    std::optional<OpticsTable> own;
    if (!options.optics.empty()) {
        Result<OpticsTable> read = read_optics(options.optics);
        if (!read) return read.error();
        own = std::move(*read);
    }
    const int64_t film_bytes = Film::bytes(options.film.width, options.film.height);
    constexpr int64_t kProgram = 40'000'000;  // its code, its threads
    const int64_t left = options.memory_bytes - film_bytes - kProgram;
    if (left <= 0) {
        return user_error(fmt::format(messages::kPictureTakes, options.film.width,
                                      options.film.height, format_bytes(film_bytes + kProgram),
                                      format_bytes(options.memory_bytes)));
    }
    std::unique_ptr<TemporaryFolder> folder;
    std::string file = options.input;
    const std::pair<bool, const char*> of_worlds[] = {{options.draft != 1, "--draft"},
                                                      {!options.settings.empty(), "--set"},
                                                      {!options.allow.empty(), "--allow"}};
    for (const auto& [is_given, option] : of_worlds) {
        if (is_given && !is_world(options.input))
            return usage_error(fmt::format(messages::kOptionOfWorlds, option, options.input));
    }
    if (is_world(options.input)) {
        Result<std::unique_ptr<TemporaryFolder>> made = TemporaryFolder::create();
        if (!made) return made.error();
        folder = std::move(*made);
        const fs::path ofr = folder->path() / "print.ofr";
        if (Result<void> printed = print_world(options, folder->path(), ofr); !printed)
            return printed;
        file = ofr.string();
    }
    Result<ReadPrint> print = read_print(file, left);
    if (!print) return print.error();
    folder.reset();
    Optics optics = optics_of(print->info, own ? &*own : nullptr);
    if (!print->mixtures.empty())
        optics = optics_of_mixtures(optics, print->mixed, print->mixtures);
    if (options.roughness) optics.surface.roughness = *options.roughness;
    if (!options.quiet) say_about(*print, optics);
    Result<Scene> scene = make_scene(scene_options, print->volume.solid_mm());
    if (!scene) return scene.error();
    if (!options.describe.empty()) {
        const std::string text = describe_scene(*scene, optics.surface);
        if (Result<void> done = backends::write_whole_file(fs::path(options.describe), text); !done)
            return done;
    }
    const Tracer tracer(&print->volume, optics, std::move(*scene));
    return make_picture(options, tracer, stop);
}

}  // namespace openfab::render
