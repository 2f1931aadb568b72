#include "pelagosctl/ctl.h"

#include <string.h>

#include <glib.h>

#include "base/nearest.h"

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
    for (size_t i = 0; i < count; i++) {
        if (is_tail(words[i], text)) {
            return words[i];
        }
    }
    const char *best = pel_nearest(text, words, count);
    for (size_t i = 0; !best && i < count; i++) {
        best = is_head(words[i], text) ? words[i] : NULL;
    }
    return best;
}
