/* What the nodes say of themselves, and what is known of them here. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "bounds.h"
#include "cluster/cluster_parts.h"
#include "frames/present.h"
#include "frames/quality.h"
#include "message.h"

#define SILENT_NS 3000000000LL
#define FORGOTTEN_NS 600000000000LL
#define WINDOW_BEATS 10 /* the quickest seal is of so many seconds */
#define CLOCK_MS 1.0    /* by which clocks may differ */
#define SURE_BEATS 3    /* before that it may be a busy start */
#define EVERY_MS 250
/* By listened_ns: who misses so many beats is gone; the master of before, which
 * has sealed nothing for a while, sooner. One that is back is steady later. */
#define MISSED_BEATS 6
#define SUSPECT_NS 400000000LL
#define STEADY_NS 5000000000LL

static bool is_silent(const struct pel_cluster_node *node, int64_t now_ns)
{
    return now_ns - node->heard_ns > SILENT_NS;
}

struct pel_cluster_node *pel_cluster_find(const struct pel_cluster *c,
                                          const char *name)
{
    for (guint i = 0; i < c->nodes->len; i++) {
        struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        if (strcmp(node->said->name, name) == 0) {
            return node;
        }
    }
    return NULL;
}

static void node_free(struct pel_cluster_node *node)
{
    pelagos__cluster_node__free_unpacked(node->said, NULL);
    g_free(node);
}

void pel_cluster_nodes_free(struct pel_cluster *c)
{
    for (guint i = 0; i < c->nodes->len; i++) {
        node_free(g_ptr_array_index(c->nodes, i));
    }
    g_ptr_array_free(c->nodes, TRUE);
}

/* The one that has been silent for longest, of those that must be gone; NULL:
 * none. One that has spoken once has as long to do so again as the others. */
static struct pel_cluster_node *find_gone(const struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    struct pel_cluster_node *longest = NULL;
    for (guint i = 0; i < c->nodes->len; i++) {
        struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        if (now_ns - node->heard_ns > 2 * SILENT_NS &&
            (!longest || node->heard_ns < longest->heard_ns)) {
            longest = node;
        }
    }
    return longest;
}

static bool has_room(struct pel_cluster *c, const char *name)
{
    if (c->nodes->len < PEL_BOUND_CLUSTER_NODES) {
        return true;
    }
    struct pel_cluster_node *gone = find_gone(c);
    if (gone) {
        g_ptr_array_remove(c->nodes, gone);
        node_free(gone);
        return true;
    }
    c->unlisted++;
    if (!c->full) {
        pel_warn("CLU-021",
                 "%d nodes speak in this exercise, which is all that are "
                 "listed: %.64s and others take part, but nobody waits for "
                 "their delay",
                 PEL_BOUND_CLUSTER_NODES, name);
    }
    c->full = true;
    return false;
}

/* --- who is there --------------------------------------------------------- */

bool pel_cluster_is_there(const struct pel_cluster *c,
                          const struct pel_cluster_node *node)
{
    return node->spoke ? c->listened_ns - node->spoke_ns <= node->limit_ns
                       : c->listened_ns - c->since_ns <= SILENT_NS;
}

bool pel_cluster_is_steady(const struct pel_cluster *c,
                           const struct pel_cluster_node *node)
{
    return pel_cluster_is_there(c, node) &&
           (!node->spoke || c->listened_ns - node->began_ns >= STEADY_NS);
}

void pel_cluster_suspect(struct pel_cluster *c, const char *name)
{
    struct pel_cluster_node *node = pel_cluster_find(c, name);
    if (node && node->spoke) {
        node->spoke_ns =
            MIN(node->spoke_ns, c->listened_ns - node->limit_ns + SUSPECT_NS);
    }
}

static void spoke(struct pel_cluster *c, struct pel_cluster_node *node,
                  uint32_t every_ms)
{
    if (!node->spoke || !pel_cluster_is_there(c, node)) {
        node->began_ns = c->listened_ns;
    }
    node->spoke = true;
    node->spoke_ns = c->listened_ns;
    node->limit_ns = every_ms > 0
                         ? MISSED_BEATS * 1000000LL * CLAMP(every_ms, 50, 1000)
                         : SILENT_NS;
}

void pel_cluster_on_node(void *user, const Pelagos__ClusterNode *said)
{
    struct pel_cluster *c = user;
    pel_cluster_hear(c);
    if (!said->name) {
        return;
    }
    struct pel_cluster_node *node = pel_cluster_find(c, said->name);
    if (!node) {
        if (!has_room(c, said->name)) {
            return;
        }
        /* What was there already may be of one who is gone. */
        node = g_new0(struct pel_cluster_node, 1);
        node->heard_ns = pel_now_ns() - SILENT_NS;
        g_ptr_array_add(c->nodes, node);
    } else {
        if (node->said->beat != said->beat) {
            node->heard_ns = pel_now_ns();
        }
        if (node->said->beat != said->beat &&
            said->role != PELAGOS__CLUSTER_ROLE__JOINING) {
            spoke(c, node, said->every);
        }
        pelagos__cluster_node__free_unpacked(node->said, NULL);
    }
    node->said = (Pelagos__ClusterNode *)pel_message_copy(&said->base);
}

/* --- clocks --------------------------------------------------------------- */

void pel_cluster_heard(struct pel_cluster *c, const Pelagos__Seal *seal)
{
    double took_ms =
        (double)((int64_t)pel_cluster_unix_ns(c) - (int64_t)seal->made) * 1e-6;
    c->quickest_ms = fmin(c->quickest_ms, took_ms);
    c->quickest_next_ms = fmin(c->quickest_next_ms, took_ms);
}

/* The quickest way of a seal to us and to the master differs by our clocks. */
static bool clock_offset(const struct pel_cluster *c, double *ms)
{
    const struct pel_cluster_node *master =
        c->master ? pel_cluster_find(c, c->master->name) : NULL;
    if (!master || !master->said->has_quickest ||
        master->said->role != PELAGOS__CLUSTER_ROLE__MASTER ||
        !isfinite(c->quickest_ms)) {
        return false;
    }
    *ms = c->quickest_ms - master->said->quickest;
    return true;
}

/* --- delays and turns ----------------------------------------------------- */

int64_t pel_cluster_slowest_ns(const struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    double most_ms = 0;
    for (guint i = 0; i < c->nodes->len; i++) {
        const struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        if (!is_silent(node, now_ns)) {
            most_ms =
                fmax(most_ms, fmin(node->said->delay, PEL_PRESENT_MOST_MS));
        }
    }
    return (int64_t)(most_ms * 1e6);
}

double pel_cluster_quality(const struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    struct pel_frames_stats stats;
    pel_frames_get_stats(c->frames, &stats);
    double least = stats.quality_wanted;
    for (guint i = 0; i < c->nodes->len && !stats.quality_fixed; i++) {
        const struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        bool other = strcmp(node->said->name, c->name) != 0;
        if (other && node->said->has_quality && !is_silent(node, now_ns)) {
            least = fmin(least, fmax(node->said->quality, PEL_QUALITY_MIN));
        }
    }
    return least;
}

unsigned pel_cluster_order(const struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    unsigned before = 0;
    for (guint i = 0; i < c->nodes->len; i++) {
        const struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        const Pelagos__ClusterNode *n = node->said;
        bool other = strcmp(n->name, c->name) != 0 && n->rank >= 0 &&
                     (!c->master || strcmp(n->name, c->master->name) != 0) &&
                     !is_silent(node, now_ns);
        before += other &&
                  (n->rank < c->options.rank || (n->rank == c->options.rank &&
                                                 strcmp(n->name, c->name) < 0));
    }
    return before;
}

/* --- what we say ---------------------------------------------------------- */

static double delay_ms(const struct pel_cluster *c,
                       const struct pel_frames_stats *stats)
{
    double way_ms = isfinite(c->quickest_ms) ? fmax(c->quickest_ms, 0) : 0;
    /* What pictures took that nobody sees any more holds up no one. */
    bool shows = stats->live_megapixels > 0;
    double drawn_ms =
        shows ? fmax(stats->present_delay_ms - PEL_DELIVERY_MS, 0) : 0;
    return drawn_ms + way_ms;
}

/* Whether live views are drawn here at another scale than the seals say. */
static bool is_unlike(struct pel_cluster *c,
                      const struct pel_frames_stats *stats)
{
    bool unlike = stats->quality_fixed > 0 && c->quality > 0 &&
                  stats->quality_fixed != c->quality;
    if (unlike && !c->unlike) {
        pel_warn("CLU-022",
                 "node %s draws live views at %.2f of their size, as its "
                 "--quality says, and the exercise at %.2f: they are not the "
                 "others' to the bit; --quality auto goes by the exercise",
                 c->name, stats->quality_fixed, c->quality);
    }
    c->unlike = unlike;
    return unlike;
}

/* Borrows what it can. */
static void fill(struct pel_cluster *c, const char *views[PEL_MAX_VIEWS],
                 Pelagos__ClusterNode *n)
{
    struct pel_frames_stats stats;
    pel_frames_get_stats(c->frames, &stats);
    pelagos__cluster_node__init(n);
    n->name = c->name;
    n->address = c->address;
    n->program = c->program;
    n->device = (char *)pel_frames_device(c->frames);
    n->has_role = n->has_frame = n->has_digest = n->has_delay = true;
    n->has_differences = n->has_gaps = n->has_rank = n->has_waves = true;
    n->has_alike = n->has_beat = true;
    n->role = c->role;
    n->frame = c->number;
    n->digest.data = c->digest;
    n->digest.len = 8;
    n->delay = delay_ms(c, &stats);
    n->has_clock = clock_offset(c, &n->clock);
    n->has_quickest = isfinite(c->quickest_ms);
    n->quickest = n->has_quickest ? c->quickest_ms : 0;
    n->differences = c->differences;
    n->gaps = c->gaps;
    n->rank = c->options.rank;
    n->waves = (uint32_t)c->options.wave_count;
    n->alike = c->alike && !is_unlike(c, &stats);
    n->has_quality = stats.quality_fixed == 0;
    n->quality = stats.quality_wanted;
    n->beat = c->beat;
    n->n_views = pel_frames_watched(c->frames, views);
    n->views = (char **)views;
    n->lacks = c->options.exercises
                   ? (char *)pel_exercises_stand_by(c->options.exercises)
                   : NULL;
    n->has_spare = c->options.spare;
    n->spare = c->options.spare;
    n->has_every = pel_cluster_place_count(c, NULL) > 0;
    n->every = n->has_every ? EVERY_MS : 0;
}

void pel_cluster_say(struct pel_cluster *c, bool whole)
{
    static struct pel_log_limit limit;
    Pelagos__ClusterNode me;
    const char *views[PEL_MAX_VIEWS];
    int64_t now_ns = pel_now_ns();
    if (!whole && pel_cluster_place_count(c, NULL) == 0) {
        return;
    }
    c->beat++;
    fill(c, views, &me);
    pel_seals_node(c->seals, &me, !whole);
    if (!whole) {
        return;
    }
    c->seconds++;
    if (me.has_clock && fabs(me.clock) > CLOCK_MS && c->seconds > SURE_BEATS) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "CLU-014",
                        "the clock of node %s differs by %.1f ms from the "
                        "master's, and its pictures are shown by that much "
                        "earlier or later; see to chrony or ptp4l",
                        c->name, me.clock);
    }
    pel_cluster_warm(c);
    if (c->seconds % WINDOW_BEATS == 0) {
        c->quickest_ms = c->quickest_next_ms;
        c->quickest_next_ms = INFINITY;
    }
    for (guint i = c->nodes->len; i > 0; i--) {
        struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i - 1);
        if (now_ns - node->heard_ns > FORGOTTEN_NS) {
            node_free(node);
            g_ptr_array_remove_index(c->nodes, i - 1);
        }
    }
    c->full = c->full && c->nodes->len == PEL_BOUND_CLUSTER_NODES;
}

/* --- for others ----------------------------------------------------------- */

static int rising(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Of the last seals; false: there are none. */
static bool seal_times(const struct pel_cluster *c, double *median, double *p99)
{
    float sorted[PEL_SEAL_WINDOW];
    size_t n = c->sealed < PEL_SEAL_WINDOW ? c->sealed : PEL_SEAL_WINDOW;
    memcpy(sorted, c->sealed_ms, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, rising);
    if (n > 0) {
        *median = sorted[n / 2];
        *p99 = sorted[n * 99 / 100];
    }
    return n > 0;
}

Pelagos__Cluster *pel_cluster_status(struct pel_cluster *c)
{
    Pelagos__Cluster *out =
        (Pelagos__Cluster *)pel_message_new(&pelagos__cluster__descriptor);
    int64_t now_ns = pel_now_ns();
    if (!c) {
        return out;
    }
    size_t placed = pel_cluster_place_count(c, NULL);
    out->name = strdup(c->name);
    out->has_role = out->has_frame = true;
    out->role = c->role;
    out->frame = c->number;
    if (c->master) {
        out->master = strdup(c->master->name);
        out->address = strdup(c->master->address);
        out->has_term = true;
        out->term = c->master->term;
    }
    out->has_sealed_median = out->has_sealed_p99 =
        seal_times(c, &out->sealed_median, &out->sealed_p99);
    out->nodes = calloc(c->nodes->len + 1, sizeof *out->nodes);
    for (guint i = 0; i < c->nodes->len; i++) {
        const struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        Pelagos__ClusterNode *n =
            (Pelagos__ClusterNode *)pel_message_copy(&node->said->base);
        n->has_silent = true;
        n->silent = is_silent(node, now_ns) ||
                    (placed > 0 && !pel_cluster_is_there(c, node));
        out->nodes[out->n_nodes++] = n;
    }
    out->places = calloc(placed + 1, sizeof *out->places);
    for (; out->n_places < placed; out->n_places++) {
        out->places[out->n_places] =
            pel_cluster_place_copy(c, c->placing.known->places[out->n_places]);
    }
    return out;
}

void pel_cluster_collect(void *user, struct pel_metrics_page *page)
{
    struct pel_cluster *c = user;
    uint64_t attempts, failures;
    double median = 0, p99 = 0, offset = 0;
    pel_seals_count(c->seals, &attempts, &failures);
    (void)seal_times(c, &median, &p99);
    (void)clock_offset(c, &offset);
    size_t elsewhere = 0;
    size_t placed = pel_cluster_place_count(c, &elsewhere);
    const struct {
        const char *name, *help;
        enum pel_metric_type type;
        double value;
    } samples[] = {
        { "pelagos_cluster_frame", "The last sealed frame that is shown.",
          PEL_METRIC_GAUGE, (double)c->number },
        { "pelagos_cluster_master", "1 while this node is the master.",
          PEL_METRIC_GAUGE, c->role == PELAGOS__CLUSTER_ROLE__MASTER },
        { "pelagos_cluster_foreign_total",
          "Values in etcd below the exercise that no daemon has put.",
          PEL_METRIC_COUNTER, (double)pel_seals_foreign(c->seals) },
        { "pelagos_cluster_joining", "1 while this node shows nothing new.",
          PEL_METRIC_GAUGE, c->role == PELAGOS__CLUSTER_ROLE__JOINING },
        { "pelagos_cluster_seal_median_seconds",
          "From a frame's end to its seal, of the last ones of this master.",
          PEL_METRIC_GAUGE, median * 1e-3 },
        { "pelagos_cluster_seal_p99_seconds",
          "The same, of which 99 of 100 took no longer.", PEL_METRIC_GAUGE,
          p99 * 1e-3 },
        { "pelagos_cluster_worst_gap_seconds",
          "The longest time between two sealed frames here.", PEL_METRIC_GAUGE,
          c->worst_gap_ms * 1e-3 },
        { "pelagos_cluster_clock_offset_seconds",
          "This node's clock minus the master's.", PEL_METRIC_GAUGE,
          offset * 1e-3 },
        { "pelagos_cluster_gaps_total",
          "Frames that this node was not told of.", PEL_METRIC_COUNTER,
          (double)c->gaps },
        { "pelagos_cluster_differences_total",
          "States that were not the sealed ones.", PEL_METRIC_COUNTER,
          (double)c->differences },
        { "pelagos_cluster_unlisted_total",
          "What nodes said that there was no room for.", PEL_METRIC_COUNTER,
          (double)c->unlisted },
        { "pelagos_cluster_takeovers_total", "Times this node took over.",
          PEL_METRIC_COUNTER, (double)c->takeovers },
        { "pelagos_cluster_stepped_down_total",
          "Times this node stopped being the master.", PEL_METRIC_COUNTER,
          (double)c->stepped_down },
        { "pelagos_cluster_joins_total", "Times this node began anew.",
          PEL_METRIC_COUNTER, (double)c->joins },
        { "pelagos_cluster_coasted_total",
          "Pictures of moments that no frame was sealed for.",
          PEL_METRIC_COUNTER, (double)c->coasted },
        { "pelagos_cluster_places", "Views that are placed at a node.",
          PEL_METRIC_GAUGE, (double)placed },
        { "pelagos_cluster_places_elsewhere",
          "Of those, views that another node draws now.", PEL_METRIC_GAUGE,
          (double)elsewhere },
        { "pelagos_cluster_place_moves_total",
          "Times a placed view was drawn by another node than before.",
          PEL_METRIC_COUNTER, (double)c->placing.moves },
        { "pelagos_cluster_store_attempts_total", "Requests to the store.",
          PEL_METRIC_COUNTER, (double)attempts },
        { "pelagos_cluster_store_failures_total",
          "Requests that it did not answer.", PEL_METRIC_COUNTER,
          (double)failures },
    };
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++) {
        pel_metric(page, samples[i].name, samples[i].type, samples[i].help,
                   NULL, samples[i].value);
    }
}
