// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <vector>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/standard_error.h"
#include "base/units.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

std::optional<int> parse_texture_job(int argc, char** argv, TextureJob* job) {
    texture::VolumeOptions& volume = job->options;
    texture::ImageOptions& options = volume.image;
    texture::ReadLimits& limits = job->limits;
    std::vector<double> origin, spacing;
    std::string memory, pitch;
    CLI::App app(
        "Makes the filtered pyramid of an image; print binaries call it for images that are not in "
        "their cache.",
        "openfab texture");
    app.add_option("IMAGE", job->input,
                   "a picture: PNG, JPEG, TIFF, OpenEXR, Radiance HDR, PNM, BMP, TGA, GIF or WebP")
        ->required();
    CLI::Option* const output = app.add_option("-o,--output", job->output, "the .oftx file");
    CLI::Option* const check =
        app.add_flag("--check", job->check, "decode the picture, and write nothing");
    check->excludes(output);
    app.add_option("--space", options.space, "auto, srgb, linear or data")
        ->check(CLI::IsMember({"auto", "srgb", "linear", "data"}));
    CLI::Option* const luminance =
        app.add_flag("--luminance", options.luminance, "convert three channels to one");
    app.add_flag("--opaque", options.opaque, "leave the picture's alpha out")->excludes(luminance);
    app.add_flag("--volume", job->is_volume,
                 "the image is a volume: slices in one file, a folder or a pattern; NRRD, NPY, "
                 "NIfTI, MetaImage, Zarr, .cube, .vti, "
                 ".vtr, .vts, .vtu, .vtk, .xdmf");
    app.add_option("--origin", origin, "a volume's lowest corner in mm, X,Y,Z")
        ->delimiter(',')
        ->expected(3);
    app.add_option("--memory", memory, "memory budget (default: 1.5GB)");
    app.add_option("--below", limits.roots,
                   "a folder below which data files of NRRD may lie (default: its own)")
        ->allow_extra_args(false);
    app.add_option("--spacing", spacing, "the size of a volume's texels in mm, X,Y,Z")
        ->delimiter(',')
        ->expected(3);
    app.add_option("--field", volume.field, "which of several arrays, grids or series is read");
    app.add_option("--unit", volume.unit, "of a volume's lengths (default: the file's, else mm)")
        ->check(CLI::IsMember({"mm", "cm", "m", "um", "in"}));
    app.add_option("--pitch", pitch, "of the texels of a resampled volume, such as 0.5mm");
    app.add_option("--outside", volume.outside, "the value where a volume's file has none");
    app.add_option("--time", volume.time,
                   "which step of an .xdmf file is read (default: the first), or which time of "
                   "DICOM slices");
    app.add_option("--segment", volume.segment, "which segment of a DICOM file is read");
    app.add_option("--echo", volume.echo, "which echo of DICOM slices is read");
    app.add_option("--detector", volume.detector, "which detector of DICOM slices is read");
    app.add_option("--energy-window", volume.energy_window,
                   "which energy window of DICOM slices is read");
    app.add_option("--phase", volume.phase, "which phase of DICOM slices is read");
    add_examples(&app,
                 "  openfab texture photo.png -o photo.oftx\n"
                 "  openfab texture scan.nrrd --volume -o scan.oftx\n");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        show(app.help());
        return 0;
    } catch (const CLI::ParseError& error) {
        return say_error(command_line_error(app, error, "openfab texture"));
    }
    const auto three = [](const std::vector<double>& v) {
        return std::array<double, 3>{v[0], v[1], v[2]};
    };
    if (!origin.empty()) volume.origin_mm = three(origin);
    if (!spacing.empty()) volume.spacing_mm = three(spacing);
    for (std::filesystem::path& root : limits.roots)
        root = without_links(root);
    Result<void> done;
    if (const Result<int64_t> bytes = parse_memory_option(memory); bytes) {
        limits.memory_bytes = *bytes;
    } else {
        done = bytes.error();
    }
    if (done && job->output.empty() && !job->check) done = usage_error(messages::kOutputMissing);
    if (done && job->check && job->is_volume) done = usage_error(messages::kCheckIsForPictures);
    std::error_code none;
    if (done && !pitch.empty()) {
        const Result<double> length = parse_length_mm(pitch);
        if (!length) {
            done = length.error();
        } else if (!(*length > 0)) {
            done = usage_error(messages::kPitchAboveZero);
        } else {
            volume.pitch_mm = *length;
        }
    }
    if (done && std::filesystem::equivalent(job->input, job->output, none)) {
        done = user_error(fmt::format(messages::kWouldOverwrite, job->output));
    }
    if (!done) return say_error(done.error());
    return std::nullopt;
}

int convert_guarded(int argc, char** argv, MakeVolume* make) {
    prepare_streams();
    clean_up_on_signals();
    TextureJob job;
    if (const std::optional<int> code = parse_texture_job(argc, argv, &job)) return *code;
    // Quiet in its child, but for its notes.
    const Result<void> done = guarded(
        job.limits.memory_bytes, job.input,
        [&] { return make(job.input, job.output, job.options, job.limits); }, job.output);
    return done ? 0 : say_error(done.error());
}

int do_quietly(const std::function<Result<void>()>& make) {
    Result<void> done;
    {
        const OwnStandardError closed_to_libraries;
        done = make();
    }
    return done ? 0 : say_error(done.error());
}

}  // namespace openfab::tools
