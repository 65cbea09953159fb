// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view FILE`: the viewer (tools/viewer) with the options of the command line.

#include <memory>

#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/units.h"
#include "client/child.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

Result<void> run_view(ViewArguments arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    Result<std::filesystem::path> programs = program_folder();
    if (!programs) return programs.error();
    arguments.view.memory_bytes = *memory;
    if (!arguments.memory.empty()) client::set_memory_of_programs(*memory);
    arguments.view.programs = *programs;
    if (arguments.view.file.empty() == arguments.new_folder.empty())
        return usage_error(messages::kGiveAFile);
    if (!arguments.new_folder.empty()) {
        const Result<std::string> made = make_folder(arguments.new_folder, arguments.from);
        if (!made) return made.error();
        arguments.view.words = *made;
        const std::filesystem::path folder =
            std::filesystem::absolute(arguments.new_folder).lexically_normal();
        const std::string name = folder.filename().empty()
                                     ? folder.parent_path().filename().string()
                                     : folder.filename().string();
        arguments.view.file = (folder / (name + ".fab.json")).string();
        arguments.view.watch = true;
        arguments.view.templates = template_list();
    }
    // A mesh is shown as the world that an import makes of it.
    std::unique_ptr<TemporaryFolder> made;
    if (mesh::is_mesh_file(arguments.view.file)) {
        Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create({});
        if (!folder) return folder.error();
        made = std::move(*folder);
        ImportArguments import;
        import.file = arguments.view.file;
        import.folder = (made->path() / "world").string();
        import.memory = arguments.memory;
        const Result<std::filesystem::path> world = import_mesh(std::move(import));
        if (!world) return world.error();
        note(messages::kWorldOfViewer);
        arguments.view.file = world->string();
    }
    return viewer::view(arguments.view);
}

}  // namespace openfab::tools
