// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab texture IMAGE -o FILE`: a filtered pyramid of an image. Print binaries, which link no
// image library, call it for images that their cache does not have.

#include <memory>

#include "tools/openfab/commands.h"
#include "tools/texture/convert.h"

namespace openfab::tool {

void add_texture(CLI::App& app, Action* action) {
    struct Options {
        std::string image;
        std::string output;
        texture::ImageOptions how;
    };
    CLI::App* command = app.add_subcommand(
        "texture", "make the filtered pyramid of an image (print binaries call it)");
    auto options = std::make_shared<Options>();
    command->add_option("IMAGE", options->image, "an image of any format that OpenImageIO reads")
        ->required();
    command->add_option("-o,--output", options->output, "the .oftx file")->required();
    command->add_option("--space", options->how.space, "auto, srgb, linear or data")
        ->check(CLI::IsMember({"auto", "srgb", "linear", "data"}));
    command->add_flag("--luminance", options->how.luminance, "one channel of three");
    command->callback([options, action] {
        *action = [options] {
            return tools::make_pyramid_file(options->image, options->output, options->how);
        };
    });
}

}  // namespace openfab::tool
