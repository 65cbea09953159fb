// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/allowance.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "base/units.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

/// Files of a system, below a folder.
class System {
  public:
    void write(const std::string& path, const std::string& text) {
        const fs::path file(root() + path);
        fs::create_directories(file.parent_path());
        std::ofstream(file) << text;
    }
    std::string root() const { return fs::path(scratch_ / "root").string(); }
    GroupAllowance read() const { return read_group_allowance(root()); }

  private:
    ScratchFolder scratch_;
};

constexpr const char* kSecond =
    "24 30 0:22 / /proc rw,relatime - proc proc rw\n"
    "35 25 0:30 / /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw,nsdelegate\n";
constexpr const char* kFirst =
    "31 23 0:28 / /sys/fs/cgroup rw,relatime - tmpfs tmpfs rw,mode=755\n"
    "32 31 0:29 / /sys/fs/cgroup/cpu,cpuacct rw,relatime - cgroup cgroup rw,cpu,cpuacct\n"
    "35 31 0:32 / /sys/fs/cgroup/memory rw,relatime - cgroup cgroup rw,memory\n"
    "41 31 0:38 / /sys/fs/cgroup/unified rw,relatime - cgroup2 cgroup2 rw\n";

TEST(Allowance, IsAllWithoutGroups) {
    System none;
    EXPECT_EQ(none.read(), GroupAllowance());
    none.write("/proc/self/mountinfo", kSecond);
    EXPECT_EQ(none.read(), GroupAllowance());
    none.write("/proc/self/cgroup", "0::/\n");
    EXPECT_EQ(none.read(), GroupAllowance());
    none.write("/sys/fs/cgroup/cpu.max", "max 100000\n");
    none.write("/sys/fs/cgroup/memory.max", "max\n");
    none.write("/sys/fs/cgroup/memory.current", "1000\n");
    EXPECT_EQ(none.read(), GroupAllowance());
}

TEST(Allowance, IsTheLeastOfTheGroupsAround) {
    System job;
    job.write("/proc/self/mountinfo", kSecond);
    job.write("/proc/self/cgroup", "0::/slurm/job_7/step_0\n");
    const std::string top = "/sys/fs/cgroup/slurm";
    job.write(top + "/cpu.max", "800000 100000\n");
    job.write(top + "/job_7/cpu.max", "350000 100000\n");
    job.write(top + "/job_7/step_0/cpu.max", "max 100000\n");
    job.write(top + "/job_7/memory.max", "4000000000\n");
    job.write(top + "/job_7/memory.current", "1500000000\n");
    job.write(top + "/job_7/memory.stat", "anon 800000000\ninactive_file 300000000\n");
    job.write(top + "/job_7/step_0/memory.max", "max\n");
    job.write(top + "/job_7/step_0/memory.current", "1000\n");
    EXPECT_EQ(job.read(), (GroupAllowance{3.5, 4000000000 - 1500000000 + 300000000}));
    job.write(top + "/memory.max", "1000000\n");
    job.write(top + "/memory.current", "2000000\n");
    EXPECT_EQ(job.read(), (GroupAllowance{3.5, 0}));
}

TEST(Allowance, IsThatOfVersionOneToo) {
    System job;
    job.write("/proc/self/mountinfo", kFirst);
    job.write("/proc/self/cgroup",
              "9:name=systemd:/\n4:memory:/batch/7\n2:cpu,cpuacct:/batch/7\n0::/\n");
    job.write("/sys/fs/cgroup/cpu,cpuacct/batch/7/cpu.cfs_quota_us", "150000\n");
    job.write("/sys/fs/cgroup/cpu,cpuacct/batch/7/cpu.cfs_period_us", "100000\n");
    job.write("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1\n");
    job.write("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000\n");
    job.write("/sys/fs/cgroup/memory/batch/memory.limit_in_bytes", "2000000000\n");
    job.write("/sys/fs/cgroup/memory/batch/memory.usage_in_bytes", "500000000\n");
    job.write("/sys/fs/cgroup/memory/batch/memory.stat",
              "inactive_file 7\ntotal_inactive_file 100000000\n");
    job.write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    job.write("/sys/fs/cgroup/memory/memory.usage_in_bytes", "5000000000\n");
    EXPECT_EQ(job.read(), (GroupAllowance{1.5, 1600000000}));
}

TEST(Allowance, IsFoundInAContainer) {
    // The mount begins at the container's own group, or the group lies outside of what is seen.
    for (const auto& [mounted, group] : {std::pair{"/docker/abc", "/docker/abc/inner"},
                                         {"/docker/abc", "/docker/abcd"},
                                         {"/", "/../../inner"}}) {
        System container;
        container.write("/proc/self/mountinfo", "35 25 0:30 " + std::string(mounted) +
                                                    " /sys/fs/cgroup ro - cgroup2 cgroup rw\n");
        container.write("/proc/self/cgroup", "0::" + std::string(group) + "\n");
        container.write("/sys/fs/cgroup/cpu.max", "400000 200000\n");
        container.write("/sys/fs/cgroup/inner/cpu.max", "100000 100000\n");
        EXPECT_EQ(container.read().processors, group == std::string("/docker/abc/inner") ? 1 : 2)
            << group;
    }
}

TEST(Allowance, FollowsTheAffinity) {
    cpu_set_t before;
    ASSERT_EQ(::sched_getaffinity(0, sizeof before, &before), 0);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu)
        if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
    ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
#ifndef __SANITIZE_THREAD__
    EXPECT_EQ(usable_cores(), 1);
#endif
    ASSERT_EQ(::sched_setaffinity(0, sizeof before, &before), 0);
    EXPECT_GE(usable_cores(), 1);
#ifndef __SANITIZE_THREAD__
    EXPECT_LE(usable_cores(), CPU_COUNT(&before));
#endif
    EXPECT_GT(available_memory_bytes(), 0);
    EXPECT_LE(default_memory_bytes(), kDefaultMemoryBytes);
}

}  // namespace
}  // namespace openfab::testing
