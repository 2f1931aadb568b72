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

/* What says how to speak to the daemon: pelagos.proto, the OpenAPI document. */
extern const struct pel_page pel_documents[];
extern const size_t pel_document_count;
