/* Files that are damaged, kept beside where they were. Any thread. */
#pragma once

/* As many of one name are kept; none of them is ever overwritten. */
#define PEL_ASIDE_MOST 99

/* Keeps the file of this path as PATH + suffix, or PATH + suffix + ".2" to
 * ".99" where there are older ones, and gives that name, g_free: NULL where
 * there is no room (see PEL_ASIDE_MOST) or the system refuses. The file stays
 * where it is as well, for who is killed the next moment, until another takes
 * its place; kept twice it has the name of the first time. */
char *pel_aside_keep(const char *path, const char *suffix);
