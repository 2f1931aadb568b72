/* Files of the page, embedded by clients/web/embed.py. */
#pragma once

#include <stddef.h>

struct pel_page {
    const char *path; /* "/", "/style.css" */
    const char *type;
    const char *tag; /* entity tag of the content, with quotes */
    const unsigned char *data;
    size_t size;
};

extern const struct pel_page pel_pages[];
extern const size_t pel_page_count;

/* The text of pelagos.proto. */
extern const struct pel_page pel_schema_page;
