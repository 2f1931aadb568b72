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

struct pel_token {
    char *path;
    pthread_mutex_t lock; /* of the two below: RTSP's threads read them */
    char text[PEL_TOKEN_MAX + 1];
    size_t size;
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

static enum pel_err read_token(const char *path, char out[PEL_TOKEN_MAX + 1],
                               size_t *size, struct pel_fault *fault)
{
    char text[PEL_TOKEN_MAX + 3]; /* and CR LF, and one too many */
    int fd;
    enum pel_err err = pel_file_open(path, &fd, fault);
    if (err != PEL_OK) {
        return err;
    }
    err = pel_token_check_file(fd, path, fault);
    ssize_t n = err == PEL_OK ? read(fd, text, sizeof text) : 0;
    close(fd);
    if (err != PEL_OK) {
        return err;
    }
    while (n > 0 && (text[n - 1] == '\n' || text[n - 1] == '\r')) {
        n--;
    }
    if (n < PEL_TOKEN_MIN || n > PEL_TOKEN_MAX) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s must have one line of %d to %d characters; "
                             "`openssl rand -hex 32` makes one",
                             path, PEL_TOKEN_MIN, PEL_TOKEN_MAX);
    }
    memcpy(out, text, (size_t)n);
    out[n] = '\0';
    if (strlen(out) != (size_t)n || strspn(out, ALPHABET) != (size_t)n) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s may hold only letters, digits and - . _ ~ +; "
                             "`openssl rand -hex 32` makes a token",
                             path);
    }
    *size = (size_t)n;
    return PEL_OK;
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

enum pel_err pel_token_reload(struct pel_token *token, struct pel_fault *fault)
{
    char text[PEL_TOKEN_MAX + 1];
    size_t size = 0;
    enum pel_err err = read_token(token->path, text, &size, fault);
    if (err == PEL_OK) {
        pthread_mutex_lock(&token->lock);
        memcpy(token->text, text, size + 1);
        token->size = size;
        pthread_mutex_unlock(&token->lock);
    }
    explicit_bzero(text, sizeof text);
    return err;
}

bool pel_token_is(struct pel_token *token, const char *text, size_t size)
{
    pthread_mutex_lock(&token->lock);
    /* As many steps whatever was sent; one that is too long or too short
     * differs in its size. */
    volatile uint8_t different = size != token->size;
    for (size_t i = 0; i < PEL_TOKEN_MAX; i++) {
        uint8_t mine = i < token->size ? (uint8_t)token->text[i] : 0;
        uint8_t theirs = i < size ? (uint8_t)text[i] : 0;
        different = different | (mine ^ theirs);
    }
    pthread_mutex_unlock(&token->lock);
    return different == 0;
}

bool pel_token_authorizes(struct pel_token *token, const char *value)
{
    if (strncasecmp(value, "Bearer ", 7) == 0) {
        value += 7;
        value += strspn(value, " ");
        return pel_token_is(token, value, strlen(value));
    }
    if (strncasecmp(value, "Basic ", 6) != 0 || strlen(value) > 1024) {
        return false;
    }
    gsize size = 0;
    guchar *pair = g_base64_decode(value + 6, &size);
    const guchar *colon = size > 0 ? memchr(pair, ':', size) : NULL;
    bool good = colon && pel_token_is(token, (const char *)colon + 1,
                                      size - (size_t)(colon + 1 - pair));
    g_free(pair);
    return good;
}
