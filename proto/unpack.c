#include "unpack.h"

#include <stdalign.h>
#include <stddef.h>
#include <stdlib.h>

struct pel_unpack_more {
    struct pel_unpack_more *next;
    alignas(max_align_t) uint8_t bytes[];
};

static void *take(void *data, size_t size)
{
    struct pel_unpack *unpack = data;
    size_t align = alignof(max_align_t);
    size_t whole = (size + align - 1) / align * align;
    if (!unpack->block) {
        unpack->block = malloc(PEL_UNPACK_BLOCK);
    }
    if (unpack->block && whole >= size &&
        whole <= PEL_UNPACK_BLOCK - unpack->used) {
        void *at = unpack->block + unpack->used;
        unpack->used += whole;
        return at;
    }
    struct pel_unpack_more *more =
        size < SIZE_MAX - sizeof *more ? malloc(sizeof *more + size) : NULL;
    if (!more) {
        return NULL;
    }
    more->next = unpack->more;
    unpack->more = more;
    return more->bytes;
}

static void keep(void *data, void *pointer)
{
    (void)data;
    (void)pointer;
}

void pel_unpack_init(struct pel_unpack *unpack)
{
    *unpack = (struct pel_unpack){ .allocator = { take, keep, unpack } };
}

void pel_unpack_reset(struct pel_unpack *unpack)
{
    while (unpack->more) {
        struct pel_unpack_more *next = unpack->more->next;
        free(unpack->more);
        unpack->more = next;
    }
    unpack->used = 0;
}

void pel_unpack_finish(struct pel_unpack *unpack)
{
    pel_unpack_reset(unpack);
    free(unpack->block);
    unpack->block = NULL;
}
