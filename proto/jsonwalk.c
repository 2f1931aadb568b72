#include "jsonwalk.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "jsonread.h"

struct walk {
    struct json_reader r;
    pel_json_each each;
    void *user;
};

static enum pel_err walk_value(struct walk *w);

static enum pel_err walk_inside(struct walk *w, const char *name, size_t length)
{
    size_t mark = json_push(&w->r, name, length);
    enum pel_err err = walk_value(w);
    if (!err) {
        json_pop(&w->r, mark);
    }
    return err;
}

static enum pel_err walk_object(struct walk *w)
{
    enum pel_err err = json_enter(&w->r);
    bool first = true, more = false;
    while (!err && !(err = json_more(&w->r, '}', &first, &more)) && more) {
        char *name = NULL;
        size_t length = 0;
        err = json_name(&w->r, &name, &length);
        if (!err) {
            err = walk_inside(w, name, length);
        }
        free(name);
    }
    return err;
}

static enum pel_err walk_list(struct walk *w)
{
    enum pel_err err = json_enter(&w->r);
    bool first = true, more = false;
    size_t index = 0;
    while (!err && !(err = json_more(&w->r, ']', &first, &more)) && more) {
        char name[24];
        g_snprintf(name, sizeof name, "%zu", index++);
        err = walk_inside(w, name, strlen(name));
    }
    return err;
}

static enum pel_err walk_string(struct walk *w)
{
    char *text = NULL;
    size_t length;
    enum pel_err err = json_string(&w->r, &text, &length);
    if (!err) {
        w->each(w->user, w->r.path, text);
    }
    free(text);
    return err;
}

static enum pel_err walk_literal(struct walk *w, enum json_kind kind)
{
    const char *word = kind == JSON_TRUE    ? "true"
                       : kind == JSON_FALSE ? "false"
                                            : "null";
    enum pel_err err = json_literal(&w->r, kind);
    if (!err) {
        w->each(w->user, w->r.path, word);
    }
    return err;
}

static enum pel_err walk_number(struct walk *w)
{
    char text[JSON_NUMBER_SIZE];
    enum pel_err err = json_number_text(&w->r, text);
    if (!err) {
        w->each(w->user, w->r.path, text);
    }
    return err;
}

static enum pel_err walk_value(struct walk *w)
{
    enum json_kind kind = json_peek(&w->r);
    switch (kind) {
    case JSON_OBJECT:
        return walk_object(w);
    case JSON_ARRAY:
        return walk_list(w);
    case JSON_STRING:
        return walk_string(w);
    case JSON_NUMBER:
        return walk_number(w);
    case JSON_TRUE:
    case JSON_FALSE:
    case JSON_NULL:
        return walk_literal(w, kind);
    default:
        return json_bad(&w->r);
    }
}

enum pel_err pel_json_walk(const char *text, size_t length, pel_json_each each,
                           void *user, struct pel_fault *fault)
{
    struct walk w = { .each = each, .user = user };
    json_begin(&w.r, text, length, fault);
    enum pel_err err = walk_value(&w);
    return err ? err : json_end(&w.r);
}
