// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/own_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

#include "base/messages.h"
#include "base/system_reason.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLetters = 6;  // of mkstemp and mkdtemp
constexpr std::string_view kFolderName = "openfab";

/// Creates the missing folders down to `folder`, each accessible to this user alone.
Result<void> make(const fs::path& folder) {
    std::vector<fs::path> missing;
    std::error_code ignored;
    for (fs::path at = folder; !fs::exists(at, ignored) && at != at.parent_path();
         at = at.parent_path())
        missing.push_back(at);
    for (auto at = missing.rbegin(); at != missing.rend(); ++at) {
        // Another process may create it concurrently.
        if (::mkdir(at->c_str(), 0700) != 0 && errno != EEXIST)
            return outside_error(fmt::format(messages::kCannotBeMade, system_reason(errno)));
    }
    return {};
}

/// Checks one folder of the path; `last`: the one that is to be used.
Result<void> check(const fs::path& folder, bool last) {
    struct stat status {};
    if (::lstat(folder.c_str(), &status) != 0) return outside_error(system_reason(errno));
    const std::string name =
        last ? messages::kItself : fmt::format(messages::kFolderAbove, folder.string());
    if (!S_ISDIR(status.st_mode)) return user_error(fmt::format(messages::kNotAFolder, name));
    if (status.st_uid != ::geteuid() && (last || status.st_uid != 0))
        return user_error(fmt::format(messages::kOthersFolder, name, status.st_uid));
    const bool sticky = !last && (status.st_mode & S_ISVTX) != 0;
    if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0 && !sticky) {
        return user_error(fmt::format(messages::kOthersCanWrite, name, status.st_mode & 07777));
    }
    return {};
}

enum class Lock { kHeld, kTaken, kUnknown };

/// Locks an open file. Where the file system has no locks, nothing is cleared up either.
Lock lock(int descriptor) {
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return Lock::kHeld;
    return errno == EWOULDBLOCK ? Lock::kTaken : Lock::kUnknown;
}

/// Returns whether a new file or folder is still ours: between its creation and its lock, another
/// process may have removed it as a leftover.
bool is_ours(int descriptor) {
    struct stat status {};
    return descriptor >= 0 && lock(descriptor) != Lock::kTaken &&
           ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

bool is_temporary(const std::string& name) {
    const size_t mark = name.rfind(kTemporaryMark);
    return mark != std::string::npos && name.size() == mark + kTemporaryMark.size() + kLetters;
}

bool is_temporary_folder(const std::string& name) {
    return is_temporary(name) &&
           name.starts_with(std::string(kFolderName).append(kTemporaryMark)) &&
           name.size() == kFolderName.size() + kTemporaryMark.size() + kLetters;
}

bool is_own(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && status.st_uid == ::geteuid();
}

/// Removes folders, and files unless `folders_alone`, that have such a name, belong to this user
/// and are not locked.
void clear(const fs::path& folder, bool (*has_name)(const std::string& name), bool folders_alone) {
    std::error_code status;
    // The next process goes on: whoever has to clear away thousands would not get to its own work.
    constexpr size_t kMost = 64;
    std::vector<fs::path> found;
    for (fs::directory_iterator entry(folder, status), end;
         !status && entry != end && found.size() < kMost; entry.increment(status)) {
        if (has_name(entry->path().filename().string())) found.push_back(entry->path());
    }
    for (const fs::path& path : found) {
        const bool is_folder = fs::is_directory(fs::symlink_status(path, status));
        if (folders_alone && !is_folder) continue;
        const int flags = is_folder ? O_RDONLY | O_DIRECTORY : O_RDWR;
        const int held = ::open(path.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (held < 0) continue;
        if (is_own(held) && lock(held) == Lock::kHeld) fs::remove_all(path, status);
        ::close(held);
    }
}

/// Returns whether no other user can replace the folder or write to it.
bool is_apart(const fs::path& folder) {
    fs::path at;
    for (const fs::path& step : folder) {
        at /= step;
        if (!check(at, false)) return false;
    }
    return true;
}

}  // namespace

Result<fs::path> own_folder(const fs::path& folder) {
    std::error_code status;
    const fs::path absolute = fs::absolute(folder, status);
    if (status) return outside_error(status.message());
    if (Result<void> made = make(absolute); !made) return made.error();
    // Links are resolved once, here: changing one later cannot redirect us.
    const fs::path plain = fs::canonical(absolute, status);
    if (status) return outside_error(status.message());
    fs::path at;
    for (const fs::path& step : plain) {
        at /= step;
        if (Result<void> fine = check(at, at == plain); !fine) return fine.error();
    }
    return plain;
}

Result<void> check_writable(const fs::path& folder) {
    if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
    return outside_error(fmt::format(messages::kCannotBeWrittenTo, system_reason(errno)));
}

Result<std::unique_ptr<TemporaryFolder>> TemporaryFolder::create(const fs::path& base_folder) {
    std::error_code status;
    const fs::path parent = base_folder.empty() ? fs::temp_directory_path(status) : base_folder;
    if (status) {
        return outside_error(fmt::format(messages::kNoTemporaryFolder, status.message()));
    }
    const fs::path plain = fs::canonical(parent, status);
    if (!status && is_apart(plain)) clear(plain, is_temporary_folder, true);
    std::unique_ptr<TemporaryFolder> folder(new TemporaryFolder);
    for (;;) {
        std::string name =
            (parent / std::string(kFolderName).append(kTemporaryMark).append("XXXXXX")).string();
        int trouble = 0;
        folder->at_end_.emplace([&] {
            trouble = ::mkdtemp(name.data()) == nullptr ? errno : 0;
            return trouble == 0 ? fs::path(name) : fs::path();
        });
        if (trouble != 0) {
            return outside_error(
                fmt::format(messages::kCannotMakeFolder, parent.string(), system_reason(trouble)));
        }
        folder->path_ = name;
        folder->lock_ = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        trouble = errno;
        if (is_ours(folder->lock_)) return folder;
        // Another process has cleared it away before it was locked: the next one, then. Whatever else
        // it is would be so the next time, too.
        if (folder->lock_ < 0 && trouble != ENOENT) {
            return outside_error(
                fmt::format(messages::kCannotOpenFolder, parent.string(), system_reason(trouble)));
        }
        if (folder->lock_ >= 0) ::close(folder->lock_);
        folder->lock_ = -1;
    }
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
    if (lock_ >= 0) ::close(lock_);
}

int open_temporary(const fs::path& name, fs::path* made) {
    for (;;) {
        std::string pattern = name.string() + std::string(kTemporaryMark) + "XXXXXX";
        const int descriptor = ::mkostemp(pattern.data(), O_CLOEXEC);
        if (descriptor < 0) return -1;
        *made = pattern;
        if (is_ours(descriptor)) return descriptor;
        ::close(descriptor);
        ::unlink(made->c_str());
    }
}

void clear_left_over(const fs::path& folder) {
    clear(folder, is_temporary, false);
}

}  // namespace openfab
