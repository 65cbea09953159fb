// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/jail_walls.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace openfab {

#if defined(__x86_64__)

namespace {

/// What a program needs that computes, reads and makes threads.
constexpr uint32_t kAllowed[] = {SYS_read,
                                 SYS_write,
                                 SYS_readv,
                                 SYS_writev,
                                 SYS_pread64,
                                 SYS_pwrite64,
                                 SYS_close,
                                 SYS_fstat,
                                 SYS_stat,
                                 SYS_lstat,
                                 SYS_newfstatat,
                                 SYS_statx,
                                 SYS_lseek,
                                 SYS_munmap,
                                 SYS_mremap,
                                 SYS_brk,
                                 SYS_madvise,
                                 SYS_rt_sigaction,
                                 SYS_rt_sigprocmask,
                                 SYS_rt_sigreturn,
                                 SYS_sigaltstack,
                                 SYS_futex,
                                 SYS_sched_yield,
                                 SYS_nanosleep,
                                 SYS_clock_nanosleep,
                                 SYS_clock_gettime,
                                 SYS_clock_getres,
                                 SYS_gettimeofday,
                                 SYS_time,
                                 SYS_getpid,
                                 SYS_gettid,
                                 SYS_getppid,
                                 SYS_getuid,
                                 SYS_geteuid,
                                 SYS_getgid,
                                 SYS_getegid,
                                 SYS_getrandom,
                                 SYS_getcwd,
                                 SYS_access,
                                 SYS_faccessat,
                                 SYS_faccessat2,
                                 SYS_readlink,
                                 SYS_readlinkat,
                                 SYS_getdents64,
                                 SYS_fcntl,
                                 SYS_dup,
                                 SYS_poll,
                                 SYS_ppoll,
                                 SYS_exit,
                                 SYS_exit_group,
                                 SYS_set_robust_list,
                                 SYS_rseq,
                                 SYS_membarrier,
                                 SYS_sched_getaffinity,
                                 SYS_sysinfo,
                                 SYS_uname,
                                 SYS_getrusage,
                                 SYS_getrlimit,
                                 SYS_restart_syscall,
                                 SYS_fadvise64,
                                 SYS_getcpu,
                                 SYS_statfs,
                                 SYS_fstatfs};

/// And one that writes files.
constexpr uint32_t kAllowedWriting[] = {
    SYS_open,      SYS_openat,    SYS_creat,           SYS_ftruncate, SYS_truncate,
    SYS_fallocate, SYS_fsync,     SYS_fdatasync,       SYS_msync,     SYS_sync_file_range,
    SYS_rename,    SYS_renameat,  SYS_renameat2,       SYS_unlink,    SYS_unlinkat,
    SYS_rmdir,     SYS_mkdir,     SYS_mkdirat,         SYS_chmod,     SYS_fchmod,
    SYS_fchmodat,  SYS_utimensat, SYS_flock,           SYS_link,      SYS_linkat,
    SYS_symlink,   SYS_umask,     SYS_copy_file_range, SYS_sendfile,  SYS_memfd_create,
    SYS_pipe2,     SYS_eventfd2,  SYS_mprotect,        SYS_mmap,      SYS_dup2,
    SYS_dup3,      SYS_mincore,   SYS_mlock,           SYS_munlock,   SYS_prlimit64};

constexpr uint32_t kArgument[] = {offsetof(seccomp_data, args[0]), offsetof(seccomp_data, args[1]),
                                  offsetof(seccomp_data, args[2])};

/// A filter in the kernel's language, from first to last rule. Of arguments the lower half counts: flags and numbers of
/// processes have no other.
class Filter {
  public:
    Filter() {
        load(offsetof(seccomp_data, arch));
        add(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0);
        answer(kDeny);
        load(offsetof(seccomp_data, nr));
    }
    void allow(uint32_t call) {
        add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1);
        answer(SECCOMP_RET_ALLOW);
    }
    /// Allows a call if its argument has none of these bits.
    void allow_without(uint32_t call, size_t argument, uint32_t bits) {
        add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4);
        load(kArgument[argument]);
        add(BPF_JMP | BPF_JSET | BPF_K, bits, 1, 0);
        answer(SECCOMP_RET_ALLOW);
        answer(kDeny);
    }
    /// Allows a call if its argument is this, or has these bits.
    void allow_with(uint32_t call, size_t argument, uint32_t value, bool bits = false) {
        add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4);
        load(kArgument[argument]);
        add(static_cast<uint16_t>(BPF_JMP | (bits ? BPF_JSET : BPF_JEQ) | BPF_K), value, 0, 1);
        answer(SECCOMP_RET_ALLOW);
        answer(kDeny);
    }
    /// Answers that the kernel does not know a call.
    void unknown(uint32_t call) {
        add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1);
        answer(SECCOMP_RET_ERRNO | ENOSYS);
    }
    bool install() {
        answer(kDeny);
        const sock_fprog program{static_cast<uint16_t>(size_), rules_};
        return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
    }

  private:
    static constexpr uint32_t kDeny = SECCOMP_RET_ERRNO | EPERM;
    static constexpr size_t kMost = 400;

    void add(uint16_t code, uint32_t value, uint8_t if_true = 0, uint8_t if_false = 0) {
        if (size_ < kMost) rules_[size_++] = {code, if_true, if_false, value};
    }
    void load(uint32_t offset) { add(BPF_LD | BPF_W | BPF_ABS, offset); }
    void answer(uint32_t what) { add(BPF_RET | BPF_K, what); }

    sock_filter rules_[kMost] = {};
    size_t size_ = 0;
};

}  // namespace

bool deny_system_calls(bool converts) {
    Filter filter;
    for (const uint32_t call : kAllowed)
        filter.allow(call);
    if (converts) {
        for (const uint32_t call : kAllowedWriting)
            filter.allow(call);
    } else {
        constexpr uint32_t kChanging = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
        filter.allow_without(SYS_open, 1, kChanging);
        filter.allow_without(SYS_openat, 2, kChanging);
        filter.allow_without(SYS_mmap, 2, PROT_EXEC);
        filter.allow_without(SYS_mprotect, 2, PROT_EXEC);
    }
    // Threads of its own, but no other process. The flags of clone3 are in memory, which a filter cannot read.
    filter.unknown(SYS_clone3);
    filter.allow_with(SYS_clone, 0, CLONE_THREAD, true);
    const auto self = static_cast<uint32_t>(::getpid());
    filter.allow_with(SYS_tgkill, 0, self);
    filter.allow_with(SYS_kill, 0, self);
    filter.allow_with(SYS_ioctl, 1, TCGETS);
    return filter.install();
}

bool has_system_call_filters() {
    uint32_t action = SECCOMP_RET_ERRNO;
    return ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

#else

bool deny_system_calls(bool) {
    return false;
}
bool has_system_call_filters() {
    return false;
}

#endif

namespace {

constexpr uint64_t kReading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr uint64_t kWriting = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                              LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                              LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                              LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
                              LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;

/// Allows access below a folder, or to a file; of what is not there nothing can be allowed.
void allow_below(int rules, const std::filesystem::path& path, uint64_t access) {
    landlock_path_beneath_attr rule{};
    rule.parent_fd = ::open(path.c_str(), O_PATH | O_CLOEXEC);
    if (rule.parent_fd < 0) return;
    struct stat status {};
    constexpr uint64_t kOfFiles = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE;
    const bool is_folder = ::fstat(rule.parent_fd, &status) == 0 && S_ISDIR(status.st_mode);
    rule.allowed_access = is_folder ? access : access & kOfFiles;
    ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
    ::close(rule.parent_fd);
}

}  // namespace

bool deny_files(const JailLimits& limits) {
    landlock_ruleset_attr handled{};
    handled.handled_access_fs = LANDLOCK_ACCESS_FS_EXECUTE | kWriting;
    if (!limits.reads.empty()) handled.handled_access_fs |= kReading;
    const int rules =
        static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0));
    if (rules < 0) return false;
    for (const std::filesystem::path& path : limits.reads)
        allow_below(rules, path, kReading);
    for (const std::filesystem::path& path : limits.writes)
        allow_below(rules, path, kWriting);
    const bool closed = ::syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    ::close(rules);
    return closed;
}

bool has_landlock() {
    return ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) > 0;
}

}  // namespace openfab
