// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "tools/texture/convert.h"

// helper texture IMAGE -o FILE --space SPACE [--luminance]
int main(int argc, char** argv) {
    const std::vector<std::string> args(argv + 1, argv + argc);
    if (args.size() < 6 || args[0] != "texture" || args[2] != "-o" || args[4] != "--space")
        return 2;
    const bool luminance = args.size() == 7 && args[6] == "--luminance";
    const openfab::Result<void> done =
        openfab::tools::make_pyramid_file(args[1], args[3], {args[5], luminance});
    if (done) return 0;
    fmt::print(stderr, "error: {}\n", done.error().message);
    return openfab::exit_code(done.error().code);
}
