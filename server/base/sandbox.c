#include "base/sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/file.h"

/* --- files: Landlock ------------------------------------------------------
 * By number and with our own structures: Debian 12's C library has no
 * wrappers, and its kernel headers are older than what kernels can do. */

#define CREATE_RULESET 444
#define ADD_RULE 445
#define RESTRICT_SELF 446
#define VERSION_FLAG 1u
#define PATH_BENEATH 1

#define READ_FILE (1ull << 2)
#define READ_DIR (1ull << 3)

struct ruleset {
    uint64_t files, ports, scopes;
};

struct path_rule {
    uint64_t allowed;
    int32_t parent;
} __attribute__((packed));

static long landlock_version(void)
{
    return syscall(CREATE_RULESET, NULL, 0, VERSION_FLAG);
}

/* Everything that a version can forbid. */
static struct ruleset handled(long version)
{
    static const int file_rights[] = { 0, 13, 14, 15, 15, 16 };
    int known = (int)(sizeof file_rights / sizeof *file_rights) - 1;
    int rights = file_rights[version < known ? version : known];
    return (struct ruleset){
        .files = (1ull << rights) - 1,
        .ports = version >= 4 ? 3 : 0,  /* bind, connect */
        .scopes = version >= 6 ? 3 : 0, /* abstract sockets, signals */
    };
}

/* -1: there is none. */
static int find(const char *place, const char *within)
{
    int fd;
    return !within || *place == '/' ? open(place, O_PATH | O_CLOEXEC)
           : pel_file_find_in(within, place, &fd, NULL) ? -1
                                                        : fd;
}

static bool allow(int rules, const char *place, const char *within)
{
    struct stat is;
    int fd = find(place, within);
    if (fd < 0) {
        return true;
    }
    struct path_rule rule = { READ_FILE, fd };
    if (fstat(fd, &is) == 0 && S_ISDIR(is.st_mode)) {
        rule.allowed |= READ_DIR;
    }
    bool good = syscall(ADD_RULE, rules, PATH_BENEATH, &rule, 0) == 0;
    close(fd);
    return good;
}

static bool wall_off_files(const struct pel_sandbox *s)
{
    const char *const *readable = s->readable;
    struct ruleset all = handled(landlock_version());
    int rules = (int)syscall(CREATE_RULESET, &all, sizeof all, 0);
    if (rules < 0) {
        return false;
    }
    bool good = true;
    for (; good && *readable; readable++) {
        good = allow(rules, *readable, s->within);
    }
    good = good && syscall(RESTRICT_SELF, rules, 0) == 0;
    close(rules);
    return good;
}

/* --- calls: seccomp ------------------------------------------------------- */

#if defined(__x86_64__)
#define ARCHITECTURE AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define ARCHITECTURE AUDIT_ARCH_AARCH64
#endif

#define TMPFILE_BIT 020000000
#define WRITING (O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND | TMPFILE_BIT)

/* What reading, computing and answering through open descriptors take. */
static const int allowed_calls[] = {
    SYS_read,           SYS_readv,
    SYS_pread64,        SYS_preadv,
    SYS_write,          SYS_writev,
    SYS_lseek,          SYS_close,
    SYS_fstat,          SYS_newfstatat,
    SYS_statx,          SYS_statfs,
    SYS_fstatfs,        SYS_faccessat,
    SYS_faccessat2,     SYS_readlinkat,
    SYS_getdents64,     SYS_getcwd,
    SYS_fadvise64,      SYS_dup,
    SYS_dup3,           SYS_brk,
    SYS_munmap,         SYS_mremap,
    SYS_madvise,        SYS_futex,
    SYS_sched_yield,    SYS_sched_getaffinity,
    SYS_getcpu,         SYS_clock_gettime,
    SYS_clock_getres,   SYS_clock_nanosleep,
    SYS_nanosleep,      SYS_gettimeofday,
    SYS_times,          SYS_getrusage,
    SYS_getrandom,      SYS_getpid,
    SYS_getppid,        SYS_gettid,
    SYS_getuid,         SYS_geteuid,
    SYS_getgid,         SYS_getegid,
    SYS_uname,          SYS_sysinfo,
    SYS_ppoll,          SYS_rt_sigaction,
    SYS_rt_sigprocmask, SYS_rt_sigreturn,
    SYS_sigaltstack,    SYS_restart_syscall,
    SYS_exit,           SYS_exit_group,
#ifdef __x86_64__
    SYS_stat,           SYS_lstat,
    SYS_access,         SYS_readlink,
    SYS_getdents,       SYS_poll,
    SYS_time,           SYS_dup2,
    SYS_getrlimit,
#endif
};

/* Those of fcntl; F_SETOWN would send signals to others. */
static const int allowed_fcntl[] = { F_DUPFD,     F_DUPFD_CLOEXEC, F_GETFD,
                                     F_SETFD,     F_GETFL,         F_GETLK,
                                     F_SETLK,     F_SETLKW,        F_OFD_GETLK,
                                     F_OFD_SETLK, F_OFD_SETLKW };

#ifdef ARCHITECTURE

#define MOST_STEPS 256

struct filter {
    struct sock_filter steps[MOST_STEPS];
    unsigned short count;
};

static void add(struct filter *f, unsigned short code, uint32_t k, int yes,
                int no)
{
    f->steps[f->count++] =
        (struct sock_filter){ code, (uint8_t)yes, (uint8_t)no, k };
}

static void load(struct filter *f, size_t offset)
{
    add(f, BPF_LD | BPF_W | BPF_ABS, (uint32_t)offset, 0, 0);
}

/* The low word of an argument; both machines are little-endian. */
static void load_argument(struct filter *f, int index)
{
    load(f, offsetof(struct seccomp_data, args) + 8u * (size_t)index);
}

static void end(struct filter *f, uint32_t what)
{
    add(f, BPF_RET | BPF_K, what, 0, 0);
}

static uint32_t fails_with(int why)
{
    return SECCOMP_RET_ERRNO | (uint32_t)why;
}

/* The steps of a call begin; how many they are is not known yet. */
static unsigned short begin(struct filter *f, int call)
{
    add(f, BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)call, 0, 0);
    return f->count;
}

/* Another call goes past them. */
static void finish(struct filter *f, unsigned short begun)
{
    f->steps[begun - 1].jf = (uint8_t)(f->count - begun);
}

/* Allowed unless an argument has one of the bits. */
static void without_bits(struct filter *f, int call, int argument, int bits)
{
    unsigned short begun = begin(f, call);
    load_argument(f, argument);
    add(f, BPF_JMP | BPF_JSET | BPF_K, (uint32_t)bits, 0, 1);
    end(f, fails_with(EACCES));
    end(f, SECCOMP_RET_ALLOW);
    finish(f, begun);
}

/* Allowed where an argument is one of the values. */
static void with_values(struct filter *f, int call, int argument,
                        const int *values, size_t count)
{
    unsigned short begun = begin(f, call);
    load_argument(f, argument);
    for (size_t i = 0; i < count; i++) {
        add(f, BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)values[i], 0, 1);
        end(f, SECCOMP_RET_ALLOW);
    }
    end(f, fails_with(EPERM));
    finish(f, begun);
}

/* Limits may be read: no new ones are given. */
static void without_pointer(struct filter *f, int call, int argument)
{
    size_t high = offsetof(struct seccomp_data, args) + 8u * (size_t)argument;
    unsigned short begun = begin(f, call);
    load_argument(f, argument);
    add(f, BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 3);
    load(f, high + 4);
    add(f, BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 1);
    end(f, SECCOMP_RET_ALLOW);
    end(f, fails_with(EPERM));
    finish(f, begun);
}

static void answer(struct filter *f, int call, uint32_t what)
{
    unsigned short begun = begin(f, call);
    end(f, what);
    finish(f, begun);
}

static void build_filter(struct filter *f)
{
    const int self = (int)getpid();
    load(f, offsetof(struct seccomp_data, arch));
    add(f, BPF_JMP | BPF_JEQ | BPF_K, ARCHITECTURE, 1, 0);
    end(f, SECCOMP_RET_KILL_PROCESS);
    load(f, offsetof(struct seccomp_data, nr));
    for (size_t i = 0; i < sizeof allowed_calls / sizeof *allowed_calls; i++) {
        answer(f, allowed_calls[i], SECCOMP_RET_ALLOW);
    }
    /* Each of these ends, so that the number is still loaded after it. */
#ifdef SYS_open
    without_bits(f, SYS_open, 1, WRITING);
#endif
    without_bits(f, SYS_openat, 2, WRITING);
    without_bits(f, SYS_mmap, 2, PROT_EXEC);
    without_bits(f, SYS_mprotect, 2, PROT_EXEC);
    with_values(f, SYS_fcntl, 1, allowed_fcntl,
                sizeof allowed_fcntl / sizeof *allowed_fcntl);
    with_values(f, SYS_tgkill, 0, &self, 1); /* abort() */
    without_pointer(f, SYS_prlimit64, 2);
    answer(f, SYS_ioctl, fails_with(ENOTTY));
    /* Flags behind pointers: the C library then asks without. */
    answer(f, SYS_openat2, fails_with(ENOSYS));
    answer(f, SYS_clone3, fails_with(ENOSYS));
    end(f, fails_with(EPERM));
}

static bool wall_off_calls(void)
{
    struct filter f = { .count = 0 };
    build_filter(&f);
    struct sock_fprog program = { f.count, f.steps };
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
}

static bool has_seccomp(void)
{
    /* A filter at no address: EFAULT where there are filters. */
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, NULL, 0, 0) < 0 &&
           errno == EFAULT;
}

#else

static bool wall_off_calls(void)
{
    return false;
}

static bool has_seccomp(void)
{
    return false;
}

#endif

/* --- the whole ------------------------------------------------------------ */

unsigned pel_sandbox_walls(void)
{
    return (landlock_version() >= 1 ? PEL_SANDBOX_FILES : 0) |
           (has_seccomp() ? PEL_SANDBOX_CALLS : 0);
}

const char *pel_sandbox_lack(unsigned walls)
{
    static const char *const words[] = {
        "neither Landlock nor seccomp: limits, an own process and a list of "
        "formats alone keep a hostile file in",
        "no seccomp: Landlock alone keeps a hostile file in; it may use "
        "other sockets than TCP",
        "no Landlock: seccomp alone keeps a hostile file in; it may read "
        "other files, and write none",
        NULL
    };
    return words[walls & PEL_SANDBOX_ALL];
}

/* A supervisor may forbid them, and then has limits of its own. */
static void limit(const struct pel_sandbox *s)
{
    __attribute__((unused))
    const struct rlimit memory = { s->memory_bytes, s->memory_bytes };
    const struct rlimit cpu = { s->cpu_s, s->cpu_s };
    const struct rlimit none = { 0, 0 };
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    (void)!setrlimit(RLIMIT_AS, &memory); /* sanitizers map far more */
#endif
    (void)!setrlimit(RLIMIT_CPU, &cpu);
    (void)!setrlimit(RLIMIT_CORE, &none);
    (void)!setrlimit(RLIMIT_FSIZE, &none);
    (void)!setrlimit(RLIMIT_MEMLOCK, &none);
    (void)!setrlimit(RLIMIT_MSGQUEUE, &none);
    /* Asleep for ever it would stay: the timer cannot be stopped inside. */
    alarm(10 * s->cpu_s);
}

enum pel_err pel_sandbox_close(const struct pel_sandbox *s,
                               struct pel_fault *fault)
{
    unsigned walls = s->walls & pel_sandbox_walls();
    (void)!syscall(SYS_close_range, 3u, ~0u, 0u);
    limit(s);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)) {
        return pel_fault_set(fault, PEL_ERR_IO, "no_new_privs: %s",
                             strerror(errno));
    }
    if ((walls & PEL_SANDBOX_FILES) && !wall_off_files(s)) {
        return pel_fault_set(fault, PEL_ERR_IO, "Landlock: %s",
                             strerror(errno));
    }
    if ((walls & PEL_SANDBOX_CALLS) && !wall_off_calls()) {
        return pel_fault_set(fault, PEL_ERR_IO, "seccomp: %s", strerror(errno));
    }
    return PEL_OK;
}
