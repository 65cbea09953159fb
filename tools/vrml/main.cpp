// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-vrml FILE -o FILE.obj`: makes triangles of the shapes of a VRML file; `openfab import` executes this
// program. It is separate because it links Coin, which not every machine has, and because what it reads is of
// strangers.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/texture/guarded.h"
#include "tools/vrml/scene.h"
#include "tools/vrml/wavefront.h"

namespace {

/// A jail lets a reader take twice its budget.
constexpr int64_t kOfBudget = 2;

int vrml_main(int argc, char** argv) {
    using openfab::Result;
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    std::string memory, input, output;
    CLI::App app("Makes triangles of the shapes of a VRML file; `openfab import` calls it.",
                 "openfab-vrml");
    app.add_option("FILE", input, "a .wrl or .vrml file")->required();
    app.add_option("-o,--output", output, "the .obj file")->required();
    app.add_option("--memory", memory, "how much it may take, like 2GB (default: 8GB)");
    return openfab::run_command_line(&app, argc, argv, "openfab-vrml", [&]() -> Result<void> {
        const Result<int64_t> bytes = openfab::parse_memory_option(memory.empty() ? "8GB" : memory);
        if (!bytes) return bytes.error();
        return openfab::tools::guarded(
            *bytes / kOfBudget, input,
            [&]() -> Result<void> {
                const Result<openfab::tools::Scene> scene = openfab::tools::read_scene(input);
                if (!scene) return scene.error();
                for (const std::string& text : scene->notes)
                    openfab::note(text);
                return openfab::tools::write_wavefront(
                    *scene, std::filesystem::path(input).parent_path(), output);
            },
            output);
    });
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(vrml_main, argc, argv);
}
