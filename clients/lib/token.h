/* The token that a caller has in the environment. Private to libpelagos. */
#pragma once

#include <stddef.h>

#define CLIENT_TOKEN_MAX 128

/* $PELAGOS_TOKEN, else the line in the file $PELAGOS_TOKEN_FILE; out[0] is 0
 * where there is neither. Returns 0, or -1 where the file has no token: `why`
 * says so. */
int client_token(char out[CLIENT_TOKEN_MAX + 1], char *why, size_t why_size);
