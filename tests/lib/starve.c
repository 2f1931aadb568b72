/* Linked into pelagosd-starved with --wrap: memory that our own code asks for
 * is refused at chosen calls. What libraries ask for is not meant. The file
 * that STARVE names is shared with tests/starve_test.py. */
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define SITES (1 << 18)

struct shared {
    _Atomic uint64_t calls; /* so far */
    _Atomic uint64_t from;  /* this call and those behind it... */
    _Atomic uint64_t count; /* ...so many fail; 0: none */
    _Atomic uint64_t failed;
    _Atomic uint32_t site[SITES]; /* of call n: at n % SITES */
};

extern const char __executable_start[];

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t align, size_t size);
int __real_posix_memalign(void **out, size_t align, size_t size);
char *__real_strdup(const char *text);
char *__real_strndup(const char *text, size_t most);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t align, size_t size);
int __wrap_posix_memalign(void **out, size_t align, size_t size);
char *__wrap_strdup(const char *text);
char *__wrap_strndup(const char *text, size_t most);

static struct shared *shared;

__attribute__((constructor)) static void begin(void)
{
    const char *name = getenv("STARVE");
    int fd = name ? open(name, O_RDWR | O_CLOEXEC) : -1;
    if (fd >= 0) {
        void *at = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE,
                        MAP_SHARED, fd, 0);
        shared = at == MAP_FAILED ? NULL : at;
        close(fd);
    }
}

static int refused(const void *caller)
{
    if (!shared) {
        return 0;
    }
    uint64_t n = atomic_fetch_add(&shared->calls, 1);
    uint64_t from = atomic_load(&shared->from);
    atomic_store(&shared->site[n % SITES],
                 (uint32_t)((const char *)caller - __executable_start));
    if (n < from || n - from >= atomic_load(&shared->count)) {
        return 0;
    }
    atomic_fetch_add(&shared->failed, 1);
    errno = ENOMEM;
    return 1;
}

#define REFUSED refused(__builtin_return_address(0))

void *__wrap_malloc(size_t size)
{
    return REFUSED ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return REFUSED ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    return REFUSED ? NULL : __real_realloc(old, size);
}

void *__wrap_aligned_alloc(size_t align, size_t size)
{
    return REFUSED ? NULL : __real_aligned_alloc(align, size);
}

int __wrap_posix_memalign(void **out, size_t align, size_t size)
{
    return REFUSED ? ENOMEM : __real_posix_memalign(out, align, size);
}

char *__wrap_strdup(const char *text)
{
    return REFUSED ? NULL : __real_strdup(text);
}

char *__wrap_strndup(const char *text, size_t most)
{
    return REFUSED ? NULL : __real_strndup(text, most);
}
