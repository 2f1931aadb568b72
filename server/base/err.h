/* Errors: a code for programs, a fault for people and protocols. */
#pragma once

#include <stddef.h>

enum pel_err {
    PEL_OK = 0,
    PEL_ERR_MALFORMED,    /* cannot be read */
    PEL_ERR_NOT_FOUND,    /* no such field, view, entity, file */
    PEL_ERR_OUT_OF_RANGE, /* outside its legal range */
    PEL_ERR_INVALID,      /* wrong type or form */
    PEL_ERR_CONFLICT,     /* contradicts the state */
    PEL_ERR_BUSY,         /* a limit is reached; later may work */
    PEL_ERR_UNAUTHORIZED, /* the token is missing or wrong */
    PEL_ERR_FORBIDDEN,    /* the token's role does not reach so far */
    PEL_ERR_IO,           /* the system refused; errno said why */
    PEL_ERR_FULL,         /* the disk has no room to keep it: nothing changed */
    PEL_ERR_GPU,          /* EGL, OpenGL or a shader failed */
    PEL_ERR_NO_MEMORY,
    PEL_ERR_INTERNAL,
};

#define PEL_CHECK __attribute__((warn_unused_result))

/* What went wrong, in the words a client needs. Strings are truncated, never
 * overrun; `unit` is a static string or NULL. minimum > maximum: no range. */
struct pel_fault {
    enum pel_err code;
    char path[96];
    char value[64];
    const char *unit;
    double minimum, maximum;
    char message[256];
};

/* Name of the code in the schema's spelling, e.g. "OUT_OF_RANGE"; never NULL.
 */
const char *pel_err_name(enum pel_err err);

/* Fills *fault (NULL allowed) with a code and a printf message, no path and no
 * range; returns the code. What the message quotes is shown by
 * pel_text_clean. */
enum pel_err pel_fault_set(struct pel_fault *fault, enum pel_err code,
                           const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same for all of its texts: what others sent may be in them. */
void pel_fault_clean(struct pel_fault *fault);

/* What the analyzer, which sees one source at a time, cannot know. */
#ifdef __clang_analyzer__
#define pel_fault_set(fault, code, ...)                                        \
    ((void)(pel_fault_set)(fault, code, __VA_ARGS__), (code))
#endif
