// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab cache`: what is kept between prints, and how to be rid of it.

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <utility>

#include "base/own_folder.h"
#include "base/say.h"
#include "base/system_reason.h"
#include "base/units.h"
#include "texture/cache.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

bool is_hex(std::string_view text, size_t digits) {
    return text.size() == digits &&
           text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Only what a name says to be ours is listed and removed: the folder may be one that has other files, too.
bool is_texture(std::string_view name) {
    return name.ends_with(".oftx") && is_hex(name.substr(0, name.size() - 5), 16);
}

bool is_print(std::string_view name) {
    const size_t dash = name.rfind('-');
    return dash != std::string_view::npos && is_hex(name.substr(dash + 1), 16);
}

bool is_kernel(std::string_view name) {
    return name.ends_with(".kernel") && is_hex(name.substr(0, name.size() - 7), 32);
}

bool is_stock(std::string_view name) {
    return name.starts_with("stock_") && name.ends_with(".fl");
}

struct Kind {
    const char* name;
    const char* folder;  ///< below the cache's
    bool (*is_one)(std::string_view name);
    const char* what;
};

constexpr Kind kKinds[] = {{"textures", "", is_texture, "pictures and scans, converted"},
                           {"prints", "prints", is_print, "print programs"},
                           {"kernels", "kernels", is_kernel, "compiled stages"},
                           {"stock", "stock", is_stock, "fablets of the program"}};

struct Kept {
    const Kind* kind;
    fs::path path;
    int64_t bytes = 0;
    time_t used = 0;
};

/// Finds all files, those that are unused longest first.
std::vector<Kept> find_kept(const fs::path& cache) {
    std::vector<Kept> files;
    for (const Kind& kind : kKinds) {
        std::error_code status;
        const fs::path folder = *kind.folder != '\0' ? cache / kind.folder : cache;
        for (fs::directory_iterator at(folder, status), end; !status && at != end;
             at.increment(status)) {
            struct stat found {};
            const bool ours = kind.is_one(at->path().filename().string()) &&
                              ::lstat(at->path().c_str(), &found) == 0 && S_ISREG(found.st_mode);
            if (!ours) continue;
            files.push_back({&kind, at->path(), found.st_size,
                             std::max(found.st_atim.tv_sec, found.st_mtim.tv_sec)});
        }
    }
    std::sort(files.begin(), files.end(), [](const Kept& a, const Kept& b) {
        return std::pair(a.used, a.path) < std::pair(b.used, b.path);
    });
    return files;
}

int64_t bytes_of(const std::vector<Kept>& files) {
    int64_t bytes = 0;
    for (const Kept& file : files)
        bytes += file.bytes;
    return bytes;
}

std::string day_of(time_t time) {
    std::tm local{};
    char text[32] = "";
    if (::localtime_r(&time, &local) != nullptr)
        (void)std::strftime(text, sizeof text, "%Y-%m-%d", &local);
    return text;
}

std::string files_text(size_t count) {
    return fmt::format("{} file{}", count, count == 1 ? "" : "s");
}

void list(const fs::path& cache, const std::vector<Kept>& files, bool each) {
    std::string text = fmt::format("folder     {}\n", cache.string());
    for (const Kind& kind : kKinds) {
        size_t count = 0;
        int64_t bytes = 0;
        for (const Kept& file : files) {
            if (file.kind != &kind) continue;
            ++count;
            bytes += file.bytes;
        }
        text += fmt::format("{:<10} {:>12}  {:>8}  {}\n", kind.name, files_text(count),
                            format_bytes(bytes), kind.what);
    }
    text += fmt::format("{:<10} {:>12}  {:>8}\n", "all", files_text(files.size()),
                        format_bytes(bytes_of(files)));
    for (size_t i = 0; each && i < files.size(); ++i) {
        text += fmt::format("{:<10} {:>12}  {:>8}  {}\n", files[i].kind->name,
                            day_of(files[i].used), format_bytes(files[i].bytes),
                            files[i].path.lexically_relative(cache).string());
    }
    show(text);
}

/// Removes the first files, which are unused longest, until the others take at most so much.
Result<void> remove_down_to(int64_t most, const std::vector<Kept>& files) {
    int64_t left = bytes_of(files), gone = 0;
    size_t count = 0;
    for (const Kept& file : files) {
        if (left <= most) break;
        if (::unlink(file.path.c_str()) != 0 && errno != ENOENT) {
            return outside_error(
                fmt::format(messages::kCannotRemove, file.path.string(), system_reason(errno)));
        }
        left -= file.bytes;
        gone += file.bytes;
        ++count;
    }
    show(fmt::format("removed {}, {}\n", files_text(count), format_bytes(gone)));
    return {};
}

}  // namespace

std::vector<std::string> cache_kinds() {
    std::vector<std::string> names{"all"};
    for (const Kind& kind : kKinds)
        names.emplace_back(kind.name);
    return names;
}

Result<void> run_cache(const CacheArguments& arguments) {
    const Result<fs::path> cache = texture::cache_folder();
    if (!cache) return cache.error();
    std::vector<Kept> files = find_kept(*cache);
    if (arguments.limit.empty() && arguments.purge.empty()) {
        list(*cache, files, arguments.files);
        return {};
    }
    int64_t most = 0;
    if (!arguments.limit.empty()) {
        const Result<int64_t> limit = parse_bytes(arguments.limit);
        if (!limit) return usage_error(messages::kOfLimit + limit.error().text());
        most = *limit;
    }
    // What killed programs have left half made, too.
    for (const Kind& kind : kKinds) {
        const fs::path folder = *kind.folder != '\0' ? *cache / kind.folder : *cache;
        if (std::error_code status; fs::is_directory(folder, status)) clear_left_over(folder);
    }
    if (!arguments.purge.empty() && arguments.purge != "all")
        std::erase_if(files, [&](const Kept& file) { return file.kind->name != arguments.purge; });
    return remove_down_to(most, files);
}

}  // namespace openfab::tools
