#include "net/token.h"

#include <errno.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include <glib.h>

#include "base/file.h"

#define ALPHABET                                                               \
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~+"

#define MOST_BYTES 16384

struct entry {
    char text[PEL_TOKEN_MAX + 1];
    size_t size;
    enum pel_role role;
    uint32_t id; /* never that of another text, or of a higher role */
};

struct entries {
    struct entry list[PEL_TOKENS_MAX];
    size_t count;
};

struct pel_token {
    char *path;
    pthread_mutex_t lock; /* of what follows: RTSP's threads read it */
    struct entries entries;
    uint32_t last_id;
};

enum pel_err pel_token_check_file(int fd, const char *path,
                                  struct pel_fault *fault)
{
    struct stat info;
    if (fstat(fd, &info) != 0) {
        return pel_fault_set(fault, PEL_ERR_IO, "cannot read %s: %s", path,
                             strerror(errno));
    }
    if (info.st_uid != geteuid() && info.st_uid != 0) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "%s belongs to user %u, who is neither the "
                             "daemon's nor root",
                             path, (unsigned)info.st_uid);
    }
    if (info.st_mode & (S_IWGRP | S_IRWXO)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "%s has mode %03o: others could use it; "
                             "chmod 600 it",
                             path, (unsigned)info.st_mode & 0777);
    }
    return PEL_OK;
}

static enum pel_err bad_line(const char *path, size_t line, const char *what,
                             struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "%.120s, line %zu: %s; `openssl rand -hex 32` makes a "
                         "token",
                         path, line, what);
}

/* One line, which is changed; `alone`: the file has no other. */
static enum pel_err read_line(const char *path, size_t line, char *text,
                              bool alone, struct entries *out,
                              struct pel_fault *fault)
{
    char *after = NULL;
    size_t length = strlen(text);
    if (g_ascii_isspace(text[length - 1]) || g_ascii_isspace(*text)) {
        return bad_line(path, line, "it begins or ends with a blank", fault);
    }
    const char *token = strtok_r(text, " \t", &after);
    const char *role = strtok_r(NULL, " \t", &after);
    const char *name = strtok_r(NULL, " \t", &after);
    const char *more = strtok_r(NULL, " \t", &after);
    size_t size = token ? strlen(token) : 0;
    if (size < PEL_TOKEN_MIN || size > PEL_TOKEN_MAX) {
        return bad_line(path, line, "a token has 16 to 128 characters", fault);
    }
    if (strspn(token, ALPHABET) != size) {
        return bad_line(path, line,
                        "a token may hold only letters, digits and - . _ ~ +",
                        fault);
    }
    enum pel_role may = role    ? pel_role_by_name(role)
                        : alone ? PEL_ROLE_INSTRUCT
                                : PEL_ROLE_NONE;
    if (may == PEL_ROLE_NONE) {
        return bad_line(path, line,
                        "after the token comes its role: watch, steer or "
                        "instruct",
                        fault);
    }
    if (more || (name && strlen(name) > PEL_TOKEN_NAME_MAX)) {
        return bad_line(path, line,
                        "after the role comes a name of at most 32 characters "
                        "or nothing",
                        fault);
    }
    for (size_t i = 0; i < out->count; i++) {
        if (strcmp(out->list[i].text, token) == 0) {
            return bad_line(path, line, "the token stands there twice", fault);
        }
    }
    if (out->count == PEL_TOKENS_MAX) {
        return bad_line(path, line, "there are more than 64 tokens", fault);
    }
    struct entry *entry = &out->list[out->count++];
    memcpy(entry->text, token, size + 1);
    entry->size = size;
    entry->role = may;
    entry->id = 0;
    return PEL_OK;
}

static bool has_token(const char *line)
{
    line += strspn(line, " \t");
    return *line && *line != '#';
}

static enum pel_err read_lines(const char *path, char *text,
                               struct entries *out, struct pel_fault *fault)
{
    size_t tokens = 0, line = 1;
    enum pel_err err = PEL_OK;
    char **lines = g_strsplit(text, "\n", -1);
    for (char **at = lines; *at; at++) {
        size_t length = strlen(*at);
        if (length > 0 && (*at)[length - 1] == '\r') {
            (*at)[length - 1] = '\0';
        }
        tokens += has_token(*at);
    }
    for (char **at = lines; *at && !err; at++, line++) {
        if (has_token(*at)) {
            err = read_line(path, line, *at, tokens == 1, out, fault);
        }
    }
    for (char **at = lines; *at; at++) {
        explicit_bzero(*at, strlen(*at));
    }
    g_strfreev(lines);
    return err || out->count > 0
               ? err
               : pel_fault_set(fault, PEL_ERR_INVALID,
                               "%.160s must have a line of %d to %d "
                               "characters; `openssl rand -hex 32` makes one",
                               path, PEL_TOKEN_MIN, PEL_TOKEN_MAX);
}

static enum pel_err read_tokens(const char *path, struct entries *out,
                                struct pel_fault *fault)
{
    char text[MOST_BYTES + 1];
    int fd;
    out->count = 0;
    enum pel_err err = pel_file_open(path, &fd, fault);
    if (err != PEL_OK) {
        return err;
    }
    err = pel_token_check_file(fd, path, fault);
    ssize_t n = err == PEL_OK ? read(fd, text, sizeof text) : 0;
    close(fd);
    if (!err && (n < 0 || n > MOST_BYTES)) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "%.160s is longer than 16 KiB: it is no file of "
                            "tokens; `openssl rand -hex 32` makes one",
                            path);
    } else if (!err && memchr(text, '\0', (size_t)n)) {
        err = bad_line(path, 1, "there is a NUL", fault);
    } else if (!err) {
        char *whole = g_strndup(text, (size_t)n);
        err = read_lines(path, whole, out, fault);
        explicit_bzero(whole, (size_t)n);
        g_free(whole);
    }
    explicit_bzero(text, sizeof text);
    return err;
}

enum pel_err pel_token_create(const char *path, struct pel_token **out,
                              struct pel_fault *fault)
{
    struct pel_token *token = g_new0(struct pel_token, 1);
    token->path = g_strdup(path);
    pthread_mutex_init(&token->lock, NULL);
    enum pel_err err = pel_token_reload(token, fault);
    if (err != PEL_OK) {
        pel_token_destroy(token);
        return err;
    }
    *out = token;
    return PEL_OK;
}

void pel_token_destroy(struct pel_token *token)
{
    if (token) {
        pthread_mutex_destroy(&token->lock);
        g_free(token->path);
        explicit_bzero(token, sizeof *token);
        g_free(token);
    }
}

/* Those that go on keep their numbers. */
static void number(struct pel_token *token, struct entries *fresh)
{
    for (size_t i = 0; i < fresh->count; i++) {
        struct entry *entry = &fresh->list[i];
        for (size_t k = 0; k < token->entries.count; k++) {
            const struct entry *old = &token->entries.list[k];
            bool same =
                old->role <= entry->role && strcmp(old->text, entry->text) == 0;
            entry->id = same ? old->id : entry->id;
        }
        if (entry->id == 0) {
            entry->id = ++token->last_id;
        }
    }
}

enum pel_err pel_token_reload(struct pel_token *token, struct pel_fault *fault)
{
    struct entries fresh;
    enum pel_err err = read_tokens(token->path, &fresh, fault);
    if (err == PEL_OK) {
        pthread_mutex_lock(&token->lock);
        number(token, &fresh);
        token->entries = fresh;
        pthread_mutex_unlock(&token->lock);
    }
    explicit_bzero(&fresh, sizeof fresh);
    return err;
}

/* As many steps whatever was sent; one that is too long or too short differs in
 * its size. */
static bool is_entry(const struct entry *entry, const char *text, size_t size)
{
    volatile uint8_t different = size != entry->size;
    for (size_t i = 0; i < PEL_TOKEN_MAX; i++) {
        uint8_t mine = i < entry->size ? (uint8_t)entry->text[i] : 0;
        uint8_t theirs = i < size ? (uint8_t)text[i] : 0;
        different = different | (mine ^ theirs);
    }
    return different == 0;
}

struct pel_who pel_token_who(struct pel_token *token, const char *text,
                             size_t size)
{
    struct pel_who who = { PEL_RANK_NOBODY, 0 };
    pthread_mutex_lock(&token->lock);
    for (size_t i = 0; i < token->entries.count; i++) {
        const struct entry *entry = &token->entries.list[i];
        if (is_entry(entry, text, size)) {
            who = (struct pel_who){ pel_rank_of_role(entry->role), entry->id };
        }
    }
    pthread_mutex_unlock(&token->lock);
    return who;
}

bool pel_token_holds(struct pel_token *token, const struct pel_who *who)
{
    bool holds = who->token == 0;
    pthread_mutex_lock(&token->lock);
    for (size_t i = 0; i < token->entries.count; i++) {
        holds = holds || token->entries.list[i].id == who->token;
    }
    pthread_mutex_unlock(&token->lock);
    return holds;
}

struct pel_who pel_token_authorizes(struct pel_token *token, const char *value)
{
    struct pel_who who = { PEL_RANK_NOBODY, 0 };
    if (strncasecmp(value, "Bearer ", 7) == 0) {
        value += 7;
        value += strspn(value, " ");
        return pel_token_who(token, value, strlen(value));
    }
    if (strncasecmp(value, "Basic ", 6) != 0 || strlen(value) > 1024) {
        return who;
    }
    gsize size = 0;
    guchar *pair = g_base64_decode(value + 6, &size);
    const guchar *colon = size > 0 ? memchr(pair, ':', size) : NULL;
    if (colon) {
        who = pel_token_who(token, (const char *)colon + 1,
                            size - (size_t)(colon + 1 - pair));
    }
    g_free(pair);
    return who;
}
