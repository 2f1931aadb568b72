#include "net/hls.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "base/clock.h"
#include "base/watch.h"
#include "encode/ts.h"
#include "fault.h"
#include "net/tsviewer.h"

/* A key frame begins a segment if the last one is so old: one that a new viewer
 * asked for does not. One is asked for when the last is a second old. */
#define LEAST_NS 900000000LL
#define KEY_AFTER_NS 1000000000LL
/* Pictures further apart than this are of two programmes: the clock stood. */
#define GAP_NS 2400000000LL
/* A part ends so early that one picture that is late does not make it too long.
 */
#define PART_NS 500000000LL
/* The number of a stream's first segment. Not 0: HLS.js (1.7) takes 0 for "no
 * segment" where it looks which parts are in the buffer, appends those of
 * segment 0 again and again, and stands seconds behind ever after. */
#define FIRST_NUMBER 1
#define SWEEP_MS 500
/* Segments at the end of a playlist that have their parts in it. */
#define WITH_PARTS 3
#define S_NS 1e-9
/* From a playlist, /v1/views/NAME/hls.m3u8, to what it lists. */
#define FILES "../../hls/"
#define LIST_CACHE "max-age=1"
#define FILE_CACHE "max-age=60, immutable"

struct part {
    size_t end; /* of its bytes in the segment's; it begins where the last one
                 * ends */
    int64_t length_ns;
};

struct segment {
    int64_t number;
    int64_t unix_ns;   /* of its first picture */
    int64_t length_ns; /* 0: it is still being made */
    bool broken;       /* it does not go on from the one before */
    GByteArray *bytes;
    GArray *parts; /* struct part */
};

struct stream {
    struct pel_hls *all;
    uint32_t id; /* in the names of its files */
    char view[PEL_NAME_SIZE];
    struct pel_profile profile;
    struct pel_subscription *subscription;
    int64_t owned_ns; /* the last request of the highest who uses it */
    bool answered;    /* a playlist of it, so that somebody may come again */
    struct pel_ts ts;
    GPtrArray *segments; /* oldest first; the last one is being made */
    int64_t next_number;
    int64_t asked_ns;   /* CLOCK_MONOTONIC of the last request */
    int64_t skipped_ns; /* between the pictures' clock and the stream's */
    int64_t segment_ns, part_ns, last_ns; /* stamps of first and last picture */
    int64_t step_ns;                      /* between the last two */
    bool over;
    int64_t dropped_breaks; /* discontinuities before the oldest segment */
    uint64_t bytes;
};

struct waiting {
    struct stream *stream;
    int64_t number, part; /* −1: any whole segment; the whole segment */
    bool file;            /* the answer is that, else the playlist */
    int64_t until_ns;
    pel_hls_done done;
    void *user;
};

struct pel_hls {
    struct pel_frames *frames;
    GPtrArray *streams, *waiting;
    guint sweeper;
    uint64_t segments, parts, playlists, files, bytes;
};

/* --- segments ------------------------------------------------------------- */

static void free_segment(gpointer pointer)
{
    struct segment *s = pointer;
    g_byte_array_unref(s->bytes);
    g_array_unref(s->parts);
    g_free(s);
}

static struct segment *segment_at(const struct stream *s, guint i)
{
    return g_ptr_array_index(s->segments, i);
}

/* The one that is being made, or NULL. */
static struct segment *open_segment(const struct stream *s)
{
    struct segment *last =
        s->segments->len ? segment_at(s, s->segments->len - 1) : NULL;
    return last && last->length_ns == 0 ? last : NULL;
}

static struct segment *find_segment(const struct stream *s, int64_t number)
{
    for (guint i = 0; i < s->segments->len; i++) {
        if (segment_at(s, i)->number == number) {
            return segment_at(s, i);
        }
    }
    return NULL;
}

static size_t part_begin(const struct segment *s, guint part)
{
    return part == 0 ? 0 : g_array_index(s->parts, struct part, part - 1).end;
}

/* What was written since the last part is one, up to a picture's stamp. */
static void end_part(struct stream *s, struct segment *g, int64_t at_ns)
{
    if (g->bytes->len > part_begin(g, g->parts->len)) {
        struct part part = { g->bytes->len, at_ns - s->part_ns };
        g_array_append_val(g->parts, part);
        s->all->parts++;
    }
    s->part_ns = at_ns;
}

static void end_segment(struct stream *s, struct segment *g, int64_t at_ns)
{
    end_part(s, g, at_ns);
    g->length_ns = MAX(at_ns - s->segment_ns, 1);
    s->all->segments++;
    uint64_t most = PEL_HLS_MOST_BYTES / s->all->streams->len;
    while (s->segments->len > 2 &&
           (s->segments->len > PEL_HLS_KEPT || s->bytes > most)) {
        s->bytes -= segment_at(s, 0)->bytes->len;
        s->dropped_breaks += segment_at(s, 0)->broken;
        g_ptr_array_remove_index(s->segments, 0);
    }
}

static struct segment *begin_segment(struct stream *s, int64_t at_ns,
                                     bool broken)
{
    struct segment *g = g_new0(struct segment, 1);
    g->number = s->next_number++;
    g->unix_ns = pel_unix_ns() - (pel_now_ns() - at_ns);
    g->broken = broken;
    g->bytes = g_byte_array_new();
    g->parts = g_array_new(FALSE, FALSE, sizeof(struct part));
    g_ptr_array_add(s->segments, g);
    s->segment_ns = s->part_ns = at_ns;
    return g;
}

/* --- playlists ------------------------------------------------------------ */

static void append_parts(GString *out, const struct stream *s,
                         const struct segment *g)
{
    for (guint i = 0; i < g->parts->len; i++) {
        const struct part *part = &g_array_index(g->parts, struct part, i);
        g_string_append_printf(out,
                               "#EXT-X-PART:DURATION=%.5f,URI=\"" FILES
                               "%08x-%" PRId64 "-%u.ts\"%s\n",
                               (double)part->length_ns * S_NS, s->id, g->number,
                               i, i == 0 ? ",INDEPENDENT=YES" : "");
    }
}

static void append_begin(GString *out, const struct segment *g)
{
    GDateTime *utc = g_date_time_new_from_unix_utc(g->unix_ns / 1000000000);
    char *text = g_date_time_format(utc, "%Y-%m-%dT%H:%M:%S");
    g_string_append_printf(out, "%s#EXT-X-PROGRAM-DATE-TIME:%s.%03dZ\n",
                           g->broken ? "#EXT-X-DISCONTINUITY\n" : "", text,
                           (int)(g->unix_ns / 1000000 % 1000));
    g_free(text);
    g_date_time_unref(utc);
}

static guint first_listed(const struct stream *s)
{
    guint whole = s->segments->len - (open_segment(s) != NULL);
    return whole > PEL_HLS_LISTED ? whole - PEL_HLS_LISTED : 0;
}

static char *playlist(const struct stream *s)
{
    GString *out = g_string_new("#EXTM3U\n#EXT-X-VERSION:6\n");
    guint first = first_listed(s), len = s->segments->len;
    int breaks = 0; /* of those that are not listed any more */
    for (guint i = 0; i < first; i++) {
        breaks += segment_at(s, i)->broken;
    }
    g_string_append_printf(
        out,
        "#EXT-X-TARGETDURATION:%d\n#EXT-X-PART-INF:PART-TARGET=%.3f\n"
        "#EXT-X-SERVER-CONTROL:CAN-BLOCK-RELOAD=YES,PART-HOLD-BACK=%.3f\n"
        "#EXT-X-INDEPENDENT-SEGMENTS\n#EXT-X-MEDIA-SEQUENCE:%" PRId64
        "\n#EXT-X-DISCONTINUITY-SEQUENCE:%" PRId64 "\n",
        PEL_HLS_TARGET_S, PEL_HLS_PART_S, 3 * PEL_HLS_PART_S,
        segment_at(s, first)->number, s->dropped_breaks + breaks);
    for (guint i = first; i < len; i++) {
        const struct segment *g = segment_at(s, i);
        if (g->length_ns > 0 || g->parts->len > 0) {
            append_begin(out, g);
        }
        if (i + WITH_PARTS >= len) {
            append_parts(out, s, g);
        }
        if (g->length_ns > 0) {
            g_string_append_printf(
                out, "#EXTINF:%.5f,\n" FILES "%08x-%" PRId64 ".ts\n",
                (double)g->length_ns * S_NS, s->id, g->number);
        }
    }
    const struct segment *open = open_segment(s);
    g_string_append_printf(out,
                           "#EXT-X-PRELOAD-HINT:TYPE=PART,URI=\"" FILES
                           "%08x-%" PRId64 "-%u.ts\"\n",
                           s->id, open ? open->number : s->next_number,
                           open ? open->parts->len : 0);
    return g_string_free(out, FALSE);
}

/* --- who waits ------------------------------------------------------------ */

/* Whether it is there, or can be told that it never will be. */
static bool is_there(const struct waiting *w)
{
    const struct stream *s = w->stream;
    bool any =
        s->segments->len > 1 || (s->segments->len == 1 && !open_segment(s));
    if (w->number < 0 || (!w->file && !any)) {
        return any; /* no list is without a segment */
    }
    const struct segment *g = find_segment(s, w->number);
    return g ? g->length_ns > 0 ||
                   (w->part >= 0 && w->part < (int64_t)g->parts->len)
             : w->number < s->next_number;
}

static void refuse(pel_hls_done done, void *user, enum pel_err err,
                   const char *path, const char *message)
{
    struct pel_fault fault;
    pel_fault_set(&fault, err, "%s", message);
    pel_fault_at(&fault, path, NULL);
    done(user, err, &fault, NULL);
}

static void answer_list(const struct waiting *w)
{
    char *text = playlist(w->stream);
    const struct pel_hls_answer answer = { PEL_HLS_PLAYLIST_TYPE, LIST_CACHE,
                                           text, strlen(text) };
    w->stream->all->playlists++;
    w->stream->answered = true;
    w->done(w->user, PEL_OK, NULL, &answer);
    g_free(text);
}

static void answer_file(const struct waiting *w)
{
    const struct segment *g = find_segment(w->stream, w->number);
    bool has = g && (w->part < 0 ? g->length_ns > 0
                                 : w->part < (int64_t)g->parts->len);
    if (!has) {
        refuse(w->done, w->user, PEL_ERR_NOT_FOUND, "",
               "this part of the stream is gone; ask for its playlist again");
        return;
    }
    size_t from = w->part < 0 ? 0 : part_begin(g, (guint)w->part);
    size_t to = w->part < 0 ? g->bytes->len
                            : g_array_index(g->parts, struct part, w->part).end;
    const struct pel_hls_answer answer = { PEL_TS_TYPE, FILE_CACHE,
                                           g->bytes->data + from, to - from };
    w->stream->all->files++;
    w->stream->all->bytes += to - from;
    w->done(w->user, PEL_OK, NULL, &answer);
}

static void answer(const struct waiting *w)
{
    if (w->file) {
        answer_file(w);
    } else {
        answer_list(w);
    }
}

/* Those of a stream for whom it is there; all: whatever is. */
static void answer_waiting(struct stream *s, bool all, const char *why)
{
    struct pel_hls *hls = s->all;
    for (guint i = 0; i < hls->waiting->len;) {
        struct waiting *w = g_ptr_array_index(hls->waiting, i);
        if (w->stream != s || !(all || is_there(w))) {
            i++;
            continue;
        }
        (void)g_ptr_array_steal_index(hls->waiting, i);
        if (all) {
            refuse(w->done, w->user, PEL_ERR_NOT_FOUND, "view", why);
        } else {
            answer(w);
        }
        g_free(w);
    }
}

static void wait_or_answer(struct pel_hls *hls, const struct waiting *w)
{
    w->stream->asked_ns = pel_now_ns();
    if (is_there(w)) {
        answer(w);
        return;
    }
    g_ptr_array_add(hls->waiting, g_memdup2(w, sizeof *w));
}

/* --- pictures ------------------------------------------------------------- */

static void write_picture(struct stream *s, struct segment *g,
                          const struct pel_frame *frame, int64_t at_ns)
{
    struct pel_bytes bytes;
    if (pel_ts_write(&s->ts, frame->data, frame->size, at_ns - s->skipped_ns,
                     frame->key, &bytes) != PEL_OK) {
        pel_frames_resync(s->subscription, false);
        return;
    }
    g_byte_array_append(g->bytes, bytes.data, (guint)bytes.size);
    s->bytes += bytes.size;
    pel_bytes_finish(&bytes);
}

static void take_picture(struct stream *s, const struct pel_frame *frame)
{
    int64_t at_ns = frame->requested_ns;
    struct segment *g = open_segment(s);
    bool gap = g && at_ns - s->last_ns > GAP_NS;
    if (gap) {
        end_segment(s, g, s->last_ns + s->step_ns);
        s->skipped_ns += at_ns - (s->last_ns + s->step_ns);
        g = NULL;
    }
    if (!g && !frame->key) { /* the first after a gap: with the next key */
        pel_frames_want_key(s->subscription, true);
        return;
    }
    bool broken = !g && s->next_number > FIRST_NUMBER;
    if (g && frame->key && at_ns - s->segment_ns >= LEAST_NS) {
        end_segment(s, g, at_ns);
        g = NULL;
    }
    s->step_ns = g && at_ns > s->last_ns ? at_ns - s->last_ns : s->step_ns;
    if (!g) {
        g = begin_segment(s, at_ns, broken);
    } else if (at_ns - s->part_ns + s->step_ns > PART_NS) {
        end_part(s, g, at_ns);
    }
    write_picture(s, g, frame, at_ns);
    s->last_ns = at_ns;
    if (at_ns - s->segment_ns + s->step_ns >= KEY_AFTER_NS) {
        pel_frames_want_key(s->subscription, false);
    }
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct stream *s = user;
    if (err == PEL_ERR_NOT_FOUND) {
        s->over = true;
        answer_waiting(s, true, fault->message);
    } else if (err == PEL_OK) {
        take_picture(s, frame);
        answer_waiting(s, false, NULL);
    }
}

/* --- streams -------------------------------------------------------------- */

static void free_stream(gpointer pointer)
{
    struct stream *s = pointer;
    pel_frames_unsubscribe(s->subscription);
    g_ptr_array_unref(s->segments);
    g_free(s);
}

static bool is_waited_for(const struct pel_hls *hls, const struct stream *s)
{
    for (guint i = 0; i < hls->waiting->len; i++) {
        const struct waiting *w = g_ptr_array_index(hls->waiting, i);
        if (w->stream == s) {
            return true;
        }
    }
    return false;
}

static gboolean sweep(gpointer user)
{
    PEL_WATCH("hls");
    struct pel_hls *hls = user;
    int64_t now_ns = pel_now_ns();
    for (guint i = 0; i < hls->waiting->len;) {
        struct waiting *w = g_ptr_array_index(hls->waiting, i);
        if (now_ns < w->until_ns) {
            i++;
            continue;
        }
        (void)g_ptr_array_steal_index(hls->waiting, i);
        refuse(w->done, w->user, PEL_ERR_BUSY, "",
               "no picture came: the clock stands, or the server is busy");
        g_free(w);
    }
    for (guint i = 0; i < hls->streams->len;) {
        struct stream *s = g_ptr_array_index(hls->streams, i);
        bool idle = now_ns - s->asked_ns > PEL_HLS_IDLE_S * 1000000000LL;
        if ((idle || s->over) && !is_waited_for(hls, s)) {
            g_ptr_array_remove_index(hls->streams, i);
        } else {
            i++;
        }
    }
    hls->sweeper = hls->streams->len > 0 ? hls->sweeper : 0;
    return hls->sweeper != 0;
}

static struct stream *find_stream(const struct pel_hls *hls,
                                  const struct pel_hls_wish *wish)
{
    for (guint i = 0; i < hls->streams->len; i++) {
        struct stream *s = g_ptr_array_index(hls->streams, i);
        const struct pel_profile *p = &s->profile, *want = &wish->profile;
        if (!s->over && strcmp(s->view, wish->view) == 0 &&
            p->width == want->width && p->height == want->height &&
            p->kbps == want->kbps) {
            return s;
        }
    }
    return NULL;
}

static enum pel_err open_stream(struct pel_hls *hls,
                                const struct pel_hls_wish *wish,
                                struct stream **out, struct pel_fault *fault)
{
    struct stream *s = g_new0(struct stream, 1);
    s->all = hls;
    s->id = g_random_int();
    s->next_number = FIRST_NUMBER;
    g_strlcpy(s->view, wish->view, sizeof s->view);
    s->profile = wish->profile;
    s->profile.codec = PEL_CODEC_H264;
    s->segments = g_ptr_array_new_with_free_func(free_segment);
    enum pel_err err = pel_frames_open(hls->frames, s->view, &s->profile,
                                       on_frame, s, &s->subscription, fault);
    if (err) {
        g_ptr_array_unref(s->segments);
        g_free(s);
        return err;
    }
    g_ptr_array_add(hls->streams, s);
    if (!hls->sweeper) {
        hls->sweeper = g_timeout_add(SWEEP_MS, sweep, hls);
    }
    *out = s;
    return PEL_OK;
}

/* It counts in the share of the highest who asked lately. */
static void claim(struct stream *s, const struct pel_who *who)
{
    int64_t now_ns = pel_now_ns();
    if (who->rank <= s->profile.who.rank ||
        now_ns - s->owned_ns > PEL_HLS_IDLE_S * 1000000000LL) {
        s->profile.who = *who;
        s->owned_ns = now_ns;
        pel_frames_claim(s->subscription, who);
    }
}

static int64_t wait_until(void)
{
    return pel_now_ns() + PEL_HLS_WAIT_S * 1000000000LL;
}

void pel_hls_playlist(struct pel_hls *hls, const struct pel_hls_wish *wish,
                      pel_hls_done done, void *user)
{
    struct pel_fault fault;
    struct stream *s = find_stream(hls, wish);
    enum pel_err err = s ? PEL_OK : open_stream(hls, wish, &s, &fault);
    if (err) {
        done(user, err, &fault, NULL);
        return;
    }
    claim(s, &wish->profile.who);
    if (wish->msn > s->next_number + 1) {
        s->asked_ns = pel_now_ns();
        refuse(done, user, PEL_ERR_OUT_OF_RANGE, "_HLS_msn",
               "_HLS_msn is more than one segment beyond the last; ask for "
               "the playlist without it");
        return;
    }
    const struct waiting w = { .stream = s,
                               .number = wish->msn,
                               .part = wish->part,
                               .until_ns = wait_until(),
                               .done = done,
                               .user = user };
    wait_or_answer(hls, &w);
}

/* ID-NUMBER.ts or ID-NUMBER-PART.ts. */
static bool read_name(const char *name, uint32_t *id, int64_t *number,
                      int64_t *part)
{
    char *end;
    guint64 value;
    if (strspn(name, "0123456789abcdef") != 8 || name[8] != '-' ||
        !g_ascii_isdigit(name[9])) {
        return false;
    }
    *id = (uint32_t)g_ascii_strtoull(name, NULL, 16);
    value = g_ascii_strtoull(name + 9, &end, 10);
    *number = (int64_t)MIN(value, (guint64)G_MAXINT64);
    *part = -1;
    if (*end == '-' && g_ascii_isdigit(end[1])) {
        value = g_ascii_strtoull(end + 1, &end, 10);
        *part = (int64_t)MIN(value, (guint64)G_MAXINT32);
    }
    return strcmp(end, ".ts") == 0;
}

void pel_hls_file(struct pel_hls *hls, const char *name, pel_hls_done done,
                  void *user)
{
    struct waiting w = {
        .file = true, .until_ns = wait_until(), .done = done, .user = user
    };
    uint32_t id;
    bool good = read_name(name, &id, &w.number, &w.part);
    for (guint i = 0; good && i < hls->streams->len; i++) {
        struct stream *s = g_ptr_array_index(hls->streams, i);
        w.stream = s->id == id && !s->over ? s : w.stream;
    }
    struct stream *s = w.stream;
    /* The next part may be asked for before it is there, nothing else. */
    struct segment *open = s ? open_segment(s) : NULL;
    bool hint =
        open ? w.number == open->number && w.part == (int64_t)open->parts->len
             : s && w.number == s->next_number && w.part == 0;
    if (!s || !(is_there(&w) || hint)) {
        refuse(done, user, PEL_ERR_NOT_FOUND, "",
               "no stream has such a file now; ask for its playlist again");
        return;
    }
    wait_or_answer(hls, &w);
}

/* Nobody has a playlist of it, or waits for one: who asked has gone. */
static void end_unused(struct pel_hls *hls, struct stream *s)
{
    if (!s->answered && !is_waited_for(hls, s)) {
        g_ptr_array_remove(hls->streams, s);
    }
}

bool pel_hls_forget(struct pel_hls *hls, const void *user)
{
    for (guint i = 0; i < hls->waiting->len; i++) {
        struct waiting *w = g_ptr_array_index(hls->waiting, i);
        if (w->user == user) {
            struct stream *s = w->stream;
            g_free(g_ptr_array_steal_index(hls->waiting, i));
            end_unused(hls, s);
            return true;
        }
    }
    return false;
}

/* --- life ----------------------------------------------------------------- */

struct pel_hls *pel_hls_create(struct pel_frames *frames)
{
    struct pel_hls *hls = g_new0(struct pel_hls, 1);
    hls->frames = frames;
    hls->streams = g_ptr_array_new_with_free_func(free_stream);
    hls->waiting = g_ptr_array_new();
    return hls;
}

void pel_hls_destroy(struct pel_hls *hls)
{
    if (!hls) {
        return;
    }
    for (guint i = 0; i < hls->streams->len; i++) {
        answer_waiting(g_ptr_array_index(hls->streams, i), true,
                       "the daemon is stopping");
    }
    if (hls->sweeper) {
        g_source_remove(hls->sweeper);
    }
    g_ptr_array_unref(hls->streams);
    g_ptr_array_unref(hls->waiting);
    g_free(hls);
}

void pel_hls_collect(const struct pel_hls *hls, struct pel_metrics_page *page)
{
    const struct {
        const char *name, *text;
        uint64_t value;
    } counters[] = {
        { "pelagos_hls_segments_total", "HLS segments made.", hls->segments },
        { "pelagos_hls_parts_total", "Parts of HLS segments made.",
          hls->parts },
        { "pelagos_hls_playlists_total", "HLS playlists sent.",
          hls->playlists },
        { "pelagos_hls_files_total", "HLS segments and parts sent.",
          hls->files },
        { "pelagos_hls_sent_bytes_total", "Bytes of these.", hls->bytes },
    };
    pel_metric(page, "pelagos_hls_streams", PEL_METRIC_GAUGE,
               "HLS streams that are made.", NULL, hls->streams->len);
    pel_metric(page, "pelagos_hls_waiting", PEL_METRIC_GAUGE,
               "Requests for HLS that wait for what is not there yet.", NULL,
               hls->waiting->len);
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].text,
                   NULL, (double)counters[i].value);
    }
}
