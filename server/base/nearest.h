/* The word that was meant by a mistyped one. Any thread. */
#pragma once

#include <stddef.h>

/* The nearest of the words to `text`, ASCII, without regard to case: by
 * insertions, deletions, replacements and swaps of neighbours, at most about a
 * third of its last word's letters (after a dot). NULL: none is near. */
const char *pel_nearest(const char *text, const char *const *words,
                        size_t count);
