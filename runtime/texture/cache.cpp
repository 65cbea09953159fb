// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/texture/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/texture/helper.h"
#include "runtime/texture/pyramid_file.h"

extern char** environ;

namespace openfab::texture {
namespace {

namespace fs = std::filesystem;

std::string reason(int code) {
    return std::generic_category().message(code);
}

bool is_program(const fs::path& file) {
    std::error_code ignored;
    return fs::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0;
}

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
}

struct HelperResult {
    int status = -1;       ///< as from waitpid
    std::string messages;  ///< what it wrote to stderr, at most 16 KB
};

/// Runs a program without a shell, its stdout on our stderr (our stdout is data), its stderr read.
Result<HelperResult> run_helper(const std::vector<std::string>& arguments) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return outside_error("cannot make a pipe: " + reason(errno));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, 2, 1);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
    std::vector<char*> argv;
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_t child = -1;
    const int trouble = ::posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    HelperResult result;
    char buffer[4096];
    while (trouble == 0) {
        const ssize_t got = ::read(ends[0], buffer, sizeof buffer);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        constexpr size_t kMost = 16384;
        if (result.messages.size() < kMost)
            result.messages.append(buffer, static_cast<size_t>(got));
    }
    ::close(ends[0]);
    if (trouble != 0)
        return outside_error(fmt::format("cannot start {}: {}", arguments[0], reason(trouble)));
    while (::waitpid(child, &result.status, 0) < 0) {
        if (errno != EINTR)
            return outside_error("cannot wait for the texture helper: " + reason(errno));
    }
    return result;
}

/// The helper's own words without what it puts around them.
std::string trimmed(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' '))
        text.pop_back();
    constexpr std::string_view kPrefix = "error: ";
    if (text.starts_with(kPrefix)) text.erase(0, kPrefix.size());
    return text;
}

}  // namespace

Result<void> make_with_helper(const fs::path& image, const ImageOptions& options,
                              const fs::path& out, const std::vector<std::string>& more) {
    const fs::path helper = find_helper();
    if (helper.empty()) {
        return outside_error(
            fmt::format("{} must be converted, and the program that does it, `openfab`, was not "
                        "found beside this one or on the "
                        "PATH; put it there, or set OPENFAB_HELPER to it",
                        image.string()));
    }
    std::error_code trouble;
    fs::create_directories(out.parent_path(), trouble);
    if (trouble) {
        return outside_error(
            fmt::format("cannot make the cache folder {}: {}; OPENFAB_CACHE chooses another",
                        out.parent_path().string(), trouble.message()));
    }
    // A name that starts with a dash must not look like an option.
    const std::string image_argument = image.is_relative() ? "./" + image.string() : image.string();
    std::vector<std::string> arguments = {helper.string(), "texture", image_argument, "-o",
                                          out.string(),    "--space", options.space};
    if (options.luminance) arguments.emplace_back("--luminance");
    arguments.insert(arguments.end(), more.begin(), more.end());
    Result<HelperResult> result = run_helper(arguments);
    if (!result) return result.error();
    const std::string messages = trimmed(result->messages);
    if (WIFEXITED(result->status) && WEXITSTATUS(result->status) == 0) return Ok{};
    if (WIFEXITED(result->status) && !messages.empty()) {
        return WEXITSTATUS(result->status) == exit_code(ErrorCode::kUserInput)
                   ? user_error(messages)
                   : outside_error(messages);
    }
    const int signal = WIFSIGNALED(result->status) ? WTERMSIG(result->status) : 0;
    if (signal == SIGINT) return Error{ErrorCode::kInterrupted, "interrupted"};
    return outside_error(fmt::format(
        "cannot convert {}: {} {}", image.string(), helper.string(),
        signal != 0 ? fmt::format("was ended by signal {}", signal)
                    : fmt::format("failed with exit code {}", WEXITSTATUS(result->status))));
}

fs::path cache_folder() {
    if (const std::string own = environment("OPENFAB_CACHE"); !own.empty()) return own;
    if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty())
        return fs::path(xdg) / "openfab";
    if (const std::string home = environment("HOME"); !home.empty())
        return fs::path(home) / ".cache" / "openfab";
    std::error_code ignored;
    return fs::temp_directory_path(ignored) / fmt::format("openfab-{}", ::getuid());
}

Result<uint64_t> content_key(const fs::path& image, const ImageOptions& options) {
    const auto unreadable = [&](int code) {
        const std::string message = fmt::format("cannot read {}: {}", image.string(), reason(code));
        return code == ENOENT || code == EISDIR ? user_error(message) : outside_error(message);
    };
    const int fd = ::open(image.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return unreadable(errno);
    struct stat status {};
    if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(fd);
        return unreadable(EISDIR);
    }
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    std::vector<char> buffer(1 << 20);
    for (;;) {
        const ssize_t got = ::read(fd, buffer.data(), buffer.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            const int code = errno;
            ::close(fd);
            return unreadable(code);
        }
        if (got == 0) break;
        XXH3_64bits_update(&state, buffer.data(), static_cast<size_t>(got));
    }
    ::close(fd);
    const std::string suffix =
        fmt::format("|{}|{}|{}", options.space, options.luminance ? 1 : 0, kFileVersion);
    XXH3_64bits_update(&state, suffix.data(), suffix.size());
    return static_cast<uint64_t>(XXH3_64bits_digest(&state));
}

fs::path cache_file(uint64_t key) {
    return cache_folder() / fmt::format("{:016x}.oftx", key);
}

fs::path find_helper() {
    std::error_code ignored;
    const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
    if (!self.empty() && is_program(self.parent_path() / "openfab"))
        return self.parent_path() / "openfab";
    if (const std::string chosen = environment("OPENFAB_HELPER");
        !chosen.empty() && is_program(chosen))
        return chosen;
    const std::string folders = environment("PATH");
    size_t at = 0;
    while (at <= folders.size()) {
        const size_t end = std::min(folders.find(':', at), folders.size());
        const std::string folder = folders.substr(at, end - at);
        if (!folder.empty() && is_program(fs::path(folder) / "openfab"))
            return fs::path(folder) / "openfab";
        at = end + 1;
    }
    return {};
}

Result<std::shared_ptr<const Pyramid>> get_pyramid(const fs::path& image,
                                                   const ImageOptions& options, int32_t wrap,
                                                   int32_t filter) {
    const Result<uint64_t> key = content_key(image, options);
    if (!key) return key.error();
    const fs::path file = cache_file(*key);
    if (Result<std::shared_ptr<const Pyramid>> cached = Pyramid::open(file, wrap, filter))
        return cached;
    // Absent, or damaged, in which case the new one takes its place.
    if (Result<void> made = make_with_helper(image, options, file); !made) return made.error();
    return Pyramid::open(file, wrap, filter);
}

}  // namespace openfab::texture
