/* The token that clients must give where pelagosd --token-file names one: over
 * HTTP in the Authorization header, over protobuf by Login, over RTSP as
 * password. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

/* 16 to 128 of A-Z a-z 0-9 - . _ ~ +, what every protocol here carries as it
 * is. */
#define PEL_TOKEN_MIN 16
#define PEL_TOKEN_MAX 128

struct pel_token;

/* Reads the token: the file's only line. Errors: as of pel_file_open, CONFLICT
 * (others than its owner and group may read it, others than its owner change
 * it, or it belongs to someone else than us or root), INVALID (no token). */
PEL_CHECK enum pel_err pel_token_create(const char *path,
                                        struct pel_token **out,
                                        struct pel_fault *fault);
void pel_token_destroy(struct pel_token *token); /* NULL allowed */

/* Reads the file again; on an error, as above, the old token stays. */
PEL_CHECK enum pel_err pel_token_reload(struct pel_token *token,
                                        struct pel_fault *fault);

/* Whether these bytes are the token, in a time that does not depend on where
 * they differ. */
bool pel_token_is(struct pel_token *token, const char *text, size_t size);

/* The same for the value of an Authorization header: `Bearer TOKEN`, or
 * `Basic …` with the token as password and any user (RFC 6750, 7617). */
bool pel_token_authorizes(struct pel_token *token, const char *value);

/* The permissions that pel_token_create asks for, of an open file. */
PEL_CHECK enum pel_err pel_token_check_file(int fd, const char *path,
                                            struct pel_fault *fault);
