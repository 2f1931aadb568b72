/* The tokens that clients must give where pelagosd --token-file names one: over
 * HTTP in the Authorization header, over protobuf by Login, over RTSP as
 * password. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "base/share.h"
#include "net/roles.h"

/* 16 to 128 of A-Z a-z 0-9 - . _ ~ +, what every protocol here carries as it
 * is. */
#define PEL_TOKEN_MIN 16
#define PEL_TOKEN_MAX 128
#define PEL_TOKENS_MAX 64     /* lines of a file */
#define PEL_TOKEN_NAME_MAX 32 /* of who has it, for people */

struct pel_token;

/* Reads the tokens: a line each, `TOKEN ROLE [NAME]`, or as the only line a
 * TOKEN, whose holder instructs; empty lines and those that begin with # are
 * passed over. Errors: as of pel_file_open, CONFLICT
 * (others than its owner and group may read it, others than its owner change
 * it, or it belongs to someone else than us or root), INVALID (no token; the
 * line at fault). */
PEL_CHECK enum pel_err pel_token_create(const char *path,
                                        struct pel_token **out,
                                        struct pel_fault *fault);
void pel_token_destroy(struct pel_token *token); /* NULL allowed */

/* Reads the file again; on an error, as above, the old tokens stay. */
PEL_CHECK enum pel_err pel_token_reload(struct pel_token *token,
                                        struct pel_fault *fault);

/* The holder of the token with these bytes; NOBODY: there is no such token. The
 * time taken does not depend on where the bytes differ. */
struct pel_who pel_token_who(struct pel_token *token, const char *text,
                             size_t size);

/* The same for the value of an Authorization header: `Bearer TOKEN`, or
 * `Basic …` with the token as password and any user (RFC 6750, 7617). */
struct pel_who pel_token_authorizes(struct pel_token *token, const char *value);

/* False: the file has lost that token, or gives it a lower role. True for a
 * client without a token. */
bool pel_token_holds(struct pel_token *token, const struct pel_who *who);

/* The permissions that pel_token_create asks for, of an open file. */
PEL_CHECK enum pel_err pel_token_check_file(int fd, const char *path,
                                            struct pel_fault *fault);
