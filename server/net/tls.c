#include "net/tls.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <glib.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "net/fdsource.h"
#include "net/token.h"

#define MOST_PEM (1 << 20) /* bytes of a certificate with its chain */
#define BLOCK 16384        /* a TLS record */
#define PAIRING_US 1000    /* where strangers fill the queue of a pair */
#define ROUNDS_A_TURN 16   /* of BLOCK bytes, then the others have theirs */

struct pel_tls {
    char *cert_path, *key_path;
    SSL_CTX *context;
    GPtrArray *pumps; /* of struct pump */
};

struct block {
    uint8_t data[BLOCK];
    size_t start, end;
    bool over; /* nothing more comes after it */
};

/* One connection: bytes between the client's TLS and our plain socket. */
struct pump {
    struct pel_tls *tls;
    SSL *ssl;
    int fd, plain;
    struct pel_fdsource *fd_source, *plain_source;
    struct block in, out;         /* from the client, to the client */
    bool wants_read, wants_write; /* what OpenSSL waits for */
    int64_t handshake_end_ns, progress_ns, stall_ns;
    pel_tls_ready ready; /* NULL: told, or nobody is */
    void *user;
    int ours; /* kept for it */
};

/* --- certificates --------------------------------------------------------- */

static enum pel_err check_key(const char *path, struct pel_fault *fault)
{
    int fd;
    enum pel_err err = pel_file_open(path, &fd, fault);
    if (err == PEL_OK) {
        err = pel_token_check_file(fd, path, fault);
        close(fd);
    }
    return err;
}

/* A passphrase: nobody is there to ask. */
static int no_passphrase(char *out, int size, int writing, void *user)
{
    (void)out;
    (void)size;
    (void)writing;
    (void)user;
    return -1;
}

/* The first certificate is ours, the rest lead up from it. */
static bool use_chain(SSL_CTX *context, BIO *text)
{
    X509 *own = PEM_read_bio_X509_AUX(text, NULL, no_passphrase, NULL);
    bool good = own && SSL_CTX_use_certificate(context, own) == 1;
    X509_free(own);
    X509 *next = NULL;
    while (good &&
           (next = PEM_read_bio_X509(text, NULL, no_passphrase, NULL))) {
        good = SSL_CTX_add0_chain_cert(context, next) == 1;
        if (!good) {
            X509_free(next);
        }
    }
    if (good && ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE) {
        ERR_clear_error(); /* the end of the file */
    }
    return good && ERR_peek_last_error() == 0;
}

static bool use_key(SSL_CTX *context, BIO *text)
{
    EVP_PKEY *key = PEM_read_bio_PrivateKey(text, NULL, no_passphrase, NULL);
    bool good = key && SSL_CTX_use_PrivateKey(context, key) == 1;
    EVP_PKEY_free(key);
    return good;
}

static SSL_CTX *make_context(BIO *chain, BIO *key)
{
    SSL_CTX *context = SSL_CTX_new(TLS_server_method());
    if (!context) {
        return NULL;
    }
    SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION |
                                     SSL_OP_NO_COMPRESSION |
                                     SSL_OP_IGNORE_UNEXPECTED_EOF);
    SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE |
                                  SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                  SSL_MODE_RELEASE_BUFFERS);
    if (!use_chain(context, chain) || !use_key(context, key) ||
        SSL_CTX_check_private_key(context) != 1) {
        SSL_CTX_free(context);
        return NULL;
    }
    return context;
}

static enum pel_err load(struct pel_tls *tls, struct pel_fault *fault)
{
    char *chain_text = NULL, *key_text = NULL;
    size_t chain_size = 0, key_size = 0;
    enum pel_err err = check_key(tls->key_path, fault);
    if (err == PEL_OK) {
        err = pel_file_read(tls->cert_path, MOST_PEM, &chain_text, &chain_size,
                            fault);
    }
    if (err == PEL_OK) {
        err =
            pel_file_read(tls->key_path, MOST_PEM, &key_text, &key_size, fault);
    }
    if (err != PEL_OK) {
        free(chain_text);
        return err;
    }
    ERR_clear_error();
    BIO *chain = BIO_new_mem_buf(chain_text, (int)chain_size);
    BIO *key = BIO_new_mem_buf(key_text, (int)key_size);
    SSL_CTX *context = chain && key ? make_context(chain, key) : NULL;
    BIO_free(chain);
    BIO_free(key);
    free(chain_text);
    explicit_bzero(key_text, key_size);
    free(key_text);
    if (!context) {
        unsigned long code = ERR_peek_last_error();
        const char *why = code ? ERR_reason_error_string(code) : NULL;
        return pel_fault_set(
            fault, PEL_ERR_INVALID, "no certificate from %s and %s: %s",
            tls->cert_path, tls->key_path, why ? why : "unreadable");
    }
    SSL_CTX_free(tls->context);
    tls->context = context;
    return PEL_OK;
}

enum pel_err pel_tls_create(const char *cert_path, const char *key_path,
                            struct pel_tls **out, struct pel_fault *fault)
{
    struct pel_tls *tls = g_new0(struct pel_tls, 1);
    tls->cert_path = g_strdup(cert_path);
    tls->key_path = g_strdup(key_path);
    tls->pumps = g_ptr_array_new();
    enum pel_err err = load(tls, fault);
    if (err != PEL_OK) {
        pel_tls_destroy(tls);
        return err;
    }
    *out = tls;
    return PEL_OK;
}

enum pel_err pel_tls_reload(struct pel_tls *tls, struct pel_fault *fault)
{
    return load(tls, fault);
}

/* --- one connection ------------------------------------------------------- */

static void tell(struct pump *pump, int plain)
{
    pel_tls_ready ready = pump->ready;
    if (ready) {
        pump->ready = NULL;
        ready(pump->user, plain);
    }
}

static void pump_free(struct pump *pump)
{
    if (pump->ready) {
        close(pump->ours);
        tell(pump, -1);
    }
    g_ptr_array_remove_fast(pump->tls->pumps, pump);
    pel_fdsource_destroy(pump->fd_source);
    pel_fdsource_destroy(pump->plain_source);
    SSL_free(pump->ssl);
    close(pump->fd);
    close(pump->plain);
    g_free(pump);
}

static void say_failure(void)
{
    static struct pel_log_limit limit;
    unsigned long code = ERR_peek_error();
    const char *why = code ? ERR_reason_error_string(code) : NULL;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-040",
                    "a TLS handshake failed: %s", why ? why : "it left");
}

/* What a call of OpenSSL that did not succeed waits for; false: the connection
 * is over. */
static bool may_go_on(struct pump *pump, int result)
{
    switch (SSL_get_error(pump->ssl, result)) {
    case SSL_ERROR_WANT_READ:
        pump->wants_read = true;
        return true;
    case SSL_ERROR_WANT_WRITE:
        pump->wants_write = true;
        return true;
    case SSL_ERROR_ZERO_RETURN:
        return false;
    default:
        if (!SSL_is_init_finished(pump->ssl)) {
            say_failure();
        }
        return false;
    }
}

static bool is_empty(const struct block *block)
{
    return block->start == block->end;
}

static void fill(struct block *block, size_t size)
{
    block->start = 0;
    block->end = size;
}

/* True: bytes moved. */
static bool take_in(struct pump *pump)
{
    struct block *in = &pump->in;
    bool moved = false;
    if (is_empty(in) && !in->over) {
        ERR_clear_error();
        int n = SSL_read(pump->ssl, in->data, BLOCK);
        moved = n > 0;
        if (n > 0) {
            fill(in, (size_t)n);
        } else {
            in->over = !may_go_on(pump, n);
        }
    }
    if (!is_empty(in)) {
        ssize_t n = send(pump->plain, in->data + in->start, in->end - in->start,
                         MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n > 0) {
            in->start += (size_t)n;
            moved = true;
        } else if (errno != EAGAIN && errno != EINTR) {
            fill(in, 0); /* nobody reads it: our side has closed */
        }
    }
    return moved;
}

static bool give_out(struct pump *pump)
{
    struct block *out = &pump->out;
    bool moved = false;
    if (is_empty(out) && !out->over) {
        ssize_t n = recv(pump->plain, out->data, BLOCK, MSG_DONTWAIT);
        moved = n > 0;
        if (n > 0) {
            fill(out, (size_t)n);
            pump->progress_ns = pel_now_ns();
        } else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
            out->over = true;
        }
    }
    if (!is_empty(out)) {
        ERR_clear_error();
        int n = SSL_write(pump->ssl, out->data + out->start,
                          (int)(out->end - out->start));
        if (n > 0) {
            out->start += (size_t)n;
            pump->progress_ns = pel_now_ns();
            moved = true;
        } else if (!may_go_on(pump, n)) {
            pump->in.over = true;
            fill(&pump->in, 0);
        }
    }
    return moved;
}

static void plan(struct pump *pump, bool more)
{
    GIOCondition secure =
        (pump->wants_read ? G_IO_IN : 0) | (pump->wants_write ? G_IO_OUT : 0);
    GIOCondition plain =
        (is_empty(&pump->out) && !pump->out.over ? G_IO_IN : 0) |
        (is_empty(&pump->in) ? 0 : G_IO_OUT);
    int64_t wake = -1;
    if (more) {
        wake = 0;
    } else if (!SSL_is_init_finished(pump->ssl)) {
        wake = pump->handshake_end_ns + 1000000;
    } else if (!is_empty(&pump->out)) {
        wake = pump->progress_ns + pump->stall_ns + 1000000;
    }
    pel_fdsource_want(pump->fd_source, secure);
    pel_fdsource_want(pump->plain_source, plain);
    pel_fdsource_wake_at(pump->fd_source, wake);
}

static bool is_late(const struct pump *pump)
{
    int64_t now = pel_now_ns();
    return SSL_is_init_finished(pump->ssl)
               ? !is_empty(&pump->out) &&
                     now > pump->progress_ns + pump->stall_ns
               : now > pump->handshake_end_ns;
}

static void run(void *user, GIOCondition ready)
{
    (void)ready;
    struct pump *pump = user;
    bool more = true;
    for (int i = 0; more && i < ROUNDS_A_TURN; i++) {
        pump->wants_read = pump->wants_write = false;
        more = take_in(pump);
        more = give_out(pump) || more;
    }
    if (SSL_is_init_finished(pump->ssl)) {
        tell(pump, pump->ours);
    }
    bool client_left = pump->in.over && is_empty(&pump->in);
    bool we_left = pump->out.over && is_empty(&pump->out);
    if (we_left && SSL_is_init_finished(pump->ssl) && !pump->in.over) {
        SSL_shutdown(pump->ssl); /* says so; nobody waits for the answer */
    }
    if (client_left || we_left || is_late(pump)) {
        pump_free(pump);
        return;
    }
    plan(pump, more);
}

/* The client has gone while nothing is read from it: the loop would spin. */
static void run_client(void *user, GIOCondition ready)
{
    struct pump *pump = user;
    if (ready & (G_IO_ERR | G_IO_HUP) && !pump->wants_read &&
        !pump->wants_write) {
        pump_free(pump);
        return;
    }
    run(pump, ready);
}

/* --- pairs of sockets ------------------------------------------------------
 */

static bool is_bound_to(int fd, const struct sockaddr_in *address)
{
    struct sockaddr_in own = { 0 };
    socklen_t size = sizeof own;
    return getsockname(fd, (struct sockaddr *)&own, &size) == 0 &&
           own.sin_port == address->sin_port &&
           own.sin_addr.s_addr == address->sin_addr.s_addr;
}

/* One that connects to `listener`; the other end is checked to be its: for a
 * moment anybody on this machine may connect. -1: they are not a pair. */
static int connect_inet(int listener, int *other)
{
    struct sockaddr_in at = { 0 }, from = { 0 };
    socklen_t size = sizeof at, from_size = sizeof from;
    const struct timeval most = { .tv_usec = PAIRING_US };
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    *other = -1;
    if (fd >= 0 &&
        setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &most, sizeof most) == 0 &&
        getsockname(listener, (struct sockaddr *)&at, &size) == 0 &&
        connect(fd, (struct sockaddr *)&at, size) == 0) {
        *other = accept4(listener, (struct sockaddr *)&from, &from_size,
                         SOCK_CLOEXEC | SOCK_NONBLOCK);
    }
    if (*other >= 0 && is_bound_to(fd, &from) &&
        fcntl(fd, F_SETFL, O_NONBLOCK) == 0) {
        return fd;
    }
    if (fd >= 0) {
        close(fd);
    }
    if (*other >= 0) {
        close(*other);
    }
    return -1;
}

static bool pair_inet(int pair[2])
{
    struct sockaddr_in any = { .sin_family = AF_INET };
    int on = 1;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int listener =
        socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (listener < 0) {
        return false;
    }
    bool made = bind(listener, (struct sockaddr *)&any, sizeof any) == 0 &&
                listen(listener, 1) == 0 &&
                (pair[0] = connect_inet(listener, &pair[1])) >= 0;
    close(listener);
    for (int i = 0; made && i < 2; i++) {
        setsockopt(pair[i], IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    }
    return made;
}

static bool pair_unix(int pair[2])
{
    return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0,
                      pair) == 0;
}

/* -------------------------------------------------------------------------- */

static struct pump *serve(struct pel_tls *tls, int fd, bool inet,
                          double handshake_s, double stall_s)
{
    int pair[2], on = 1;
    SSL *ssl = SSL_new(tls->context);
    if (!ssl || SSL_set_fd(ssl, fd) != 1 ||
        !((inet && pair_inet(pair)) || pair_unix(pair))) {
        SSL_free(ssl);
        close(fd);
        return NULL;
    }
    SSL_set_accept_state(ssl);
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    struct pump *pump = g_new0(struct pump, 1);
    pump->tls = tls;
    pump->ssl = ssl;
    pump->fd = fd;
    pump->ours = pair[0];
    pump->plain = pair[1];
    pump->progress_ns = pel_now_ns();
    pump->handshake_end_ns = pump->progress_ns + (int64_t)(handshake_s * 1e9);
    pump->stall_ns = (int64_t)(stall_s * 1e9);
    pump->fd_source = pel_fdsource_create(fd, G_IO_IN, run_client, pump);
    pump->plain_source = pel_fdsource_create(pair[1], G_IO_IN, run, pump);
    pump->wants_read = true;
    pel_fdsource_wake_at(pump->fd_source, 0);
    g_ptr_array_add(tls->pumps, pump);
    return pump;
}

int pel_tls_serve(struct pel_tls *tls, int fd, bool inet, double handshake_s,
                  double stall_s)
{
    const struct pump *pump = serve(tls, fd, inet, handshake_s, stall_s);
    return pump ? pump->ours : -1;
}

/* --- those that wait for their handshake ---------------------------------- */

bool pel_tls_serve_later(struct pel_tls *tls, int fd, bool inet,
                         double handshake_s, double stall_s,
                         pel_tls_ready ready, void *user)
{
    struct pump *pump = serve(tls, fd, inet, handshake_s, stall_s);
    if (pump) {
        pump->ready = ready;
        pump->user = user;
    }
    return pump != NULL;
}

unsigned pel_tls_shaking(const struct pel_tls *tls, pel_tls_ready ready)
{
    unsigned count = 0;
    for (guint i = 0; i < tls->pumps->len; i++) {
        const struct pump *pump = g_ptr_array_index(tls->pumps, i);
        count += pump->ready == ready;
    }
    return count;
}

/* Nothing has come that was not read: it is the client who is waited for. */
static bool is_silent(const struct pump *pump)
{
    struct pollfd probe = { .fd = pump->fd, .events = POLLIN };
    return poll(&probe, 1, 0) == 0;
}

bool pel_tls_make_room(struct pel_tls *tls, pel_tls_ready ready)
{
    struct pump *found = NULL;
    bool silent = false;
    for (guint i = 0; i < tls->pumps->len; i++) {
        struct pump *pump = g_ptr_array_index(tls->pumps, i);
        if (pump->ready != ready) {
            continue;
        }
        bool its = is_silent(pump);
        if (!found || its > silent ||
            (its == silent && pump->progress_ns < found->progress_ns)) {
            found = pump;
            silent = its;
        }
    }
    if (found) {
        pump_free(found);
    }
    return found != NULL;
}

void pel_tls_destroy(struct pel_tls *tls)
{
    if (!tls) {
        return;
    }
    while (tls->pumps->len > 0) {
        pump_free(g_ptr_array_index(tls->pumps, 0));
    }
    g_ptr_array_free(tls->pumps, TRUE);
    SSL_CTX_free(tls->context);
    g_free(tls->cert_path);
    g_free(tls->key_path);
    g_free(tls);
}
