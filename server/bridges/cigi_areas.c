/* Regions with a wind of their own, as areas of the sea: seen from outside they
 * are rougher or calmer. */
#include <glib.h>
#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"

#define ARC 3 /* corners of a rounded one */
#define LEAST_CHANGE 0.02
#define LEAST_WIND_MPS 0.5
#define LARGEST_M 1e5
#define HIGHEST 2.0 /* factor of sea.areas */

static bool wind_of(const struct pel_cigi_conditions *c, double *mps)
{
    *mps = c->has_layer_wind ? c->layer_wind_mps : c->wind_mps;
    return c->has_layer_wind || c->has_wind;
}

/* The wind of this edit, where the first view is. */
static double wind_here(const struct pel_cigi_edit *edit)
{
    return edit->sea.has_wind_speed ? edit->sea.wind_speed
                                    : edit->scene->sea->wind_speed;
}

/* A rectangle with corners rounded off outside, a side of x along the
 * rotation; out to the middle of the transition. */
static void outline(const struct pel_cigi_region *r, struct pel_cigi_area *to)
{
    double turn = r->rotation_deg * PEL_DEG, s = sin(turn), c = cos(turn);
    double round = fmax(r->radius_m, 0) + 0.5 * r->transition_m;
    int each = round > 0 ? ARC : 1;
    GString *text = g_string_new(NULL);
    for (int i = 0; i < 4 * each; i++) {
        int corner = i / each;
        double angle = 0.5 * PEL_PI * (corner + (i % each) / fmax(each - 1, 1));
        double along = (corner == 0 || corner == 3 ? 0.5 : -0.5) * r->x_m +
                       round * cos(angle);
        double across = (corner < 2 ? 0.5 : -0.5) * r->y_m + round * sin(angle);
        g_string_append_printf(text, "%s%.0f %.0f", i ? ", " : "",
                               along * s + across * c, along * c - across * s);
    }
    g_strlcpy(to->corners, text->str, sizeof to->corners);
    g_string_free(text, TRUE);
}

/* False: it is none. Slopes of short waves have a variance that grows as the
 * wind (Cox and Munk 1954). */
static bool area_of(const struct pel_cigi_edit *edit,
                    const struct pel_cigi_region *r, struct pel_cigi_area *to)
{
    double place[3] = { r->latitude, r->longitude, 0 }, mps;
    double here = wind_here(edit);
    double size = fmax(r->x_m, r->y_m) + fmax(r->radius_m, 0) + r->transition_m;
    struct pel_vec3 centre;
    *to = (struct pel_cigi_area){ 0 };
    if (!r->used || !r->active || here < LEAST_WIND_MPS || size > LARGEST_M ||
        !wind_of(&r->conditions, &mps) ||
        !pel_cigi_place(edit->snapshot, edit->time_s, false, 0, place,
                        &centre) ||
        hypot(centre.x, centre.y) > 1e6) {
        return false;
    }
    double factor = fmin(sqrt(mps / here), HIGHEST);
    to->factor = floor(factor * 100 + 0.5) / 100;
    to->east_m = centre.x;
    to->north_m = centre.y;
    to->edge_m = pel_clamp(r->transition_m, 1, 1e4);
    if (r->x_m > 0 && r->y_m > 0) {
        outline(r, to);
    } else {
        to->radius_m = fmax(r->radius_m, 0) + 0.5 * r->transition_m;
    }
    return fabs(to->factor - 1) > LEAST_CHANGE &&
           (to->corners[0] || to->radius_m >= 1);
}

static void put_area(struct pel_cigi_edit *edit, const Pelagos__Area *area)
{
    size_t n = edit->sea.n_areas;
    if (n < PEL_SEA_MAX_AREAS) {
        edit->area[n] = *area;
        edit->area_list[n] = &edit->area[n];
        edit->sea.n_areas = n + 1;
        edit->state.sea = &edit->sea;
    }
}

void pel_cigi_apply_areas(struct pel_cigi_edit *edit)
{
    struct pel_cigi_world *world = edit->world;
    struct pel_cigi_area now[PEL_CIGI_REGIONS];
    size_t count = 0;
    memset(now, 0, sizeof now);
    for (size_t i = 0; i < PEL_CIGI_REGIONS && count < PEL_SEA_MAX_AREAS; i++) {
        count += area_of(edit, &world->regions[i], &now[count]) ? 1 : 0;
    }
    if (count == world->area_count &&
        memcmp(now, world->areas, count * sizeof *now) == 0) {
        return;
    }
    /* Those of others come first in the list. */
    size_t others = edit->scene->sea->n_areas;
    others -= others < world->area_count ? others : world->area_count;
    for (size_t i = 0; i < others; i++) {
        put_area(edit, edit->scene->sea->areas[i]);
    }
    world->area_count = count;
    memcpy(world->areas, now, count * sizeof *now);
    for (size_t i = 0; i < count; i++) {
        Pelagos__Area area = PELAGOS__AREA__INIT;
        struct pel_cigi_area *from = &world->areas[i];
        area.has_east = area.has_north = area.has_factor = area.has_edge = true;
        area.east = from->east_m;
        area.north = from->north_m;
        area.factor = from->factor;
        area.edge = from->edge_m;
        area.has_radius = from->radius_m > 0;
        area.radius = from->radius_m;
        area.corners = from->corners[0] ? from->corners : NULL;
        put_area(edit, &area);
    }
    if (edit->sea.n_areas == 0) {
        pel_cigi_edit_remove(edit, "sea.areas");
    }
}
