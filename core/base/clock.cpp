// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/clock.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>

namespace openfab {

namespace {

// Field 22 of /proc/self/stat, clock ticks after boot. The second field is the program's name in
// parentheses and may hold anything, so fields are counted from the last parenthesis.
double start_after_boot() {
    char text[1024] = {};
    std::FILE* file = std::fopen("/proc/self/stat", "r");
    if (file == nullptr) return -1;
    const size_t length = std::fread(text, 1, sizeof(text) - 1, file);
    std::fclose(file);
    text[length] = '\0';
    const char* p = std::strrchr(text, ')');
    for (int field = 2; p != nullptr && field < 22; ++field) {
        p = std::strchr(p + 1, ' ');
    }
    unsigned long long ticks = 0;
    if (p == nullptr || std::sscanf(p, " %llu", &ticks) != 1) return -1;
    return static_cast<double>(ticks) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double seconds_of(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double process_age_seconds() {
    static const double start = start_after_boot();
    const double seconds = seconds_of(CLOCK_BOOTTIME);
    // Without /proc: since the first call.
    static const double fallback = seconds;
    return seconds - (start >= 0 ? start : fallback);
}

double processor_seconds() {
    return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

double thread_processor_seconds() {
    return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

int64_t resident_bytes() {
    std::FILE* file = std::fopen("/proc/self/statm", "r");
    long long total = 0, resident = 0;
    if (file == nullptr) return 0;
    const int read = std::fscanf(file, "%lld %lld", &total, &resident);
    std::fclose(file);
    return read == 2 ? resident * sysconf(_SC_PAGESIZE) : 0;
}

int64_t peak_resident_bytes() {
    // getrusage includes the peak from before exec, which is that of the parent.
    long long kilobytes = 0;
    if (std::FILE* file = std::fopen("/proc/self/status", "r"); file != nullptr) {
        char line[256];
        bool found = false;
        while (!found && std::fgets(line, sizeof line, file) != nullptr)
            found = std::sscanf(line, "VmHWM: %lld", &kilobytes) == 1;
        std::fclose(file);
        if (found) return kilobytes * 1024;
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<int64_t>(usage.ru_maxrss) * 1024;
}

namespace {

/// Reads the number of a file, or of its line that begins with `key`; -1 where there is none ("max").
long long number_in(const std::string& path, const char* key = "") {
    std::FILE* file = std::fopen(path.c_str(), "r");
    if (file == nullptr) return -1;
    const std::string format = std::string(key) + " %lld";
    char line[256];
    long long number = -1;
    while (std::fgets(line, sizeof line, file) != nullptr) {
        if (std::sscanf(line, format.c_str(), &number) == 1) break;
    }
    std::fclose(file);
    return number;
}

/// Returns what the control groups of the process leave, or `most`: a group, and those that it is in.
int64_t left_by_control_groups(int64_t most) {
    char line[4096];
    std::FILE* file = std::fopen("/proc/self/cgroup", "r");
    if (file == nullptr) return most;
    std::string group;
    while (std::fgets(line, sizeof line, file) != nullptr) {
        if (std::strncmp(line, "0::", 3) == 0) group = line + 3;  // of version 2
    }
    std::fclose(file);
    while (!group.empty() && (group.back() == '\n' || group.back() == '/'))
        group.pop_back();
    for (;;) {
        const std::string folder = "/sys/fs/cgroup" + group;
        const long long limit = number_in(folder + "/memory.max");
        const long long taken = number_in(folder + "/memory.current");
        if (limit >= 0 && taken >= 0) most = std::min<int64_t>(most, std::max(limit - taken, 0LL));
        if (group.empty()) return most;
        group.resize(group.rfind('/'));
    }
}

}  // namespace

int64_t available_memory_bytes() {
    const long long kilobytes = number_in("/proc/meminfo", "MemAvailable:");
    if (kilobytes < 0) return 0;
    return left_by_control_groups(kilobytes * 1024);
}

}  // namespace openfab
