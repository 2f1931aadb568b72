/* The fields of the cascades at the moments that queries ask about: a
 * cache that the next query finds, filled by all threads that wait for the
 * same moment. Its contents do not depend on the order of the queries. */
#pragma once

#include <stdbool.h>

#include "ocean/cascade.h"

struct pel_fields_cache;

bool pel_fields_cache_init(struct pel_fields_cache **out); /* false: memory */
void pel_fields_cache_finish(struct pel_fields_cache *cache); /* NULL allowed */

/* How much of struct pel_cascade_fields is wanted; each with those before. */
enum pel_fields_depth {
    PEL_FIELDS_NONE,
    PEL_FIELDS_REST, /* displacement, slopes, fold */
    PEL_FIELDS_VELOCITY,
    PEL_FIELDS_SURGE,
    PEL_FIELDS_DEPTHS,
    PEL_FIELDS_BREAKING = PEL_FIELDS_DEPTHS, /* by itself: `breaking` alone */
};

struct pel_kept_fields; /* of one moment */

/* The fields at time_s, kept or computed: a cascade at a time by each thread
 * that is in this call for the same moment. Any thread; NO_MEMORY. Give it
 * back. */
PEL_CHECK enum pel_err pel_fields_take(const struct pel_cascades *c,
                                       double time_s,
                                       enum pel_fields_depth depth,
                                       struct pel_kept_fields **out);
const struct pel_cascade_fields *
pel_fields_of(const struct pel_kept_fields *kept);
void pel_fields_give(const struct pel_cascades *c,
                     struct pel_kept_fields *kept);

/* Computes what is missing of the fields at time_s, to be kept, cascade by
 * cascade while go_on(user), leaving out what another thread computes now;
 * true: they are complete. Any thread. */
bool pel_fields_prepare(const struct pel_cascades *c, double time_s,
                        enum pel_fields_depth depth, bool (*go_on)(void *user),
                        void *user);

/* These moments, at most PEL_SEA_HELD and none twice, are kept beside those
 * that were asked for last, until others are held or nobody has asked for them
 * for as long as for others. Any thread. */
void pel_fields_hold(const struct pel_cascades *c, const double *times_s,
                     int count);

/* Gives back the fields of moments, of all seas, that nobody has asked for
 * since before_ns (pel_now_ns), 10 to 16 MB each. Any thread. */
void pel_fields_forget(int64_t before_ns);

/* pel_sea_query (moving: pel_sea_query_moving) and pel_sea_displace over the
 * cascades; abort without memory for the fields of one moment (about 15 MB). */
void pel_cascades_query(const struct pel_cascades *c,
                        const struct pel_vec2 *points, size_t n, double time_s,
                        bool moving, struct pel_surface_sample *out);
struct pel_vec3 pel_cascades_displace(const struct pel_cascades *c, double x_m,
                                      double y_m, double time_s);
