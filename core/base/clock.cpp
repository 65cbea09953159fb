// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/clock.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

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

}  // namespace openfab
