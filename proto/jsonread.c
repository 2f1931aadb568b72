#include "jsonread.h"

#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fault.h"
#include "json.h"

void json_begin(struct json_reader *r, const char *text, size_t length,
                struct pel_fault *fault)
{
    r->start = r->at = text;
    r->end = text + length;
    r->depth = 0;
    r->fault = fault;
    r->path_length = 0;
    r->path[0] = '\0';
}

/* MALFORMED at the place the reader is at. */
static enum pel_err malformed(struct json_reader *r, const char *what)
{
    size_t line = 1, column = 1;
    for (const char *p = r->start; p < r->at; p++) {
        column = *p == '\n' ? 1 : column + 1;
        line += *p == '\n';
    }
    pel_fault_set(r->fault, PEL_ERR_MALFORMED,
                  "not JSON at line %zu, column %zu: %s", line, column, what);
    if (r->fault) {
        pel_fault_at(r->fault, r->path_length > 0 ? r->path : NULL, NULL);
    }
    return PEL_ERR_MALFORMED;
}

enum pel_err json_fault(struct json_reader *r, enum pel_err code,
                        const char *value, const char *format, ...)
{
    if (r->fault) {
        char text[160];
        va_list args;
        va_start(args, format);
        vsnprintf(text, sizeof text, format, args);
        va_end(args);
        pel_fault_set(r->fault, code, "%.90s %s",
                      r->path_length > 0 ? r->path : "the message", text);
        pel_fault_at(r->fault, r->path_length > 0 ? r->path : NULL, value);
    }
    return code;
}

size_t json_push(struct json_reader *r, const char *name, size_t length)
{
    size_t before = r->path_length;
    size_t room = sizeof r->path - 1 - before;
    int wrote =
        snprintf(r->path + before, room + 1, "%s%.*s", before > 0 ? "." : "",
                 length > 200 ? 200 : (int)length, name);
    r->path_length = before + ((size_t)wrote < room ? (size_t)wrote : room);
    return before;
}

void json_pop(struct json_reader *r, size_t path_length)
{
    r->path_length = path_length;
    r->path[path_length] = '\0';
}

static void skip_space(struct json_reader *r)
{
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t' ||
                              *r->at == '\n' || *r->at == '\r')) {
        r->at++;
    }
}

enum pel_err json_end(struct json_reader *r)
{
    skip_space(r);
    return r->at == r->end ? PEL_OK
                           : malformed(r, "text after the end of the value");
}

enum json_kind json_peek(struct json_reader *r)
{
    skip_space(r);
    if (r->at == r->end) {
        return JSON_BAD;
    }
    switch (*r->at) {
    case '{':
        return JSON_OBJECT;
    case '[':
        return JSON_ARRAY;
    case '"':
        return JSON_STRING;
    case 't':
        return JSON_TRUE;
    case 'f':
        return JSON_FALSE;
    case 'n':
        return JSON_NULL;
    default:
        return *r->at == '-' || g_ascii_isdigit(*r->at) ? JSON_NUMBER
                                                        : JSON_BAD;
    }
}

enum pel_err json_enter(struct json_reader *r)
{
    if (r->depth == PEL_JSON_MAX_DEPTH) {
        return malformed(r, "nested too deeply");
    }
    r->depth++;
    r->at++;
    return PEL_OK;
}

enum pel_err json_more(struct json_reader *r, char close, bool *first,
                       bool *more)
{
    skip_space(r);
    bool at_start = *first;
    *first = false;
    if (r->at < r->end && *r->at == close) {
        r->at++;
        r->depth--;
        *more = false;
        return PEL_OK;
    }
    *more = true;
    if (at_start) {
        return PEL_OK;
    }
    if (r->at == r->end || *r->at != ',') {
        return malformed(r,
                         close == '}' ? "expected , or }" : "expected , or ]");
    }
    r->at++;
    skip_space(r);
    if (r->at < r->end && *r->at == close) {
        return malformed(r, "a comma before the end of a list");
    }
    return PEL_OK;
}

/* Four hexadecimal digits at r->at. */
static bool hex4(struct json_reader *r, unsigned *out)
{
    *out = 0;
    if (r->end - r->at < 4) {
        return false;
    }
    for (int i = 0; i < 4; i++) {
        int digit = g_ascii_xdigit_value(r->at[i]);
        if (digit < 0) {
            return false;
        }
        *out = *out * 16 + (unsigned)digit;
    }
    r->at += 4;
    return true;
}

/* What follows `\u`: one character, of one or two units of UTF-16. */
static bool unicode_escape(struct json_reader *r, GString *out)
{
    unsigned unit, low;
    if (!hex4(r, &unit) || unit == 0 || (unit >= 0xdc00 && unit < 0xe000)) {
        return false;
    }
    if (unit >= 0xd800 && unit < 0xdc00) {
        if (r->end - r->at < 2 || r->at[0] != '\\' || r->at[1] != 'u') {
            return false;
        }
        r->at += 2;
        if (!hex4(r, &low) || low < 0xdc00 || low >= 0xe000) {
            return false;
        }
        unit = 0x10000 + ((unit - 0xd800) << 10) + (low - 0xdc00);
    }
    g_string_append_unichar(out, unit);
    return true;
}

static bool escape(struct json_reader *r, GString *out)
{
    static const char names[] = "\"\\/bfnrt";
    static const char values[] = "\"\\/\b\f\n\r\t";
    if (r->at == r->end) {
        return false;
    }
    char c = *r->at++;
    if (c == 'u') {
        return unicode_escape(r, out);
    }
    const char *found = c ? strchr(names, c) : NULL;
    if (found) {
        g_string_append_c(out, values[found - names]);
    }
    return found != NULL;
}

enum pel_err json_string(struct json_reader *r, char **out, size_t *length)
{
    GString *text = g_string_new(NULL);
    const char *what = NULL;
    r->at++;
    while (!what) {
        const char *run = r->at;
        while (r->at < r->end && *r->at != '"' && *r->at != '\\' &&
               (unsigned char)*r->at >= 0x20) {
            r->at++;
        }
        g_string_append_len(text, run, r->at - run);
        if (r->at == r->end) {
            what = "a string without end";
        } else if (*r->at == '"') {
            r->at++;
            break;
        } else if (*r->at != '\\') {
            what = "a control character in a string";
        } else if (r->at++, !escape(r, text)) {
            what = "a bad \\ escape";
        }
    }
    if (!what && !g_utf8_validate_len(text->str, text->len, NULL)) {
        what = "a string that is not UTF-8";
    }
    if (what) {
        g_string_free(text, TRUE);
        return malformed(r, what);
    }
    *length = text->len;
    *out = g_string_free(text, FALSE);
    return PEL_OK;
}

enum pel_err json_name(struct json_reader *r, char **out, size_t *length)
{
    if (json_peek(r) != JSON_STRING) {
        return malformed(r, "expected a name in quotes");
    }
    enum pel_err err = json_string(r, out, length);
    if (err) {
        return err;
    }
    skip_space(r);
    if (r->at == r->end || *r->at != ':') {
        free(*out);
        *out = NULL;
        return malformed(r, "expected : after a name");
    }
    r->at++;
    return PEL_OK;
}

static bool digits(struct json_reader *r)
{
    const char *start = r->at;
    while (r->at < r->end && g_ascii_isdigit(*r->at)) {
        r->at++;
    }
    return r->at > start;
}

static bool take(struct json_reader *r, char a, char b)
{
    if (r->at < r->end && (*r->at == a || *r->at == b)) {
        r->at++;
        return true;
    }
    return false;
}

static bool number_grammar(struct json_reader *r)
{
    take(r, '-', '-');
    if (!take(r, '0', '0') && !digits(r)) {
        return false;
    }
    if (take(r, '.', '.') && !digits(r)) {
        return false;
    }
    if (take(r, 'e', 'E')) {
        take(r, '+', '-');
        return digits(r);
    }
    return true;
}

enum pel_err json_number_text(struct json_reader *r, char out[JSON_NUMBER_SIZE])
{
    const char *start = r->at;
    if (!number_grammar(r) || r->at - start >= JSON_NUMBER_SIZE) {
        return malformed(r, "a bad number");
    }
    memcpy(out, start, (size_t)(r->at - start));
    out[r->at - start] = '\0';
    return PEL_OK;
}

enum pel_err json_literal(struct json_reader *r, enum json_kind kind)
{
    const char *word = kind == JSON_TRUE    ? "true"
                       : kind == JSON_FALSE ? "false"
                                            : "null";
    size_t length = strlen(word);
    if ((size_t)(r->end - r->at) < length || memcmp(r->at, word, length) != 0) {
        return malformed(r, "expected a value");
    }
    r->at += length;
    return PEL_OK;
}

enum pel_err json_bad(struct json_reader *r)
{
    return malformed(r, r->at == r->end ? "the text ends too early"
                                        : "expected a value");
}
