#include "pelagosctl/ctl.h"

#include <string.h>

#include <glib.h>

#define MAX_WORD 127

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
            char x = g_ascii_tolower(a[i - 1]), y = g_ascii_tolower(b[j - 1]);
            size_t best = least(above[j], row[j - 1]) + 1;
            best = least(best, above[j - 1] + (x != y));
            if (i > 1 && j > 1 && x == g_ascii_tolower(b[j - 2]) &&
                y == g_ascii_tolower(a[i - 2])) {
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

/* Whether `word` ends in ".text": `windSpeed` was meant to be sea.windSpeed. */
static bool is_tail(const char *word, const char *text)
{
    size_t m = strlen(word), n = strlen(text);
    return n > 0 && m > n + 1 && word[m - n - 1] == '.' &&
           g_ascii_strcasecmp(word + m - n, text) == 0;
}

/* Whether `word` goes on where `text` stops: `sea.wind` for sea.windSpeed. */
static bool is_head(const char *word, const char *text)
{
    size_t n = strlen(text);
    return n > 2 && g_ascii_strncasecmp(word, text, n) == 0;
}

const char *ctl_nearest(const char *text, const char *const *words,
                        size_t count)
{
    const char *best = NULL;
    /* A third of the last word's letters wrong is still a typing error. */
    const char *dot = strrchr(text, '.');
    size_t best_distance = strlen(dot ? dot + 1 : text) / 3 + 2;
    for (size_t i = 0; i < count; i++) {
        if (is_tail(words[i], text)) {
            return words[i];
        }
        size_t d = distance(text, words[i]);
        if (d < best_distance) {
            best = words[i];
            best_distance = d;
        }
    }
    for (size_t i = 0; !best && i < count; i++) {
        best = is_head(words[i], text) ? words[i] : NULL;
    }
    return best;
}
