// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/programs.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>
#include <system_error>

#include "abi/kernel_call.h"
#include "base/clean_exit.h"
#include "base/exit_kind.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/system_reason.h"
#include "texture/cache.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// The compiler refuses larger ones.
constexpr int64_t kLargestSource = 16 << 20;

/// The trailer of a program in the cache, which loaders ignore: this magic, and the hash of
/// everything before it.
constexpr std::string_view kSeal = "OFPRINT1";
constexpr size_t kSealBytes = 16;

/// A running hash of names and contents.
class SourcesHash : public Hasher {
  public:
    Result<void> add_content(const fs::path& file, const std::vector<fs::path>& roots = {}) {
        const Result<InputFile> opened = InputFile::open(file, roots);
        if (!opened) return opened.error();
        const Result<std::string> content = opened->read_all(kLargestSource);
        if (!content) return content.error();
        add_text(file.filename().string());
        add_text(*content);
        return {};
    }
    /// Hashes size and time instead of the content, for files that only a build of OpenFab changes.
    void add_stamp(const fs::path& file) {
        std::error_code status;
        add_text(file.filename().string());
        add(uint64_t{fs::file_size(file, status)});
        add(static_cast<uint64_t>(fs::last_write_time(file, status).time_since_epoch().count()));
    }
};

/// Lists files of a folder with one of the extensions, sorted; none where the folder does not
/// exist.
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

/// Returns the folder of a file.
fs::path folder_of(const fs::path& file) {
    const fs::path folder = file.parent_path();
    return folder.empty() ? "." : folder;
}

/// Lists what files of these folders may name. Only the compiler knows what they do name, so all of
/// them count.
std::vector<fs::path> files_beside(const std::set<fs::path>& folders, const char* extension) {
    std::vector<fs::path> files;
    for (const fs::path& folder : folders) {
        const std::vector<fs::path> here = files_of(folder, {extension});
        files.insert(files.end(), here.begin(), here.end());
    }
    return files;
}

/// Lists modules, which `import` reads.
std::vector<fs::path> modules_of(const PrintProgram& program) {
    std::set<fs::path> folders;
    for (const fs::path& source : program.sources)
        folders.insert(folder_of(source));
    if (program.dither) folders.insert(folder_of(program.dither->source));
    return files_beside(folders, ".fl");
}

/// Lists what a folder of schedules holds, and what `include` reads.
std::vector<fs::path> schedules_of(const PrintProgram& program) {
    std::set<fs::path> folders;
    for (const fs::path path : program.schedules.paths) {
        std::error_code status;
        folders.insert(fs::is_directory(path, status) ? path : folder_of(path));
    }
    return files_beside(folders, ".sched");
}

Result<uint64_t> program_hash(const PrintProgram& wanted, const fs::path& programs) {
    SourcesHash hash;
    hash.add_text(abi::isa_name(wanted.isa));
    for (const fs::path& source : wanted.sources) {
        if (Result<void> added = hash.add_content(source); !added) {
            return with_context(added.error(),
                                fmt::format(messages::kCannotReadFabletSource, source.string()));
        }
    }
    if (wanted.dither) {
        hash.add_text("dither rule " + wanted.dither->rule);
        if (Result<void> added = hash.add_content(wanted.dither->source); !added) {
            return with_context(added.error(), fmt::format(messages::kCannotReadDitherRule,
                                                           wanted.dither->source.string()));
        }
    }
    for (const fs::path path : wanted.schedules.paths) {
        std::error_code status;
        hash.add_text(path.filename().string());
        if (fs::is_directory(path, status)) continue;
        if (Result<void> added = hash.add_content(path); !added) {
            return with_context(added.error(),
                                fmt::format(messages::kCannotReadSchedule, path.string()));
        }
    }
    for (const std::string& param : wanted.schedules.params)
        hash.add_text(param);
    for (const std::vector<fs::path>& beside : {modules_of(wanted), schedules_of(wanted)}) {
        for (const fs::path& file : beside) {
            if (!hash.add_content(file, {reading_root(folder_of(file))}))
                hash.add_text("unreadable " + file.filename().string());
        }
    }
    hash.add_stamp(programs / "openflc");
    for (const fs::path& library :
         files_of(programs.parent_path() / "lib", {".a", ".o", ".so", ".link"}))
        hash.add_stamp(library);
    return hash.value();
}

ErrorCode code_of_exit(int status, const PrintProgram& wanted) {
    const ErrorCode kind = kind_of_exit(status);
    // These are the only words of the user's: else our own call of the compiler is wrong.
    const bool has_words = !wanted.schedules.paths.empty() || !wanted.schedules.params.empty();
    return kind == ErrorCode::kUsage && !has_words ? ErrorCode::kInternal : kind;
}

/// Hashes the first `bytes` of a file, piece by piece: a program's are not worth memory for all.
Result<uint64_t> content_hash(const InputFile& file, int64_t bytes) {
    Hasher hash;
    std::array<char, 64 << 10> piece;
    for (int64_t at = 0; at < bytes;) {
        const auto wanted = static_cast<size_t>(std::min<int64_t>(bytes - at, piece.size()));
        const Result<size_t> got = file.read(at, piece.data(), wanted);
        if (!got) return got.error();
        if (*got == 0) return outside_error(messages::kBecameShorter);
        hash.add_bytes(piece.data(), *got);
        at += static_cast<int64_t>(*got);
    }
    return hash.value();
}

/// Appends the seal.
Result<void> seal(const fs::path& program) {
    const auto trouble = [&](const std::string& reason) {
        return outside_error(fmt::format(messages::kCannotWrite, program.string(), reason));
    };
    const Result<InputFile> made = InputFile::open(program);
    if (!made) return trouble(made.error().text());
    const Result<uint64_t> hash = content_hash(*made, made->bytes());
    if (!hash) return trouble(hash.error().text());
    std::ofstream out(program, std::ios::binary | std::ios::app);
    out << kSeal << std::string_view(reinterpret_cast<const char*>(&*hash), sizeof *hash);
    out.close();
    return out ? Result<void>() : trouble(system_reason(errno));
}

/// Opens a program with a valid seal; fails otherwise, with an error that is not shown.
Result<PrintBinary> open_print_binary(const fs::path& path) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    const int64_t body = file->bytes() - static_cast<int64_t>(kSealBytes);
    if (body < 0) return user_error(messages::kTooShort);
    std::array<char, kSealBytes> end{};
    const Result<size_t> sealed = file->read(body, end.data(), end.size());
    if (!sealed) return sealed.error();
    uint64_t hash = 0;
    std::memcpy(&hash, end.data() + kSeal.size(), sizeof hash);
    const Result<uint64_t> content = content_hash(*file, body);
    if (!content) return content.error();
    if (!std::string_view(end.data(), end.size()).starts_with(kSeal) || hash != *content)
        return user_error(messages::kDamaged);
    if (::access(path.c_str(), X_OK) != 0) return outside_error(system_reason(errno));
    return PrintBinary{std::move(*file), path};
}

/// Returns a descriptive name for the cache.
std::string cached_name(const fs::path& source, uint64_t hash) {
    constexpr size_t kLongest = 40;
    std::string stem = source.stem().string().substr(0, kLongest);
    std::replace_if(
        stem.begin(), stem.end(),
        [](char c) { return !std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-'; },
        '_');
    return fmt::format("{}-{:016x}", stem, hash);
}

/// Compiles into a file of its own.
Result<void> compile(const fs::path& compiler, const PrintProgram& wanted,
                     const fs::path& program) {
    std::vector<std::string> arguments{compiler.string(),         "build", "--target",
                                       abi::isa_name(wanted.isa), "-o",    program.string()};
    for (const std::string& path : wanted.schedules.paths)
        arguments.push_back("--schedule=" + path);
    for (const std::string& param : wanted.schedules.params)
        arguments.push_back("--param=" + param);
    if (wanted.dither)
        arguments.push_back(fmt::format("--dither-rule={}:{}", as_argument(wanted.dither->source),
                                        wanted.dither->rule));
    arguments.emplace_back("--");
    for (const fs::path& source : wanted.sources)
        arguments.push_back(as_argument(source));
    const Result<int> exit_status = run_program(arguments);
    if (!exit_status) return exit_status.error();
    if (*exit_status != 0) return Error{code_of_exit(*exit_status, wanted), ""};
    return seal(program);
}

/// The status with which the system's loader ends a program whose libraries it cannot load.
constexpr int kNotLoaded = 127;

}  // namespace

Result<int> run_program(const std::vector<std::string>& arguments, bool tells_interruption) {
    ProgramStart start;
    start.argv = arguments;
    start.tells_interruption = tells_interruption;
    start.out = STDERR_FILENO;
    pid_t child = 0;
    const int failed = start_program(start, &child);
    if (failed != 0) {
        return outside_error(
            fmt::format(messages::kCannotStartProgram, arguments[0], system_reason(failed)));
    }
    int status = 0;
    if (!RunningProgram(child).wait(&status))
        return outside_error(
            fmt::format(messages::kCannotWaitForProgramWhy, arguments[0], system_reason(errno)));
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotLoaded) {
        return outside_error(
            fmt::format(messages::kLibrariesNotLoaded, fs::path(arguments[0]).filename().string()));
    }
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    const int signal = WTERMSIG(status);
    if (kind_of_exit(kExitBySignal + signal) == ErrorCode::kInterrupted)
        return exit_code(ErrorCode::kInterrupted);
    const std::string ended = fmt::format(messages::kEndedBySignal, arguments[0], signal);
    // Others come from outside, as where memory is short.
    const bool crashed = signal == SIGSEGV || signal == SIGBUS || signal == SIGFPE ||
                         signal == SIGILL || signal == SIGABRT;
    return crashed ? internal_error(ended) : outside_error(ended);
}

std::vector<fs::path> inputs_of(const PrintProgram& program) {
    std::vector<fs::path> files = program.sources;
    if (program.dither) files.push_back(program.dither->source);
    files.insert(files.end(), program.schedules.paths.begin(), program.schedules.paths.end());
    for (const std::vector<fs::path>& beside : {modules_of(program), schedules_of(program)})
        files.insert(files.end(), beside.begin(), beside.end());
    return files;
}

Result<PrintBinary> find_or_build_print_binary(const PrintProgram& wanted, bool quiet) {
    const Result<fs::path> programs = program_folder();
    if (!programs) return programs.error();
    const fs::path compiler = *programs / "openflc";
    if (::access(compiler.c_str(), X_OK) != 0) {
        return outside_error(fmt::format(messages::kNoCompilerBeside, programs->string()));
    }
    const Result<uint64_t> hash = program_hash(wanted, *programs);
    if (!hash) return hash.error();
    const std::string name = cached_name(wanted.sources.front(), *hash);
    const Result<fs::path> cache = texture::cache_folder("prints");
    if (cache) {
        if (Result<PrintBinary> found = open_print_binary(*cache / name)) return found;
    }
    const Result<void> keeps = texture::check_keeps(cache);
    if (keeps) {
        clear_left_over(*cache);
    } else if (!quiet) {
        note(fmt::format(messages::kProgramNotCached, keeps.error().text()));
    }
    if (!quiet) say(fmt::format(messages::kCompiling, wanted.sources.front().filename().string()));
    // In a folder of its own, so that concurrent prints do not see each other's partial programs,
    // and none is left behind if this process dies.
    const Result<std::unique_ptr<TemporaryFolder>> folder =
        TemporaryFolder::create(keeps ? *cache : fs::path());
    if (!folder) return folder.error();
    const fs::path made = (*folder)->path() / name;
    if (Result<void> compiled = compile(compiler, wanted, made); !compiled) return compiled.error();
    std::error_code status;
    if (keeps) fs::rename(made, *cache / name, status);
    if (status) {
        return outside_error(
            fmt::format(messages::kCannotWrite, (*cache / name).string(), status.message()));
    }
    Result<PrintBinary> program = open_print_binary(keeps ? *cache / name : made);
    if (!program) {
        return outside_error(fmt::format(messages::kCannotReadCompiled, program.error().text()));
    }
    // Without a cache it is executed from its descriptor, although its file is deleted.
    if (!keeps) program->path.clear();
    return program;
}

}  // namespace openfab::tools
