// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture IMAGE -o FILE`: makes a filtered pyramid of an image; `openfab texture` executes
// this program. It is separate because it links OpenImageIO, which takes a third of a second and
// 130 MB to start: prints should not wait for it.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <vector>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/input_file.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"

namespace {

/// Suppresses what libraries such as libpng write to standard error; we report errors from their
/// results.
class Silence {
  public:
    Silence() : kept_(::dup(STDERR_FILENO)) {
#ifndef OPENFAB_SANITIZED  // sanitizers report there, too
        const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
        if (nowhere >= 0) ::close(nowhere);
#endif
    }
    ~Silence() {
        if (kept_ < 0) return;
        ::dup2(kept_, STDERR_FILENO);
        ::close(kept_);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

  private:
    int kept_;
};

int texture_main(int argc, char** argv) {
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    std::string image;
    std::string output;
    openfab::texture::VolumeOptions volume;
    openfab::texture::ImageOptions& options = volume.image;
    openfab::texture::ReadLimits limits;
    std::vector<double> origin, spacing;
    std::string memory;
    bool is_volume = false;
    CLI::App app(
        "Makes the filtered pyramid of an image; print binaries call it for images that are not in "
        "their cache.",
        "openfab texture");
    app.add_option("IMAGE", image, std::string("a picture: ") + openfab::tools::kStillFormats)
        ->required();
    app.add_option("-o,--output", output, "the .oftx file")->required();
    app.add_option("--space", options.space, "auto, srgb, linear or data")
        ->check(CLI::IsMember({"auto", "srgb", "linear", "data"}));
    app.add_flag("--luminance", options.luminance, "convert three channels to one");
    app.add_flag(
        "--volume", is_volume,
        "the image is a volume: slices in one file, a folder or a pattern; NRRD, NPY or .cube");
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
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        openfab::show(app.help());
        return 0;
    } catch (const CLI::ParseError& error) {
        return openfab::say_error(openfab::command_line_error(app, error, "openfab texture"));
    }
    const auto three = [](const std::vector<double>& v) {
        return std::array<double, 3>{v[0], v[1], v[2]};
    };
    if (!origin.empty()) volume.origin_mm = three(origin);
    if (!spacing.empty()) volume.spacing_mm = three(spacing);
    for (std::filesystem::path& root : limits.roots)
        root = openfab::without_links(root);
    openfab::Result<void> done;
    if (const openfab::Result<int64_t> bytes = openfab::parse_memory_option(memory); bytes) {
        limits.memory_bytes = *bytes;
    } else {
        done = bytes.error();
    }
    std::error_code none;
    if (done && std::filesystem::equivalent(image, output, none)) {
        done = openfab::user_error(
            fmt::format("`-o {}` would overwrite the image; name another output", output));
    }
    if (done) {
        const Silence silence;
        done = is_volume ? openfab::tools::make_volume_file(image, output, volume, limits)
                         : openfab::tools::make_pyramid_file(image, output, options, limits);
    }
    return done ? 0 : openfab::say_error(done.error());
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(texture_main, argc, argv);
}
