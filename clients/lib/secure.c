#include "secure.h"

#include <errno.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#define BLOCK 16384

/* Between OpenSSL and the socket are two buffers: so that no write raises
 * SIGPIPE in the caller's program, and that every wait has its deadline. */
struct secure {
    int fd;
    SSL_CTX *context;
    SSL *ssl;
    BIO *in, *out; /* the ssl's */
};

static enum stream_result flush(struct secure *secure, int64_t deadline_ns)
{
    char block[BLOCK];
    for (;;) {
        int n = BIO_read(secure->out, block, sizeof block);
        if (n <= 0) {
            return STREAM_OK;
        }
        for (int sent = 0; sent < n;) {
            ssize_t k = send(secure->fd, block + sent, (size_t)(n - sent),
                             MSG_NOSIGNAL);
            if (k >= 0) {
                sent += (int)k;
            } else if (errno == EAGAIN) {
                enum stream_result result =
                    stream_wait(secure->fd, POLLOUT, deadline_ns);
                if (result != STREAM_OK) {
                    return result;
                }
            } else if (errno != EINTR) {
                return STREAM_CLOSED;
            }
        }
    }
}

static enum stream_result feed(struct secure *secure, int64_t deadline_ns)
{
    char block[BLOCK];
    for (;;) {
        ssize_t n = recv(secure->fd, block, sizeof block, 0);
        if (n > 0) {
            return BIO_write(secure->in, block, (int)n) == n ? STREAM_OK
                                                             : STREAM_CLOSED;
        }
        if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
            return STREAM_CLOSED;
        }
        enum stream_result result =
            stream_wait(secure->fd, POLLIN, deadline_ns);
        if (result != STREAM_OK) {
            return result;
        }
    }
}

/* Gives OpenSSL what it waits for after a call returned `status` <= 0. */
static enum stream_result go_on(struct secure *secure, int status,
                                int64_t deadline_ns)
{
    int error = SSL_get_error(secure->ssl, status);
    enum stream_result result = flush(secure, deadline_ns);
    if (result != STREAM_OK || error == SSL_ERROR_WANT_WRITE) {
        return result;
    }
    return error == SSL_ERROR_WANT_READ ? feed(secure, deadline_ns)
                                        : STREAM_CLOSED;
}

static int prepare(struct secure *secure, const char *host)
{
    const char *file = getenv(SECURE_CA_VARIABLE);
    secure->context = SSL_CTX_new(TLS_client_method());
    if (!secure->context ||
        SSL_CTX_set_min_proto_version(secure->context, TLS1_2_VERSION) != 1 ||
        (file && *file
             ? SSL_CTX_load_verify_file(secure->context, file)
             : SSL_CTX_set_default_verify_paths(secure->context)) != 1) {
        return -1;
    }
    SSL_CTX_set_verify(secure->context, SSL_VERIFY_PEER, NULL);
    secure->ssl = SSL_new(secure->context);
    secure->in = BIO_new(BIO_s_mem());
    secure->out = BIO_new(BIO_s_mem());
    if (!secure->ssl || !secure->in || !secure->out) {
        BIO_free(secure->in);
        BIO_free(secure->out);
        return -1;
    }
    SSL_set_bio(secure->ssl, secure->in, secure->out);
    X509_VERIFY_PARAM *wanted = SSL_get0_param(secure->ssl);
    if (X509_VERIFY_PARAM_set1_ip_asc(wanted, host) == 1) {
        return 0;
    }
    return SSL_set_tlsext_host_name(secure->ssl, host) == 1 &&
                   SSL_set1_host(secure->ssl, host) == 1
               ? 0
               : -1;
}

static void explain(const struct secure *secure, char *why, size_t size)
{
    long verified =
        secure->ssl ? SSL_get_verify_result(secure->ssl) : X509_V_OK;
    unsigned long code = ERR_peek_last_error();
    const char *reason = code ? ERR_reason_error_string(code) : NULL;
    if (verified != X509_V_OK) {
        reason = X509_verify_cert_error_string(verified);
    }
    bool own = verified == X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT ||
               verified == X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN ||
               verified == X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY ||
               verified == X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE;
    snprintf(why, size, "no TLS: %s%s", reason ? reason : "it hung up",
             own ? "; " SECURE_CA_VARIABLE "=FILE names its certificate (PEM) "
                   "to trust it"
                 : "");
}

enum stream_result secure_open(int fd, const char *host, int64_t deadline_ns,
                               struct secure **out, char *why, size_t why_size)
{
    struct secure *secure = calloc(1, sizeof *secure);
    if (!secure) {
        snprintf(why, why_size, "out of memory");
        return STREAM_CLOSED;
    }
    secure->fd = fd;
    ERR_clear_error();
    enum stream_result result =
        prepare(secure, host) == 0 ? STREAM_OK : STREAM_CLOSED;
    int status = 0;
    while (result == STREAM_OK && (status = SSL_connect(secure->ssl)) != 1) {
        result = go_on(secure, status, deadline_ns);
    }
    if (result == STREAM_OK) {
        result = flush(secure, deadline_ns);
    }
    if (result != STREAM_OK) {
        if (result == STREAM_TIMEOUT) {
            snprintf(why, why_size, "no TLS in time");
        } else {
            explain(secure, why, why_size);
        }
        secure_close(secure);
        return result;
    }
    *out = secure;
    return STREAM_OK;
}

void secure_close(struct secure *secure)
{
    if (secure) {
        SSL_free(secure->ssl);
        SSL_CTX_free(secure->context);
        free(secure);
    }
}

enum stream_result secure_send(struct secure *secure, const void *data,
                               size_t size, int64_t deadline_ns)
{
    const char *bytes = data;
    enum stream_result result = STREAM_OK;
    for (size_t sent = 0; sent < size && result == STREAM_OK;) {
        size_t left = size - sent, n = 0;
        ERR_clear_error();
        int status = SSL_write_ex(secure->ssl, bytes + sent,
                                  left < BLOCK ? left : BLOCK, &n);
        sent += status == 1 ? n : 0;
        result = status == 1 ? flush(secure, deadline_ns)
                             : go_on(secure, status, deadline_ns);
    }
    return result;
}

enum stream_result secure_receive(struct secure *secure, void *data,
                                  size_t size, int64_t deadline_ns, size_t *got)
{
    for (;;) {
        ERR_clear_error();
        int status = SSL_read_ex(secure->ssl, data, size, got);
        if (status == 1) {
            return STREAM_OK;
        }
        enum stream_result result = go_on(secure, status, deadline_ns);
        if (result != STREAM_OK) {
            return result;
        }
    }
}
