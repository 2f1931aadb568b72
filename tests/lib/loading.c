/* Linked into every program of FLAVOR=asan. Memory that libraries ask for while
 * they are loaded is theirs, and the leak checker is not told of it: GLib's
 * first table of words is of it, which GLib leaves for good when a 2,049th word
 * comes. Its stack would tell as much, but only an unwinder of whole stacks
 * sees so far, and that one can stand still beside Mesa's compiler, since it
 * allocates under the lock that the unwinding of this allocation takes. */
#include <dlfcn.h>
#include <sanitizer/common_interface_defs.h>
#include <sanitizer/lsan_interface.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void begin_loading(void)
{
    __lsan_disable();
}

/* Before the constructors of libraries, which come before a program's own. */
__attribute__((section(".preinit_array"),
               used)) static void (*const begin)(void) = begin_loading;

__attribute__((constructor(101))) static void end_loading(void)
{
    __lsan_enable();
}

/* Both runtimes export how to say where reports go, so the call that UBSan's
 * makes of its own ends in ASan's, and its reports go to stderr, which a test
 * may throw away. */
__attribute__((constructor(102))) static void tell_ubsan_where(void)
{
    const char *options = getenv("UBSAN_OPTIONS");
    const char *path = options ? strstr(options, "log_path=") : NULL;
    void *ubsan = dlopen("libubsan.so.1", RTLD_LAZY | RTLD_NOLOAD);
    if (path && ubsan) {
        void (*set)(const char *);
        *(void **)&set = dlsym(ubsan, "__sanitizer_set_report_path");
        char until_colon[1024];
        path += strlen("log_path=");
        snprintf(until_colon, sizeof until_colon, "%.*s",
                 (int)strcspn(path, ":"), path);
        if (set) {
            set(until_colon);
        }
    }
    if (ubsan) {
        dlclose(ubsan);
    }
}
