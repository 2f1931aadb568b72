/* A strict pull reader of RFC 8259 text, and the path of the place it is at.
 * Behind json.h; not for other rooms. Every function that returns bool or an
 * error has filled r->fault (where not NULL) on failure. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

enum json_kind {
    JSON_OBJECT,
    JSON_ARRAY,
    JSON_STRING,
    JSON_NUMBER,
    JSON_TRUE,
    JSON_FALSE,
    JSON_NULL,
    JSON_BAD, /* nothing that starts a value */
};

#define JSON_NUMBER_SIZE 128

struct json_reader {
    const char *start, *at, *end;
    int depth;
    struct pel_fault *fault;
    size_t path_length;
    char path[256]; /* of the value being read, truncated when too long */
};

void json_begin(struct json_reader *r, const char *text, size_t length,
                struct pel_fault *fault);

/* After the outermost value: only white space may follow. */
PEL_CHECK enum pel_err json_end(struct json_reader *r);

/* What comes next; takes only white space. For JSON_BAD use json_bad. */
enum json_kind json_peek(struct json_reader *r);

/* Takes `[` or `{`, which json_peek has seen. MALFORMED: too deep. */
PEL_CHECK enum pel_err json_enter(struct json_reader *r);

/* In an array or object: whether another element follows; takes the comma, or
 * the closing `close`. *first is true before the first call. */
PEL_CHECK enum pel_err json_more(struct json_reader *r, char close, bool *first,
                                 bool *more);

/* A string, unescaped, with a NUL after it; free(). Refuses NUL inside. */
PEL_CHECK enum pel_err json_string(struct json_reader *r, char **out,
                                   size_t *length);

/* A member's name and its colon; free(). */
PEL_CHECK enum pel_err json_name(struct json_reader *r, char **out,
                                 size_t *length);

/* The text of a number. */
PEL_CHECK enum pel_err json_number_text(struct json_reader *r,
                                        char out[JSON_NUMBER_SIZE]);

/* true, false or null, which json_peek has seen. */
PEL_CHECK enum pel_err json_literal(struct json_reader *r, enum json_kind kind);

/* Adds a component to the path; returns the length to give to json_pop. */
size_t json_push(struct json_reader *r, const char *name, size_t length);
void json_pop(struct json_reader *r, size_t path_length);

/* A fault at the present path: "PATH <text>". `value` may be NULL. */
enum pel_err json_fault(struct json_reader *r, enum pel_err code,
                        const char *value, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* MALFORMED: no value starts here. */
enum pel_err json_bad(struct json_reader *r);
