// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/programs.h"
#include "runtime/base/say.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <system_error>

#include "runtime/texture/cache.h"

extern char** environ;

namespace openfab::tool {

namespace {

namespace fs = std::filesystem;

struct HashDelete {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

/// A running hash of names and contents.
class Hash {
  public:
    Hash() : state_(XXH3_createState()) { XXH3_64bits_reset(state_.get()); }

    void add(const std::string& text) {
        add_number(text.size());
        XXH3_64bits_update(state_.get(), text.data(), text.size());
    }
    void add_number(uint64_t number) { XXH3_64bits_update(state_.get(), &number, sizeof(number)); }
    bool add_content(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        if (!in) return false;
        add(file.filename().string());
        add(std::string(std::istreambuf_iterator<char>(in), {}));
        return true;
    }
    /// Size and time instead of the content: for files that only a build of OpenFab changes.
    void add_stamp(const fs::path& file) {
        std::error_code status;
        add(file.filename().string());
        add_number(fs::file_size(file, status));
        add_number(
            static_cast<uint64_t>(fs::last_write_time(file, status).time_since_epoch().count()));
    }
    uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

  private:
    std::unique_ptr<XXH3_state_t, HashDelete> state_;
};

/// Files of a folder with one of the extensions, sorted; none where there is no such folder.
std::vector<fs::path> files_of(const fs::path& folder, const std::set<std::string>& extensions) {
    std::vector<fs::path> files;
    std::error_code status;
    for (fs::directory_iterator entry(folder, status), end; !status && entry != end;
         entry.increment(status)) {
        if (extensions.count(entry->path().extension().string()) != 0)
            files.push_back(entry->path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

Result<uint64_t> binary_hash(const std::vector<fs::path>& sources, const fs::path& programs) {
    Hash hash;
    std::set<fs::path> folders;
    for (const fs::path& source : sources) {
        if (!hash.add_content(source)) {
            return user_error(fmt::format("cannot read the fablet source `{}`: {}", source.string(),
                                          std::strerror(errno)));
        }
        folders.insert(source.parent_path());
    }
    // `import` takes modules from beside the source. Which ones is the compiler's business, so all
    // count.
    for (const fs::path& folder : folders) {
        for (const fs::path& module : files_of(folder, {".fl"}))
            hash.add_content(module);
    }
    hash.add_stamp(programs / "openflc");
    for (const fs::path& library :
         files_of(programs.parent_path() / "lib", {".a", ".o", ".so", ".link"}))
        hash.add_stamp(library);
    return hash.value();
}

/// Runs a program to its end with our stderr and stdout on stderr; its exit status, or an error
/// where it cannot start.
Result<int> run_program(const std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
    pid_t child = 0;
    const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) {
        return outside_error(
            fmt::format("cannot start `{}`: {}", arguments[0], std::strerror(failed)));
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR)
            return outside_error(fmt::format("lost `{}`: {}", arguments[0], std::strerror(errno)));
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

ErrorCode code_of_exit(int status) {
    switch (status) {
        case 1:
            return ErrorCode::kUserInput;
        case 2:
            return ErrorCode::kInternal;  // our own call of the compiler is wrong
        case 3:
            return ErrorCode::kOutside;
        case 130:
            return ErrorCode::kInterrupted;
        default:
            return ErrorCode::kInternal;
    }
}

}  // namespace

Result<fs::path> program_folder() {
    std::error_code status;
    const fs::path self = fs::read_symlink("/proc/self/exe", status);
    if (status) return outside_error("cannot find the program's own folder: " + status.message());
    return self.parent_path();
}

Result<fs::path> print_binary(const std::vector<fs::path>& sources, bool quiet) {
    Result<fs::path> programs = program_folder();
    if (!programs) return programs;
    const fs::path compiler = *programs / "openflc";
    if (::access(compiler.c_str(), X_OK) != 0) {
        return outside_error(fmt::format(
            "the compiler `openflc` is not beside this program, in `{}`", programs->string()));
    }
    Result<uint64_t> hash = binary_hash(sources, *programs);
    if (!hash) return hash.error();
    const fs::path folder = texture::cache_folder() / "prints";
    const fs::path binary =
        folder / fmt::format("{}-{:016x}", sources.front().stem().string(), *hash);
    if (::access(binary.c_str(), X_OK) == 0) return binary;

    std::error_code status;
    fs::create_directories(folder, status);
    if (status)
        return outside_error(
            fmt::format("cannot make the folder `{}`: {}", folder.string(), status.message()));
    if (!quiet) say(fmt::format("compiling {} ...\n", sources.front().filename().string()));
    // Under a name of its own, so that two prints at once do not see each other's half-written
    // binary.
    const fs::path temporary = fmt::format("{}.{}", binary.string(), ::getpid());
    std::vector<std::string> arguments{compiler.string(), "build"};
    for (const fs::path& source : sources)
        arguments.push_back(source.string());
    arguments.insert(arguments.end(), {"-o", temporary.string()});
    Result<int> exit_status = run_program(arguments);
    if (!exit_status) return exit_status.error();
    if (*exit_status != 0) {
        fs::remove(temporary, status);
        return Error{code_of_exit(*exit_status), ""};
    }
    fs::rename(temporary, binary, status);
    if (status)
        return outside_error(
            fmt::format("cannot write `{}`: {}", binary.string(), status.message()));
    return binary;
}

}  // namespace openfab::tool
