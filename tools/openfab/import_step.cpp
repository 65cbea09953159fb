// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_step.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <string>

#include "base/clean_exit.h"
#include "base/start_program.h"
#include "base/text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"

namespace openfab::tools {

namespace fs = std::filesystem;

bool is_step_file(const fs::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".step" || kind == ".stp";
}

Result<void> solids_of_step(const fs::path& file, const fs::path& output, double tolerance_mm) {
    const Result<fs::path> folder = program_folder();
    if (!folder) return folder.error();
    const fs::path helper = *folder / "openfab-step";
    if (::access(helper.c_str(), X_OK) != 0) {
        Error error = outside_error(messages::kBuiltWithoutOpenCascade);
        error.help = messages::kBuiltWithoutOpenCascadeHelp;
        return error;
    }
    const std::string to = "--output=" + output.string();
    const std::string tolerance = fmt::format("--tolerance={:.9g}mm", tolerance_mm);
    ProgramStart start;
    start.argv = {helper.string(), to, tolerance, "--", file.string()};
    pid_t process = 0;
    const int failed = start_program(start, &process);
    if (failed != 0)
        return outside_error(
            fmt::format(messages::kCannotStartProgram, helper.string(), std::strerror(failed)));
    RunningProgram running(process);
    int status = 0;
    if (!running.wait(&status))
        return outside_error(fmt::format(messages::kCannotWaitForProgram, helper.string()));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    // It has said what is wrong. One that a damaged file has killed has not.
    if (WIFEXITED(status) && WEXITSTATUS(status) == 1) return user_error("");
    if (WIFSIGNALED(status))
        return user_error(fmt::format(messages::kStepReaderEnded, file.string(), WTERMSIG(status)));
    return outside_error("");
}

}  // namespace openfab::tools
