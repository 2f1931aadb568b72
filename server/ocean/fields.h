/* The fields of the cascades kept for the moments that queries ask about. */
#pragma once

#include <stdbool.h>

#include "ocean/cascade.h"

struct pel_fields_cache;

bool pel_fields_cache_init(struct pel_fields_cache **out); /* false: memory */
void pel_fields_cache_finish(struct pel_fields_cache *cache); /* NULL allowed */

struct pel_kept_fields {
    struct pel_cascade_fields *fields;
    unsigned users;
    bool stale; /* out of the cache: its last user frees it */
    uint64_t used;
};

/* The fields at time_s, from the cache or computed; NO_MEMORY. Any thread;
 * others that want the same moment wait for it. Give it back. */
PEL_CHECK enum pel_err pel_fields_take(const struct pel_cascades *c,
                                       double time_s,
                                       struct pel_kept_fields **out);
void pel_fields_give(const struct pel_cascades *c,
                     struct pel_kept_fields *kept);

/* The cascades whose displacement is the acceleration of those of `c`: every
 * amplitude times −ω². Made when first asked for, kept with `c`; NO_MEMORY. */
PEL_CHECK enum pel_err pel_fields_second(const struct pel_cascades *c,
                                         const struct pel_cascades **out);

/* pel_sea_query (moving: pel_sea_query_moving) and pel_sea_displace over the
 * cascades; abort without memory for the fields of one moment (about 20 MB). */
void pel_cascades_query(const struct pel_cascades *c,
                        const struct pel_vec2 *points, size_t n, double time_s,
                        bool moving, struct pel_surface_sample *out);
struct pel_vec3 pel_cascades_displace(const struct pel_cascades *c, double x_m,
                                      double y_m, double time_s);
