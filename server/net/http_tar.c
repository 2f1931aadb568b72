/* The files of a spectrum in one: a tar of POSIX 1003.1-1988 (ustar). */
#include <string.h>

#include "net/http_client.h"

#define BLOCK 512

struct header { /* all text, octal numbers */
    char name[100], mode[8], uid[8], gid[8], size[12], mtime[12], sum[8];
    char type, link[100], magic[6], version[2], user[32], group[32];
    char major[8], minor[8], prefix[155], rest[12];
};
_Static_assert(sizeof(struct header) == BLOCK, "a tar's header is a block");

static void append(GByteArray *out, const Pelagos__SpectrumFile *file)
{
    static const guint8 nothing[BLOCK];
    struct header h;
    memset(&h, 0, sizeof h);
    g_strlcpy(h.name, file->name, sizeof h.name);
    g_snprintf(h.mode, sizeof h.mode, "0000644");
    g_snprintf(h.uid, sizeof h.uid, "0000000");
    g_snprintf(h.gid, sizeof h.gid, "0000000");
    g_snprintf(h.size, sizeof h.size, "%011zo", file->content.len);
    g_snprintf(h.mtime, sizeof h.mtime, "00000000000");
    memset(h.sum, ' ', sizeof h.sum);
    h.type = '0';
    memcpy(h.magic, "ustar", 6);
    memcpy(h.version, "00", 2);
    unsigned sum = 0;
    for (size_t i = 0; i < sizeof h; i++) {
        sum += ((const unsigned char *)&h)[i];
    }
    g_snprintf(h.sum, sizeof h.sum, "%06o", sum);
    g_byte_array_append(out, (const guint8 *)&h, sizeof h);
    g_byte_array_append(out, file->content.data, (guint)file->content.len);
    g_byte_array_append(out, nothing,
                        (BLOCK - file->content.len % BLOCK) % BLOCK);
}

char *pel_http_tar(const Pelagos__Spectrum *spectrum, size_t *size)
{
    static const guint8 end[2 * BLOCK];
    GByteArray *out = g_byte_array_new();
    for (size_t i = 0; i < spectrum->n_files; i++) {
        append(out, spectrum->files[i]);
    }
    g_byte_array_append(out, end, sizeof end);
    *size = out->len;
    return (char *)g_byte_array_free(out, FALSE);
}
