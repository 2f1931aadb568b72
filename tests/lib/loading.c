/* Linked into every program of FLAVOR=asan. Memory that libraries ask for while
 * they are loaded is theirs, and the leak checker is not told of it: GLib's
 * first table of words is of it, which GLib leaves for good when a 2,049th word
 * comes. Its stack would tell as much, but only an unwinder of whole stacks
 * sees so far, and that one can stand still beside Mesa's compiler, since it
 * allocates under the lock that the unwinding of this allocation takes. */
#include <sanitizer/lsan_interface.h>

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
