// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"

// helper texture IMAGE -o FILE|--check --space SPACE [--luminance] [--volume [--origin=X,Y,Z]
// [--spacing=X,Y,Z]] [--memory=BYTES] [--below=FOLDER]
int main(int argc, char** argv) {
    std::vector<std::string> args(argv + 1, argv + argc);
    const bool check = args.size() > 2 && args[2] == "--check";
    if (check) args.insert(args.begin() + 3, "");
    if (args.size() < 6 || args[0] != "texture" || (args[2] != "-o" && !check) ||
        args[4] != "--space")
        return 2;
    openfab::texture::VolumeOptions volume;
    volume.image.space = args[5];
    bool is_volume = false;
    const auto three = [](const std::string& text) {
        std::array<double, 3> v{};
        std::sscanf(text.c_str(), "%lf,%lf,%lf", &v[0], &v[1], &v[2]);
        return v;
    };
    openfab::texture::ReadLimits limits;
    for (size_t i = 6; i < args.size(); ++i) {
        if (args[i].starts_with("--memory=")) limits.memory_bytes = std::atoll(args[i].c_str() + 9);
        if (args[i].starts_with("--below=")) limits.roots.emplace_back(args[i].substr(8));
        if (args[i] == "--luminance") volume.image.luminance = true;
        if (args[i] == "--volume") is_volume = true;
        if (args[i].starts_with("--origin=")) volume.origin_mm = three(args[i].substr(9));
        if (args[i].starts_with("--spacing=")) volume.spacing_mm = three(args[i].substr(10));
    }
    const openfab::Result<void> done =
        check       ? openfab::tools::check_picture_file(args[1], volume.image, limits)
        : is_volume ? openfab::tools::make_volume_file(args[1], args[3], volume, limits)
                    : openfab::tools::make_pyramid_file(args[1], args[3], volume.image, limits);
    if (done) return 0;
    fmt::print(stderr, "error: {}\n", done.error().text());
    return openfab::exit_code(done.error().code);
}
