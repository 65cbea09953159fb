// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/allowance.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "base/units.h"

namespace openfab {

namespace {

/// A hierarchy of control groups.
struct Hierarchy {
    std::string controllers;  ///< of version 1, between commas: `,cpu,cpuacct,`; empty: version 2
    std::string root;         ///< the group that is mounted
    std::string place;        ///< where
    bool is_second() const { return controllers.empty(); }
    bool has(std::string_view controller) const {
        return is_second() ||
               controllers.find("," + std::string(controller) + ",") != std::string::npos;
    }
};

/// The mounts of hierarchies: proc(5), /proc/self/mountinfo.
std::vector<Hierarchy> mounted(const std::string& root) {
    std::vector<Hierarchy> out;
    std::ifstream file(root + "/proc/self/mountinfo");
    for (std::string line; std::getline(file, line);) {
        const size_t dash = line.find(" - cgroup");
        if (dash == std::string::npos) continue;
        std::istringstream before(line.substr(0, dash));
        std::istringstream behind(line.substr(dash + 3));
        std::string skipped, type, options;
        Hierarchy one;
        before >> skipped >> skipped >> skipped >> one.root >> one.place;
        behind >> type >> skipped >> options;
        if (type == "cgroup") one.controllers = "," + options + ",";
        out.push_back(std::move(one));
    }
    return out;
}

/// The group of this process in a hierarchy, as a folder; empty where it is not told.
std::string group_in(const Hierarchy& hierarchy, const std::string& root) {
    std::ifstream file(root + "/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const size_t first = line.find(':');
        const size_t second = first == std::string::npos ? first : line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        if (hierarchy.is_second() ? !controllers.empty()
                                  : controllers.empty() || !hierarchy.has(controllers.substr(
                                                               0, controllers.find(','))))
            continue;
        std::string group = line.substr(second + 1);
        // In a container the mount shows a part of the hierarchy: from its root on.
        if (hierarchy.root != "/") {
            const bool is_below =
                group.starts_with(hierarchy.root) &&
                (group.size() == hierarchy.root.size() || group[hierarchy.root.size()] == '/');
            group = is_below ? group.substr(hierarchy.root.size()) : "";
        }
        while (!group.empty() && group.back() == '/')
            group.pop_back();
        // The group of a namespace outside of which nothing is seen.
        if (group.starts_with("/..")) group.clear();
        return group;
    }
    return {};
}

/// Reads the first number of a file, or the one behind the word `key`; `otherwise` where there is none (`max`).
double number_in(const std::string& path, std::string_view key = {}, double otherwise = -1) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string word;
        if (!key.empty() && (!(words >> word) || word != key)) continue;
        double number = 0;
        return words >> number ? number : otherwise;
    }
    return otherwise;
}

void narrow_memory(const std::string& folder, bool second, GroupAllowance* allowance) {
    const double limit = number_in(folder + (second ? "/memory.max" : "/memory.limit_in_bytes"));
    const double taken =
        number_in(folder + (second ? "/memory.current" : "/memory.usage_in_bytes"));
    constexpr double kNone = 4e18;  // version 1 says so by a number near 2^63
    if (limit < 0 || taken < 0 || limit > kNone) return;
    const double files = std::max(
        number_in(folder + "/memory.stat", second ? "inactive_file" : "total_inactive_file"), 0.0);
    allowance->memory_bytes =
        std::min(allowance->memory_bytes,
                 static_cast<int64_t>(std::max(limit - std::max(taken - files, 0.0), 0.0)));
}

void narrow_processors(const std::string& folder, bool second, GroupAllowance* allowance) {
    double quota = -1;
    double period = -1;
    if (second) {
        std::ifstream file(folder + "/cpu.max");
        if (!(file >> quota >> period)) return;
    } else {
        quota = number_in(folder + "/cpu.cfs_quota_us");
        period = number_in(folder + "/cpu.cfs_period_us");
    }
    if (quota > 0 && period > 0)
        allowance->processors = std::min(allowance->processors, quota / period);
}

}  // namespace

GroupAllowance read_group_allowance(const std::string& root) {
    GroupAllowance allowance;
    for (const Hierarchy& hierarchy : mounted(root)) {
        std::string group = group_in(hierarchy, root);
        for (;;) {
            const std::string folder = root + hierarchy.place + group;
            const bool second = hierarchy.is_second();
            if (hierarchy.has("memory")) narrow_memory(folder, second, &allowance);
            if (hierarchy.has("cpu")) narrow_processors(folder, second, &allowance);
            if (group.empty()) break;
            group.resize(group.rfind('/'));
        }
    }
    return allowance;
}

int usable_cores() {
#ifdef __SANITIZE_THREAD__
    // More than some machines have, so that races get their chance.
    return 8;
#else
    // 1.5 processors keep two threads busy for three quarters of the time, which is quicker than one.
    static const double quota = std::ceil(read_group_allowance().processors);
    cpu_set_t set;
    const double bound = ::sched_getaffinity(0, sizeof set, &set) == 0
                             ? CPU_COUNT(&set)
                             : std::thread::hardware_concurrency();
    return static_cast<int>(std::max(1.0, std::min(bound, quota)));
#endif
}

int64_t available_memory_bytes() {
    const double kilobytes = number_in("/proc/meminfo", "MemAvailable:");
    if (kilobytes < 0) return 0;
    return std::min(static_cast<int64_t>(kilobytes * 1024), read_group_allowance().memory_bytes);
}

int64_t default_memory_bytes() {
    return std::min(kDefaultMemoryBytes, read_group_allowance().memory_bytes / 5 * 4);
}

}  // namespace openfab
