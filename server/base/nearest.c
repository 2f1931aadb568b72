#include "base/nearest.h"

#include <string.h>
#include <strings.h>

#define MAX_WORD 127

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c | 0x20) : c;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Insertions, deletions, replacements and swaps of neighbours that turn a into
 * b (optimal string alignment), without regard to case. */
static size_t distance(const char *a, const char *b)
{
    size_t m = strnlen(a, MAX_WORD), n = strnlen(b, MAX_WORD);
    size_t rows[3][MAX_WORD + 1];
    size_t *before = rows[0], *above = rows[1], *row = rows[2];
    for (size_t j = 0; j <= n; j++) {
        above[j] = j;
    }
    for (size_t i = 1; i <= m; i++) {
        row[0] = i;
        for (size_t j = 1; j <= n; j++) {
            char x = lower(a[i - 1]), y = lower(b[j - 1]);
            size_t best = least(above[j], row[j - 1]) + 1;
            best = least(best, above[j - 1] + (x != y));
            if (i > 1 && j > 1 && x == lower(b[j - 2]) &&
                y == lower(a[i - 2])) {
                best = least(best, before[j - 2] + 1);
            }
            row[j] = best;
        }
        size_t *oldest = before;
        before = above;
        above = row;
        row = oldest;
    }
    return above[n];
}

const char *pel_nearest(const char *text, const char *const *words,
                        size_t count)
{
    const char *best = NULL;
    /* A third of the last word's letters wrong is still a typing error. */
    const char *dot = strrchr(text, '.');
    size_t best_distance = strlen(dot ? dot + 1 : text) / 3 + 2;
    for (size_t i = 0; i < count; i++) {
        size_t d = distance(text, words[i]);
        if (d < best_distance) {
            best = words[i];
            best_distance = d;
        }
    }
    return best;
}
