// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture IMAGE -o FILE`: a filtered pyramid of an image; `openfab texture` becomes this
// program. It is one of its own because it links OpenImageIO, which takes a third of a second and
// 130 MB to start (measured): prints should not wait for it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "runtime/base/caret.h"
#include "tools/texture/convert.h"

int main(int argc, char** argv) {
    using openfab::ErrorCode;
    std::string image;
    std::string output;
    openfab::texture::ImageOptions options;
    CLI::App app(
        "Makes the filtered pyramid of an image; print binaries call it for images that are not in "
        "their cache.",
        "openfab texture");
    app.add_option("IMAGE", image, "an image of any format that OpenImageIO reads")->required();
    app.add_option("-o,--output", output, "the .oftx file")->required();
    app.add_option("--space", options.space, "auto, srgb, linear or data")
        ->check(CLI::IsMember({"auto", "srgb", "linear", "data"}));
    app.add_flag("--luminance", options.luminance, "one channel of three");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        fmt::print("{}", app.help());
        return 0;
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "error: {}; `openfab texture --help` lists the options\n", error.what());
        return openfab::exit_code(ErrorCode::kUsage);
    }
    openfab::Result<void> done = openfab::tools::make_pyramid_file(image, output, options);
    if (done) return 0;
    fmt::print(stderr, "{}", openfab::render_error(done.error()));
    return openfab::exit_code(done.error().code);
}
