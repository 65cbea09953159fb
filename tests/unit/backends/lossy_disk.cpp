// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/backends/lossy_disk.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <fstream>
#include <iterator>
#include <set>
#include "tests/support/long_run.h"

namespace openfab::testing {

namespace {

namespace fs = std::filesystem;

LossyDisk* recorder = nullptr;
fs::path recorded;
std::map<int, int> open_files;     ///< descriptors, and the files that they are of
std::map<int, fs::path> mappings;  ///< of files, which may have been written through one

template <typename Function>
Function* real(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

/// The name in the recorded folder; empty elsewhere.
std::string name_of(int folder, const char* path) {
    if (recorder == nullptr) return {};
    fs::path full(path);
    if (full.is_relative() && folder != AT_FDCWD) {
        std::error_code ignored;
        full = fs::read_symlink("/proc/self/fd/" + std::to_string(folder), ignored) / full;
    }
    return full.parent_path() == recorded ? full.filename().string() : std::string();
}

void note_open(int fd, const std::string& name, int flags, bool was_there) {
    if (fd < 0 || name.empty() || (flags & O_ACCMODE) == O_RDONLY) return;
    const int file = recorder->file_of(name, !was_there);
    open_files[fd] = file;
    if ((flags & O_TRUNC) != 0)
        recorder->add({LossyDisk::Step::Kind::kTruncate, file, {}, {}, 0, {}});
}

void note_write(int fd, int64_t at, const void* data, ssize_t n) {
    const auto found = open_files.find(fd);
    if (recorder == nullptr || found == open_files.end() || n <= 0) return;
    recorder->add({LossyDisk::Step::Kind::kWrite,
                   found->second,
                   {},
                   {},
                   at,
                   std::string(static_cast<const char*>(data), static_cast<size_t>(n))});
}

/// What was written through mappings is written now, as far as a recorder can see.
void note_mappings() {
    for (const auto& [file, path] : mappings) {
        std::ifstream in(path, std::ios::binary);
        if (in) recorder->mapped(file, {std::istreambuf_iterator<char>(in), {}});
    }
    mappings.clear();
}

bool exists(int folder, const char* path) {
    struct stat there {};
    return ::fstatat(folder, path, &there, AT_SYMLINK_NOFOLLOW) == 0;
}

int open_noted(int folder, const char* path, int flags, mode_t mode) {
    const std::string name = name_of(folder, path);
    const bool was_there = !name.empty() && exists(folder, path);
    const int fd = real<int(int, const char*, int, ...)>("openat")(folder, path, flags, mode);
    note_open(fd, name, flags, was_there);
    return fd;
}

}  // namespace

LossyDisk::LossyDisk(const fs::path& folder) {
    fs::create_directories(folder);
    for (const auto& [name, bytes] : files_in(folder)) {
        before_.names[name] = next_;
        before_.files[next_++] = bytes;
    }
    names_ = before_.names;
    recorded = folder;
    open_files.clear();
    mappings.clear();
    recorder = this;
}

LossyDisk::~LossyDisk() {
    stop();
}

void LossyDisk::stop() {
    if (recorder == this) recorder = nullptr;
}

void LossyDisk::add(Step step) {
    steps_.push_back(std::move(step));
}

int LossyDisk::file_of(const std::string& name, bool creates) {
    if (creates) {
        names_[name] = next_;
        add({Step::Kind::kCreate, next_, name, {}, 0, {}});
        return next_++;
    }
    return names_.at(name);
}

void LossyDisk::rename(const std::string& from, const std::string& to) {
    names_[to] = names_.at(from);
    names_.erase(from);
    add({Step::Kind::kRename, names_[to], from, to, 0, {}});
}

void LossyDisk::mapped(int file, const std::string& bytes) {
    add({Step::Kind::kWrite, file, {}, {}, 0, bytes});
}

void LossyDisk::remove(const std::string& name) {
    names_.erase(name);
    add({Step::Kind::kRemove, -1, name, {}, 0, {}});
}

void LossyDisk::Disk::apply_name(const Step& step) {
    if (step.kind == Step::Kind::kCreate) names[step.name] = step.file;
    if (step.kind == Step::Kind::kRemove) names.erase(step.name);
    if (step.kind != Step::Kind::kRename) return;
    // Both names may be there where the first change of two is late.
    names[step.other] = step.file;
    const auto from = names.find(step.name);
    if (from != names.end() && from->second == step.file) names.erase(from);
}

void LossyDisk::Disk::apply_bytes(const Step& step) {
    std::string& file = files[step.file];
    if (step.kind == Step::Kind::kTruncate) file.resize(static_cast<size_t>(step.at));
    if (step.kind != Step::Kind::kWrite) return;
    const auto at = static_cast<size_t>(step.at);
    file.resize(std::max(file.size(), at + step.bytes.size()));
    file.replace(at, step.bytes.size(), step.bytes);
}

Files LossyDisk::after_loss(size_t moment, std::mt19937* random) const {
    const auto chance = [&](unsigned of) { return (*random)() % of == 0; };
    const auto is_name = [](const Step& s) {
        return s.kind == Step::Kind::kCreate || s.kind == Step::Kind::kRename ||
               s.kind == Step::Kind::kRemove;
    };
    // The last sync of all that a name or a file was part of.
    size_t synced = 0, names_synced = 0;
    std::map<int, size_t> file_synced;
    for (size_t i = 0; i < moment; ++i) {
        if (steps_[i].kind != Step::Kind::kSync) continue;
        if (steps_[i].file == -1) synced = i + 1;
        if (steps_[i].file < 0) names_synced = i + 1;
        if (steps_[i].file >= 0) file_synced[steps_[i].file] = i + 1;
    }
    Disk disk = before_;
    std::vector<const Step*> loose;
    const bool loses_names = !chance(3);
    std::map<int, int> fate;  // of files: 0 all, 1 none, 2 torn
    for (size_t i = 0; i < moment; ++i) {
        const Step& step = steps_[i];
        if (step.kind == Step::Kind::kSync) continue;
        if (is_name(step)) {
            if (i < names_synced) {
                disk.apply_name(step);
            } else {
                loose.push_back(&step);
            }
            continue;
        }
        const auto own = file_synced.find(step.file);
        if (i < synced || (own != file_synced.end() && i < own->second)) {
            disk.apply_bytes(step);
            continue;
        }
        if (!fate.contains(step.file)) fate[step.file] = static_cast<int>((*random)() % 4) % 3;
        if (fate[step.file] == 1) continue;
        Step part = step;
        if (fate[step.file] == 2 && !part.bytes.empty()) {
            const size_t cut = (*random)() % part.bytes.size();
            std::fill(part.bytes.begin() + static_cast<std::ptrdiff_t>(cut), part.bytes.end(),
                      '\0');
            if (chance(2)) part.bytes.resize(cut);
        }
        disk.apply_bytes(part);
    }
    if (loses_names && chance(2)) {
        // Neighbours change places: what is written late.
        for (size_t i = 0; i + 1 < loose.size(); ++i) {
            if (chance(4)) std::swap(loose[i], loose[i + 1]);
        }
    }
    const unsigned lost = 2 + (*random)() % 30;
    for (const Step* step : loose) {
        if (!loses_names || !chance(lost)) disk.apply_name(*step);
    }
    Files out;
    for (const auto& [name, file] : disk.names) {
        const auto found = disk.files.find(file);
        out[name] = found == disk.files.end() ? std::string() : found->second;
    }
    return out;
}

int count_of_cuts() {
    return long_run() ? 10'000 : 1000;
}

void put_files(const fs::path& folder, const Files& files) {
    std::set<std::string> there;
    for (const auto& entry : fs::directory_iterator(folder))
        there.insert(entry.path().filename().string());
    for (const auto& [name, bytes] : files) {
        there.erase(name);
        std::ofstream(folder / name, std::ios::binary) << bytes;
    }
    for (const std::string& name : there)
        fs::remove(folder / name);
}

Files files_in(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::ifstream in(entry.path(), std::ios::binary);
        files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(in), {}};
    }
    return files;
}

}  // namespace openfab::testing

// What the code under test calls, in place of the C library's. Also what it calls through the C++ library, which finds
// only what is visible.

using openfab::testing::open_files;
using openfab::testing::recorder;
using Step = openfab::testing::LossyDisk::Step;

#pragma GCC visibility push(default)

extern "C" {

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const auto mode = static_cast<mode_t>(va_arg(more, unsigned));
    va_end(more);
    return openfab::testing::open_noted(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const auto mode = static_cast<mode_t>(va_arg(more, unsigned));
    va_end(more);
    return openfab::testing::open_noted(folder, path, flags, mode);
}

int close(int fd) {
    open_files.erase(fd);
    return openfab::testing::real<int(int)>("close")(fd);
}

ssize_t write(int fd, const void* data, size_t size) {
    int64_t at = 0;
    if (recorder != nullptr && open_files.contains(fd)) {
        struct stat now {};
        ::fstat(fd, &now);
        at = (::fcntl(fd, F_GETFL) & O_APPEND) != 0 ? now.st_size : ::lseek(fd, 0, SEEK_CUR);
    }
    const ssize_t n =
        openfab::testing::real<ssize_t(int, const void*, size_t)>("write")(fd, data, size);
    openfab::testing::note_write(fd, at, data, n);
    return n;
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
    const ssize_t n = openfab::testing::real<ssize_t(int, const void*, size_t, off_t)>("pwrite")(
        fd, data, size, at);
    openfab::testing::note_write(fd, at, data, n);
    return n;
}

int ftruncate(int fd, off_t size) {
    const int done = openfab::testing::real<int(int, off_t)>("ftruncate")(fd, size);
    const auto found = open_files.find(fd);
    if (done == 0 && recorder != nullptr && found != open_files.end())
        recorder->add({Step::Kind::kTruncate, found->second, {}, {}, size, {}});
    return done;
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) {
    const std::string a = openfab::testing::name_of(from_folder, from);
    const std::string b = openfab::testing::name_of(to_folder, to);
    if (!a.empty()) openfab::testing::note_mappings();
    const int done = openfab::testing::real<int(int, const char*, int, const char*)>("renameat")(
        from_folder, from, to_folder, to);
    if (done == 0 && !a.empty() && !b.empty()) recorder->rename(a, b);
    return done;
}

int rename(const char* from, const char* to) {
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}

int unlinkat(int folder, const char* path, int flags) {
    const std::string name = openfab::testing::name_of(folder, path);
    const int done =
        openfab::testing::real<int(int, const char*, int)>("unlinkat")(folder, path, flags);
    if (done == 0 && !name.empty()) recorder->remove(name);
    return done;
}

int unlink(const char* path) {
    return unlinkat(AT_FDCWD, path, 0);
}

// Of the standard library's: files only.
int remove(const char* path) {
    const std::string name = openfab::testing::name_of(AT_FDCWD, path);
    const int done = openfab::testing::real<int(const char*)>("remove")(path);
    if (done == 0 && !name.empty()) recorder->remove(name);
    return done;
}

int mkostemp(char* pattern, int flags) {
    const int fd = openfab::testing::real<int(char*, int)>("mkostemp")(pattern, flags);
    if (fd >= 0)
        openfab::testing::note_open(fd, openfab::testing::name_of(AT_FDCWD, pattern),
                                    flags | O_RDWR | O_CREAT, false);
    return fd;
}

void* mmap(void* at, size_t size, int protection, int flags, int fd, off_t offset) {
    if (recorder != nullptr && fd >= 0 && (flags & MAP_SHARED) != 0 &&
        (protection & PROT_WRITE) != 0 && open_files.contains(fd)) {
        std::error_code ignored;
        openfab::testing::mappings[open_files[fd]] =
            std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd), ignored);
    }
    return reinterpret_cast<void*>(::syscall(SYS_mmap, at, size, protection, flags, fd, offset));
}

int fdatasync(int fd) {
    return fsync(fd);
}

int fsync(int fd) {
    const auto found = open_files.find(fd);
    if (recorder != nullptr && found != open_files.end())
        recorder->add({Step::Kind::kSync, found->second, {}, {}, 0, {}});
    std::error_code ignored;
    if (recorder != nullptr && found == open_files.end() &&
        std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd), ignored) ==
            openfab::testing::recorded)
        recorder->add({Step::Kind::kSync, openfab::testing::LossyDisk::kNames, {}, {}, 0, {}});
    return 0;  // nothing needs to reach the disk of the tests
}

int syncfs(int) {
    if (recorder != nullptr) recorder->add({Step::Kind::kSync, -1, {}, {}, 0, {}});
    return 0;
}
}

#pragma GCC visibility pop
