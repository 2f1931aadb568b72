/* Text from elsewhere, before it is shown: in an answer, a log, a terminal.
 * Pure: any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Makes `text` valid UTF-8 without control characters (C0, C1, DEL), in place
 * and no longer than it was: tabs and ends of lines become spaces, every other
 * control character and every byte that belongs to no character becomes '?'; so
 * does half a character at the end, cut off by a buffer. */
void pel_text_clean(char *text);

/* The same, but tabs and ends of lines stay. */
void pel_text_clean_lines(char *text);
