// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/converter.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <string>

#include "base/clean_exit.h"
#include "base/exit_kind.h"
#include "base/start_program.h"
#include "base/text.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace fs = std::filesystem;

const Converter kStepConverter{"openfab-step", messages::kBuiltWithoutOpenCascade,
                               messages::kBuiltWithoutOpenCascadeHelp, "OpenCASCADE"};
const Converter kVrmlConverter{"openfab-vrml", messages::kBuiltWithoutCoin,
                               messages::kBuiltWithoutCoinHelp, "Coin"};
const Converter kScanConverter{"openfab-texture-dicom", messages::kBuiltWithoutDicom,
                               messages::kBuiltWithoutDicomHelp, "GDCM"};

bool is_step_file(const fs::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".step" || kind == ".stp";
}

bool is_vrml_file(const fs::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".wrl" || kind == ".vrml";
}

bool is_usd_file(const fs::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".usd" || kind == ".usda" || kind == ".usdc" || kind == ".usdz";
}

std::string importable_meshes() {
    return mesh::mesh_formats() + ", .step, .stp, .wrl, .vrml, .usd, .usda, .usdc, .usdz";
}

namespace {

/// Runs a program that reads `file` with `library`.
Result<void> run_reader(const ProgramStart& start, const fs::path& file, const char* library) {
    pid_t process = 0;
    const int failed = start_program(start, &process);
    if (failed != 0)
        return outside_error(
            fmt::format(messages::kCannotStartProgram, start.argv[0], std::strerror(failed)));
    RunningProgram running(process);
    int status = 0;
    if (!running.wait(&status))
        return outside_error(fmt::format(messages::kCannotWaitForProgram, start.argv[0]));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    // It has said what is wrong. One that a damaged file has killed has not.
    if (WIFEXITED(status) && WEXITSTATUS(status) == 1) return user_error("");
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : kExitBySignal + WTERMSIG(status);
    if (kind_of_exit(code) == ErrorCode::kInterrupted)
        return Error{ErrorCode::kInterrupted, "", "", {}};
    if (WIFSIGNALED(status))
        return user_error(
            fmt::format(messages::kConverterEnded, file.string(), library, WTERMSIG(status)));
    return outside_error("");
}

}  // namespace

Result<void> run_converter(const Converter& converter, std::vector<std::string> arguments,
                           const fs::path& file) {
    const Result<fs::path> folder = program_folder();
    if (!folder) return folder.error();
    const fs::path helper = *folder / converter.program;
    if (::access(helper.c_str(), X_OK) != 0) {
        Error error = outside_error(converter.missing);
        error.help = converter.missing_help;
        return error;
    }
    ProgramStart start;
    start.argv = {helper.string()};
    for (std::string& argument : arguments)
        start.argv.push_back(std::move(argument));
    return run_reader(start, file, converter.library);
}

Result<void> run_usd_reader(const fs::path& file, const fs::path& obj, int64_t memory_bytes) {
    ProgramStart start;
    start.search = true;
    start.argv = {"python3",     "-c",         std::string(stock_text("read_usd.py")),
                  file.string(), obj.string(), std::to_string(memory_bytes)};
    return run_reader(start, file, "USD");
}

}  // namespace openfab::tools
