#include "net/rtspguard.h"

#include <ctype.h>
#include <stdatomic.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>

#include <gio/gio.h>

#define CHUNK_PREFIX 4
#define GUARD_KEY "pelagos-rtsp-guard"
enum { GUARDED = 1, ENDED };

/* --- framing -------------------------------------------------------------- */

static bool has_prefix(const struct pel_rtsp_framing *f, const char *prefix)
{
    size_t length = strlen(prefix);
    return f->line_length >= length &&
           strncasecmp(f->line, prefix, length) == 0;
}

/* The one header that says where the message ends, in its plainest form. */
static bool read_length(struct pel_rtsp_framing *f)
{
    static const char name[] = "Content-Length";
    if (!has_prefix(f, name)) {
        return true;
    }
    const char *at = f->line + sizeof name - 1;
    if (f->has_length || *at++ != ':' || f->line_length >= sizeof f->line) {
        return false;
    }
    at += *at == ' ';
    f->has_length = true;
    if (!isdigit((unsigned char)*at)) {
        return false;
    }
    while (isdigit((unsigned char)*at) && f->left <= PEL_RTSP_BODY_BYTES) {
        f->left = f->left * 10 + (size_t)(*at++ - '0');
    }
    return *at == '\0' && f->left <= PEL_RTSP_BODY_BYTES;
}

/* The id, as much of it as GStreamer may look for. */
static bool check_session(const struct pel_rtsp_framing *f)
{
    static const char name[] = "Session";
    const char *at = f->line + sizeof name - 1;
    if (!f->may_use || !has_prefix(f, name)) {
        return true;
    }
    at += strspn(at, " \t");
    if (*at != ':' && *at != '\0') {
        return true; /* another name that begins so */
    }
    if (f->line_length >= sizeof f->line || *at == '\0') {
        return false; /* what is behind it is not known here */
    }
    at++;
    at += strspn(at, " \t");
    char id[sizeof f->line];
    g_strlcpy(id, at, sizeof id);
    id[strcspn(id, "; \t")] = '\0';
    return f->may_use(f->who, id);
}

/* Whatever the address is: GStreamer goes by the method. */
static bool asks_for_tunnel(const struct pel_rtsp_framing *f)
{
    size_t method = strcspn(f->line, " \t\r\f\v");
    return (method == 3 && has_prefix(f, "GET")) ||
           (method == 4 && has_prefix(f, "POST"));
}

static bool end_line(struct pel_rtsp_framing *f)
{
    bool first = f->head == f->line_length + 1;
    size_t length = f->line_length;
    if (length > 0 && length <= sizeof f->line && f->line[length - 1] == '\r') {
        length--;
    }
    bool fits = length < sizeof f->line;
    f->line[fits ? length : sizeof f->line - 1] = '\0';
    f->line_length = length;
    if (length == 0) {
        bool body = f->left > 0;
        f->state = body ? PEL_RTSP_IN_BODY : PEL_RTSP_AT_MESSAGE;
        return true;
    }
    /* A line that goes on with the next could hide a length. */
    bool plain = !isspace((unsigned char)f->line[0]);
    bool good = plain && (first ? !asks_for_tunnel(f)
                                : read_length(f) && check_session(f));
    f->line_length = 0;
    return good;
}

static bool take_head(struct pel_rtsp_framing *f, uint8_t c)
{
    if (++f->head > PEL_RTSP_HEAD_BYTES || c == '\0') {
        return false;
    }
    if (c == '\n') {
        return end_line(f);
    }
    if (f->line_length > 0 && f->line_length <= sizeof f->line &&
        f->line[f->line_length - 1] == '\r') {
        return false; /* alone, it is the end of a line to some */
    }
    if (f->line_length < sizeof f->line) {
        f->line[f->line_length] = (char)c;
    }
    f->line_length++;
    return true;
}

static bool take_prefix(struct pel_rtsp_framing *f, uint8_t c)
{
    f->prefix++;
    f->left = f->prefix > 2 ? f->left << 8 | c : 0;
    if (f->prefix == CHUNK_PREFIX && f->left == 0) {
        f->state = PEL_RTSP_AT_MESSAGE;
    }
    return true;
}

static void begin(struct pel_rtsp_framing *f, uint8_t c)
{
    *f = (struct pel_rtsp_framing){
        .state = c == '$' ? PEL_RTSP_IN_CHUNK : PEL_RTSP_IN_HEAD,
        .may_use = f->may_use,
        .who = f->who,
    };
}

bool pel_rtsp_framing_take(struct pel_rtsp_framing *f, const uint8_t *data,
                           size_t size)
{
    for (size_t i = 0; i < size && !f->broken;) {
        bool prefix = f->state == PEL_RTSP_IN_CHUNK && f->prefix < CHUNK_PREFIX;
        if (f->state == PEL_RTSP_AT_MESSAGE) {
            begin(f, data[i]);
        } else if (f->state == PEL_RTSP_IN_HEAD) {
            f->broken = !take_head(f, data[i++]);
        } else if (prefix) {
            f->broken = !take_prefix(f, data[i++]);
        } else {
            size_t n = MIN(f->left, size - i);
            f->left -= n;
            i += n;
            f->state = f->left > 0 ? f->state : PEL_RTSP_AT_MESSAGE;
        }
    }
    return !f->broken;
}

/* --- whose sessions they are ---------------------------------------------- */

static GMutex owners_lock;
static GHashTable *owners; /* id: socket */

void pel_rtsp_guard_own(GSocket *socket, const char *session)
{
    g_mutex_lock(&owners_lock);
    if (!owners) {
        owners = g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    }
    g_hash_table_replace(owners, g_strdup(session), socket);
    g_mutex_unlock(&owners_lock);
}

void pel_rtsp_guard_disown(const char *session)
{
    g_mutex_lock(&owners_lock);
    if (owners) {
        g_hash_table_remove(owners, session);
        if (g_hash_table_size(owners) == 0) {
            g_hash_table_unref(owners);
            owners = NULL;
        }
    }
    g_mutex_unlock(&owners_lock);
}

/* Its own, or nobody's: GStreamer answers that. */
static bool is_not_anothers(const void *socket, const char *session)
{
    g_mutex_lock(&owners_lock);
    const void *owner = owners ? g_hash_table_lookup(owners, session) : NULL;
    g_mutex_unlock(&owners_lock);
    return !owner || owner == socket;
}

/* --- a stream that breaks off --------------------------------------------- */

struct guarded_stream {
    GInputStream parent;
    GInputStream *inner; /* the connection's own */
    GSocket *socket;     /* likewise */
    struct pel_rtsp_framing framing;
};

static atomic_ullong broken;

uint64_t pel_rtsp_guard_broken(void)
{
    return atomic_load(&broken);
}

static gssize pass(struct guarded_stream *self, const void *data, gssize size,
                   GError **error)
{
    void *state = g_object_get_data(G_OBJECT(self->socket), GUARD_KEY);
    if (GPOINTER_TO_INT(state) == ENDED) {
        g_clear_error(error);
        return 0;
    }
    if (size > 0 &&
        !pel_rtsp_framing_take(&self->framing, data, (size_t)size)) {
        atomic_fetch_add(&broken, 1);
        g_set_error_literal(error, G_IO_ERROR, G_IO_ERROR_CONNECTION_CLOSED,
                            "the message is too large, or no RTSP");
        return -1;
    }
    return size;
}

static gssize read_some(GInputStream *stream, void *buffer, gsize size,
                        GCancellable *cancellable, GError **error)
{
    struct guarded_stream *self = (struct guarded_stream *)stream;
    return pass(
        self, buffer,
        g_input_stream_read(self->inner, buffer, size, cancellable, error),
        error);
}

static gssize read_at_once(GPollableInputStream *stream, void *buffer,
                           gsize size, GError **error)
{
    struct guarded_stream *self = (struct guarded_stream *)stream;
    return pass(
        self, buffer,
        g_pollable_input_stream_read_nonblocking(
            G_POLLABLE_INPUT_STREAM(self->inner), buffer, size, NULL, error),
        error);
}

static gboolean is_readable(GPollableInputStream *stream)
{
    return g_pollable_input_stream_is_readable(
        G_POLLABLE_INPUT_STREAM(((struct guarded_stream *)stream)->inner));
}

static GSource *create_source(GPollableInputStream *stream,
                              GCancellable *cancellable)
{
    struct guarded_stream *self = (struct guarded_stream *)stream;
    GSource *inner = g_pollable_input_stream_create_source(
        G_POLLABLE_INPUT_STREAM(self->inner), cancellable);
    GSource *source = g_pollable_source_new_full(self, inner, NULL);
    g_source_unref(inner);
    return source;
}

static void pollable_init(gpointer interface, gpointer data)
{
    (void)data;
    GPollableInputStreamInterface *pollable = interface;
    pollable->is_readable = is_readable;
    pollable->create_source = create_source;
    pollable->read_nonblocking = read_at_once;
}

static void stream_class_init(gpointer class, gpointer data)
{
    (void)data;
    G_INPUT_STREAM_CLASS(class)->read_fn = read_some;
}

static GType stream_type(void)
{
    static gsize type;
    if (g_once_init_enter(&type)) {
        const GInterfaceInfo pollable = { pollable_init, NULL, NULL };
        GType made = g_type_register_static_simple(
            G_TYPE_INPUT_STREAM, "PelRtspGuardedStream",
            sizeof(GInputStreamClass), stream_class_init,
            sizeof(struct guarded_stream), NULL, 0);
        g_type_add_interface_static(made, G_TYPE_POLLABLE_INPUT_STREAM,
                                    &pollable);
        g_once_init_leave(&type, made);
    }
    return type;
}

/* --- the connections that have it ----------------------------------------- */

typedef GInputStream *(*get_stream)(GIOStream *io);
static get_stream of_tcp, of_unix; /* as GIO made them */

/* The connection owns its streams, and lives as long as this one does. */
static void unref_stream(gpointer stream)
{
    g_object_unref(stream);
}

static GInputStream *guarded(GIOStream *io, get_stream inner)
{
    GObject *object = G_OBJECT(io);
    GSocket *socket = g_socket_connection_get_socket(G_SOCKET_CONNECTION(io));
    if (!g_object_get_data(G_OBJECT(socket), GUARD_KEY)) {
        return inner(io);
    }
    struct guarded_stream *stream = g_object_get_data(object, GUARD_KEY);
    if (!stream) {
        stream = g_object_new(stream_type(), NULL);
        stream->inner = inner(io);
        stream->socket = socket;
        stream->framing.may_use = is_not_anothers;
        stream->framing.who = socket;
        g_object_set_data_full(object, GUARD_KEY, stream, unref_stream);
    }
    return &stream->parent;
}

static GInputStream *guarded_tcp(GIOStream *io)
{
    return guarded(io, of_tcp);
}

static GInputStream *guarded_unix(GIOStream *io)
{
    return guarded(io, of_unix);
}

static get_stream replace(GType type, get_stream by)
{
    GIOStreamClass *class = G_IO_STREAM_CLASS(g_type_class_ref(type));
    get_stream was = class->get_input_stream;
    class->get_input_stream = by;
    return was; /* the class stays referenced */
}

/* gst-rtsp-server makes the connection itself, of the type that GIO has for
 * the kind of socket, and nothing lets one choose another: so those types hand
 * out their stream through us. Of sockets without the key they do as ever. */
GSocket *pel_rtsp_guarded_socket(int fd)
{
    static gsize done;
    if (g_once_init_enter(&done)) {
        of_tcp = replace(G_TYPE_TCP_CONNECTION, guarded_tcp);
        of_unix = replace(G_TYPE_UNIX_CONNECTION, guarded_unix);
        g_once_init_leave(&done, 1);
    }
    GSocket *socket = g_socket_new_from_fd(fd, NULL);
    if (socket) {
        g_object_set_data(G_OBJECT(socket), GUARD_KEY,
                          GINT_TO_POINTER(GUARDED));
    }
    return socket;
}

#define PEEK_BYTES 4096

char *pel_rtsp_guard_peek(GSocket *socket, bool *waits)
{
    static const char name[] = "\nAuthorization:";
    char text[PEEK_BYTES + 1];
    ssize_t n = recv(g_socket_get_fd(socket), text, PEEK_BYTES,
                     MSG_PEEK | MSG_DONTWAIT);
    *waits = n > 0;
    text[n > 0 ? n : 0] = '\0';
    const char *at = strcasestr(text, name);
    const char *end = at ? strchr(at + 1, '\n') : NULL;
    if (!end) {
        return NULL;
    }
    at += sizeof name - 1;
    return g_strstrip(g_strndup(at, (gsize)(end - at)));
}

void pel_rtsp_guard_end(GSocket *socket)
{
    g_object_set_data(G_OBJECT(socket), GUARD_KEY, GINT_TO_POINTER(ENDED));
    /* Not g_socket_shutdown: it writes to fields that the thread which serves
     * the socket reads. */
    shutdown(g_socket_get_fd(socket), SHUT_RDWR);
}
