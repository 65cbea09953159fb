// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/clean_exit.h"
#include "base/exit_kind.h"
#include "base/hash.h"
#include "base/input_file.h"
#include "base/messages.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/system_reason.h"
#include "texture/helper.h"
#include "texture/messages.h"
#include "texture/pyramid_file.h"
#include "texture/reading_progress.h"

namespace openfab::texture {
namespace {

namespace fs = std::filesystem;

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

/// Says the lines of progress among whole lines of what a helper wrote, and takes them out.
void pass_progress_on(std::string* messages) {
    const std::string_view mark = kReading;
    for (size_t at = 0; at < messages->size();) {
        const size_t end = messages->find('\n', at);
        if (end == std::string::npos) return;
        if (messages->compare(at, mark.size(), mark) == 0) {
            say(messages->substr(at, end + 1 - at));
            messages->erase(at, end + 1 - at);
        } else {
            at = end + 1;
        }
    }
}

/// Runs a program without a shell, its stdout redirected to our stderr (our stdout is data), its
/// stderr captured.
Result<HelperResult> run_helper(const std::vector<std::string>& arguments) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        return outside_error(fmt::format(messages::kNoPipe, system_reason(errno)));
    const int null = open_null();
    ProgramStart start;
    start.argv = arguments;
    if (null >= 0) start.in = null;
    start.out = STDERR_FILENO;
    start.err = ends[1];
    const bool passes_on = tells_progress();
    if (passes_on) start.environment = {std::string(kTellProgress) + "=1"};
    pid_t child = -1;
    const int trouble = start_program(start, &child);
    if (null >= 0) ::close(null);
    ::close(ends[1]);
    std::optional<RunningProgram> running;
    if (trouble == 0) running.emplace(child);
    HelperResult result;
    char buffer[4096];
    while (trouble == 0) {
        const ssize_t got = ::read(ends[0], buffer, sizeof buffer);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        constexpr size_t kMost = 16384;
        if (result.messages.size() < kMost)
            result.messages.append(buffer, static_cast<size_t>(got));
        if (passes_on) pass_progress_on(&result.messages);
    }
    ::close(ends[0]);
    if (trouble != 0)
        return outside_error(
            fmt::format(messages::kCannotStart, arguments[0], system_reason(trouble)));
    if (!running->wait(&result.status))
        return outside_error(fmt::format(messages::kCannotWaitForHelper, system_reason(errno)));
    return result;
}

/// Returns the helper's message without its decoration.
std::string trimmed(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' '))
        text.pop_back();
    constexpr std::string_view kPrefix = "error: ";
    if (text.starts_with(kPrefix)) text.erase(0, kPrefix.size());
    return text;
}

/// Takes out the notes that a helper's messages begin with.
std::vector<std::string> take_notes(std::string* messages) {
    constexpr std::string_view kPrefix = "note: ";
    std::vector<std::string> notes;
    while (messages->starts_with(kPrefix)) {
        const size_t end = std::min(messages->find('\n'), messages->size());
        notes.push_back(messages->substr(kPrefix.size(), end - kPrefix.size()));
        messages->erase(0, end + 1);
    }
    return notes;
}

void say_notes(const std::vector<std::string>& notes) {
    for (const std::string& one : notes)
        note(one);
}

/// Keeps them with a pyramid, so that they are told whenever it is used.
void keep_notes(const std::vector<std::string>& notes, const fs::path& pyramid) {
    const fs::path file = notes_file(pyramid);
    std::error_code ignored;
    if (notes.empty()) {
        fs::remove(file, ignored);
        return;
    }
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    for (const std::string& one : notes)
        out << one << '\n';
}

/// Parses the helper's error, `message; help`.
Error helper_error(int exit_status, std::string message) {
    std::string help;
    if (const size_t end = message.find("; "); end != std::string::npos) {
        help = message.substr(end + 2);
        message.resize(end);
    }
    const ErrorCode kind = kind_of_exit(exit_status);
    const bool known = kind == ErrorCode::kUserInput || kind == ErrorCode::kInterrupted;
    return {known ? kind : ErrorCode::kOutside, std::move(message), std::move(help), {}};
}

/// Set before threads read it.
fs::path& own_converter() {
    static fs::path program;
    return program;
}

/// Returns the program that converts, with the words that make it do so; nothing if there is none.
std::vector<std::string> converter() {
    if (!own_converter().empty()) return {own_converter().string()};
    const fs::path helper = find_helper();
    if (helper.empty()) return {};
    return {helper.string(), "texture"};
}

/// Only checks the picture where `out` is empty. Returns what the helper told of a file that it has read.
Result<std::vector<std::string>> make_with_helper(const fs::path& image,
                                                  const ImageOptions& options, const fs::path& out,
                                                  const ReadLimits& limits,
                                                  const std::vector<std::string>& more) {
    std::vector<std::string> arguments = converter();
    if (arguments.empty()) {
        return outside_error(fmt::format(messages::kNoConverter, image.string()));
    }
    const std::string helper = arguments.front();
    arguments.push_back(as_argument(image));
    if (out.empty()) {
        arguments.emplace_back("--check");
    } else {
        arguments.insert(arguments.end(), {"-o", out.string()});
    }
    arguments.insert(arguments.end(), {"--space", options.space});
    if (options.luminance) arguments.emplace_back("--luminance");
    if (options.opaque) arguments.emplace_back("--opaque");
    arguments.push_back(fmt::format("--memory={}B", limits.memory_bytes));
    for (const fs::path& root : limits.roots)
        arguments.push_back("--below=" + root.string());
    arguments.insert(arguments.end(), more.begin(), more.end());
    Result<HelperResult> result = run_helper(arguments);
    if (!result) return result.error();
    std::vector<std::string> notes = take_notes(&result->messages);
    const std::string messages = trimmed(std::move(result->messages));
    if (WIFEXITED(result->status) && WEXITSTATUS(result->status) == 0) return notes;
    say_notes(notes);
    if (WIFEXITED(result->status) && !messages.empty()) {
        return helper_error(WEXITSTATUS(result->status), messages);
    }
    const int signal = WIFSIGNALED(result->status) ? WTERMSIG(result->status) : 0;
    if (kind_of_exit(signal + kExitBySignal) == ErrorCode::kInterrupted)
        return Error{ErrorCode::kInterrupted, openfab::messages::kInterrupted};
    return outside_error(fmt::format(
        messages::kCannotConvert, image.string(), helper,
        signal != 0 ? fmt::format(messages::kEndedBySignal, signal)
                    : fmt::format(messages::kFailedWithCode, WEXITSTATUS(result->status))));
}

std::atomic<bool> no_textures_kept{false};

/// Returns the folder of the cache from the environment; empty if not set.
fs::path wanted_cache() {
    if (const std::string own = environment("OPENFAB_CACHE"); !own.empty()) return own;
    if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty())
        return fs::path(xdg) / "openfab";
    if (const std::string home = environment("HOME"); !home.empty())
        return fs::path(home) / ".cache" / "openfab";
    return {};
}

/// Resolves the link to the running program; false if the program has been deleted.
bool find_self(fs::path* out) {
    struct stat running {};
    struct stat named {};
    std::error_code unknown;
    *out = fs::read_symlink("/proc/self/exe", unknown);
    return !unknown && ::stat("/proc/self/exe", &running) == 0 &&
           ::stat(out->c_str(), &named) == 0 && running.st_dev == named.st_dev &&
           running.st_ino == named.st_ino;
}

}  // namespace

Result<std::shared_ptr<const Pyramid>> find_or_make(uint64_t key, const fs::path& image,
                                                    const ImageOptions& options, WrapModes wrap,
                                                    int32_t filter, const ReadLimits& limits,
                                                    const std::vector<std::string>& more) {
    const bool keeps_any = keeps_textures();
    const Result<fs::path> cache = cache_folder();
    std::unique_ptr<TemporaryFolder> own;
    fs::path file;
    if (cache && keeps_any) {
        file = *cache / cache_name(key);
        if (Result<std::shared_ptr<const Pyramid>> cached = Pyramid::open(file, wrap, filter))
            return cached;
    }
    if (const Result<void> keeps = check_keeps(cache); keeps && keeps_any) {
        clear_left_over(*cache);
    } else {
        static std::atomic<bool> noted{false};
        if (keeps_any && !noted.exchange(true))
            note(fmt::format(messages::kNotCached, keeps.error().text()));
        // The mapping outlives the file.
        Result<std::unique_ptr<TemporaryFolder>> made = TemporaryFolder::create();
        if (!made) return made.error();
        own = std::move(*made);
        file = own->path() / cache_name(key);
    }
    const Result<std::vector<std::string>> notes =
        make_with_helper(image, options, file, limits, more);
    if (!notes) return notes.error();
    keep_notes(*notes, file);
    return Pyramid::open(file, wrap, filter);
}

void keep_no_textures() {
    no_textures_kept.store(true);
}

bool keeps_textures() {
    return !no_textures_kept.load() && environment("OPENFAB_NO_CACHE").empty();
}

Result<fs::path> cache_folder(const std::string& part) {
    fs::path wanted = wanted_cache();
    if (wanted.empty()) return user_error(messages::kNoCacheFolder);
    if (!part.empty()) wanted /= part;
    Result<fs::path> folder = own_folder(wanted);
    if (folder) return folder;
    return with_context(folder.error(), fmt::format(messages::kFolderNotUsed, wanted.string()));
}

Result<void> check_keeps(const Result<fs::path>& folder) {
    if (!folder) return folder.error();
    const Result<void> writable = check_writable(*folder);
    if (writable) return {};
    return with_context(writable.error(), fmt::format(messages::kNothingIsKept, folder->string()));
}

Result<uint64_t> content_key(const fs::path& image, const ImageOptions& options) {
    const Result<InputFile> file = InputFile::open(image);
    const auto unreadable = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBecause, image.string()));
    };
    if (!file) return unreadable(file.error());
    Hasher hasher;
    std::vector<char> buffer(1 << 20);
    for (int64_t at = 0;;) {
        const Result<size_t> got = file->read(at, buffer.data(), buffer.size());
        if (!got) return unreadable(got.error());
        if (*got == 0) break;
        hasher.add_bytes(buffer.data(), *got);
        at += static_cast<int64_t>(*got);
    }
    // Counts changes of what pictures are decoded to; 1: by the profiles that they carry; 2: with alpha on
    // white; 3: by all that their files say of colours; 4: OpenEXR by its display window; 5: inks by their
    // profile, and Adobe RGB by EXIF.
    constexpr int kDecoding = 5;
    const int channels = options.luminance ? 1 : options.opaque ? 2 : 0;
    const std::string suffix =
        fmt::format("|{}|{}|{}|{}", options.space, channels, kFileVersion, kDecoding);
    hasher.add_bytes(suffix.data(), suffix.size());
    return hasher.value();
}

std::string cache_name(uint64_t key) {
    return fmt::format("{:016x}.oftx", key);
}

void set_converter(fs::path program) {
    own_converter() = std::move(program);
}

fs::path find_helper() {
    fs::path self;
    if (find_self(&self) && is_program(self.parent_path() / "openfab"))
        return self.parent_path() / "openfab";
    if (const std::string chosen = environment("OPENFAB_HELPER");
        !chosen.empty() && is_program(chosen))
        return chosen;
    const std::string folders = environment("PATH");
    size_t at = 0;
    while (at <= folders.size()) {
        const size_t end = std::min(folders.find(':', at), folders.size());
        const fs::path folder = folders.substr(at, end - at);
        // A relative one may be the folder of an untrusted world.
        if (folder.is_absolute() && is_program(folder / "openfab")) return folder / "openfab";
        at = end + 1;
    }
    return {};
}

Result<void> check_picture(const fs::path& image, const ImageOptions& options,
                           const ReadLimits& limits) {
    const Result<std::vector<std::string>> notes = make_with_helper(image, options, {}, limits, {});
    if (!notes) return notes.error();
    say_notes(*notes);
    return {};
}

Result<std::shared_ptr<const Pyramid>> get_pyramid(const fs::path& image,
                                                   const ImageOptions& options, WrapModes wrap,
                                                   int32_t filter, const ReadLimits& limits) {
    const Result<uint64_t> key = content_key(image, options);
    if (!key) return key.error();
    return find_or_make(*key, image, options, wrap, filter, limits);
}

}  // namespace openfab::texture
