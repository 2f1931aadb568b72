#include "bridges/nmea_fleet.h"

#include <glib.h>
#include <math.h>

#include "base/vec.h"
#include "bridges/nmea_out.h"

#define SECOND_NS 1000000000LL
#define STALE_NS (360 * SECOND_NS)
#define STAY_NS (10 * SECOND_NS)
#define LATER_S 30.0
#define NEARER 0.81 /* of the square of a distance: a tenth of it less */
#define EARTH_M 6371000.0

struct pel_nmea_fleet {
    size_t capacity, count;
    struct pel_nmea_known *list;
    GHashTable *places; /* from &known->key to known */
    bool has_own;
    double latitude, longitude, shrink; /* of own ship; cos of its latitude */
};

struct pel_nmea_fleet *pel_nmea_fleet_create(size_t capacity)
{
    struct pel_nmea_fleet *fleet = g_new0(struct pel_nmea_fleet, 1);
    fleet->capacity = capacity;
    fleet->list = g_new0(struct pel_nmea_known, capacity);
    fleet->places = g_hash_table_new(g_int64_hash, g_int64_equal);
    return fleet;
}

void pel_nmea_fleet_destroy(struct pel_nmea_fleet *fleet)
{
    if (fleet) {
        g_hash_table_destroy(fleet->places);
        g_free(fleet->list);
        g_free(fleet);
    }
}

struct pel_nmea_known *pel_nmea_fleet_find(struct pel_nmea_fleet *fleet,
                                           uint64_t key)
{
    return g_hash_table_lookup(fleet->places, &key);
}

size_t pel_nmea_fleet_count(const struct pel_nmea_fleet *fleet)
{
    return fleet->count;
}

static void forget(struct pel_nmea_fleet *fleet, struct pel_nmea_known *known)
{
    g_hash_table_remove(fleet->places, &known->key);
    *known = (struct pel_nmea_known){ 0 };
    fleet->count--;
}

void pel_nmea_fleet_expire(struct pel_nmea_fleet *fleet, int64_t life_ns,
                           int64_t now_ns)
{
    for (size_t i = 0; i < fleet->capacity; i++) {
        struct pel_nmea_known *known = &fleet->list[i];
        if (known->key && now_ns - known->heard_ns >= life_ns) {
            forget(fleet, known);
        }
    }
}

/* --- how far ---------------------------------------------------------------
 */

/* Square of the angle to own ship, flat around it: an order is all that is
 * wanted, and there are thousands. */
static double far_of(const struct pel_nmea_fleet *fleet, double latitude,
                     double longitude)
{
    double north = latitude - fleet->latitude;
    double east = fabs(longitude - fleet->longitude);
    east = (east > 180 ? 360 - east : east) * fleet->shrink;
    return north * north + east * east;
}

static void rank(const struct pel_nmea_fleet *fleet,
                 struct pel_nmea_known *known, int64_t now_ns)
{
    double age_s = (double)(now_ns - known->heard_ns) * 1e-9;
    known->far =
        !fleet->has_own || now_ns - known->heard_ns > STALE_NS
            ? 1e9 + age_s
            : far_of(fleet, known->report.latitude, known->report.longitude);
}

/* Whether a comes before b; of equals the smaller key. */
static bool before(const struct pel_nmea_known *a,
                   const struct pel_nmea_known *b)
{
    return a->far < b->far || (a->far == b->far && a->key < b->key);
}

/* --- reports ----------------------------------------------------------------
 */

static struct pel_nmea_known *place_for(struct pel_nmea_fleet *fleet,
                                        const struct pel_nmea_target_report *r,
                                        int64_t now_ns)
{
    struct pel_nmea_known *last = NULL;
    for (size_t i = 0; i < fleet->capacity; i++) {
        struct pel_nmea_known *known = &fleet->list[i];
        if (known->key == 0) {
            return known;
        }
        rank(fleet, known, now_ns);
        if (!known->drawn && (!last || before(last, known))) {
            last = known;
        }
    }
    double far = fleet->has_own ? far_of(fleet, r->latitude, r->longitude) : 0;
    if (!last || last->far <= far) {
        return NULL;
    }
    forget(fleet, last);
    return last;
}

static void keep(double *value, double told)
{
    *value = isnan(told) ? *value : told;
}

static void merge(struct pel_nmea_target_report *into,
                  const struct pel_nmea_target_report *r, bool is_new)
{
    if (is_new) {
        *into = *r;
        return;
    }
    int status = r->status >= 0 ? r->status : into->status;
    bool keeps_place = r->coarse && !into->coarse;
    double latitude = into->latitude, longitude = into->longitude;
    double altitude = into->altitude, heading = into->heading;
    keep(&altitude, r->altitude);
    keep(&heading, r->heading);
    *into = *r;
    into->status = status;
    into->altitude = altitude;
    into->heading = heading;
    if (keeps_place) {
        into->latitude = latitude;
        into->longitude = longitude;
        into->coarse = false;
    }
}

struct pel_nmea_known *
pel_nmea_fleet_take(struct pel_nmea_fleet *fleet, uint64_t key,
                    const struct pel_nmea_target_report *report, int64_t now_ns)
{
    struct pel_nmea_known *known = pel_nmea_fleet_find(fleet, key);
    bool is_new = !known;
    if (isnan(report->latitude) || isnan(report->longitude) ||
        fabs(report->latitude) > 90) {
        return known;
    }
    if (is_new) {
        known = place_for(fleet, report, now_ns);
        if (!known) {
            return NULL;
        }
        known->key = key;
        g_hash_table_insert(fleet->places, &known->key, known);
        fleet->count++;
    }
    known->heard_ns = now_ns;
    merge(&known->report, report, is_new);
    return known;
}

struct pel_nmea_target_report
pel_nmea_fleet_reckon(const struct pel_nmea_known *known, int64_t now_ns)
{
    struct pel_nmea_target_report r = known->report;
    double way_m = r.speed * (double)(now_ns - known->heard_ns) * 1e-9;
    double course = r.course * PEL_DEG;
    double shrink = cos(r.latitude * PEL_DEG);
    if (way_m > 0 && way_m < 100000 && !isnan(course) && shrink > 0.01) {
        r.latitude = pel_clamp(
            r.latitude + way_m * cos(course) / EARTH_M / PEL_DEG, -90, 90);
        r.longitude += way_m * sin(course) / EARTH_M / PEL_DEG / shrink;
        r.longitude -= 360 * floor((r.longitude + 180) / 360);
    }
    return r;
}

/* --- the choice -------------------------------------------------------------
 */

/* Puts one into a list of the first by `order`, which is sorted. */
static void insert(struct pel_nmea_known **list, size_t *count,
                   struct pel_nmea_known *known,
                   bool (*order)(const struct pel_nmea_known *,
                                 const struct pel_nmea_known *))
{
    size_t at = *count;
    while (at > 0 && order(known, list[at - 1])) {
        at--;
    }
    if (at == PEL_NMEA_SWAPS) {
        return;
    }
    *count += *count < PEL_NMEA_SWAPS;
    for (size_t i = *count - 1; i > at; i--) {
        list[i] = list[i - 1];
    }
    list[at] = known;
}

static bool after(const struct pel_nmea_known *a,
                  const struct pel_nmea_known *b)
{
    return before(b, a);
}

static bool gives_way(const struct pel_nmea_fleet *fleet,
                      const struct pel_nmea_known *drawn,
                      const struct pel_nmea_known *other)
{
    return fleet->has_own && drawn->far < 1e9
               ? other->far < drawn->far * NEARER
               : other->far < drawn->far - LATER_S;
}

static void settle_own(struct pel_nmea_fleet *fleet,
                       const struct pel_nmea_report *own)
{
    fleet->has_own = own != NULL;
    if (own) {
        fleet->latitude = own->latitude;
        fleet->longitude = own->longitude;
        fleet->shrink = cos(own->latitude * PEL_DEG);
    }
}

void pel_nmea_fleet_choose(struct pel_nmea_fleet *fleet,
                           const struct pel_nmea_report *own,
                           const struct pel_nmea_drawn *drawn,
                           size_t drawn_count, size_t room, int64_t now_ns,
                           struct pel_nmea_choice *out)
{
    struct pel_nmea_known *worst[PEL_NMEA_SWAPS], *best[PEL_NMEA_SWAPS];
    size_t worst_count = 0, best_count = 0;
    *out = (struct pel_nmea_choice){ 0 };
    settle_own(fleet, own);
    for (size_t i = 0; i < fleet->capacity; i++) {
        fleet->list[i].drawn = false;
    }
    for (size_t i = 0; i < drawn_count; i++) {
        struct pel_nmea_known *known = pel_nmea_fleet_find(fleet, drawn[i].key);
        if (known) {
            known->drawn = true;
            rank(fleet, known, now_ns);
        }
        if (known && now_ns - drawn[i].since_ns >= STAY_NS) {
            insert(worst, &worst_count, known, after);
        }
    }
    for (size_t i = 0; i < fleet->capacity; i++) {
        struct pel_nmea_known *known = &fleet->list[i];
        if (known->key && !known->drawn) {
            rank(fleet, known, now_ns);
            insert(best, &best_count, known, before);
        }
    }
    for (size_t i = 0; i < best_count; i++) {
        if (room > 0) {
            room--;
        } else if (out->leave_count < worst_count &&
                   gives_way(fleet, worst[out->leave_count], best[i])) {
            out->leave[out->leave_count] = worst[out->leave_count]->key;
            out->leave_count++;
        } else {
            break;
        }
        out->enter[out->enter_count++] = best[i];
    }
}
