#include "ocean/areas.h"

#include <math.h>

static bool inside(double v, double lo, double hi)
{
    return v >= lo && v <= hi; /* false for NaN */
}

static bool area_ok(const struct pel_area_desc *a)
{
    bool ok = inside(a->east_m, -1e6, 1e6) && inside(a->north_m, -1e6, 1e6) &&
              (a->corner_count || inside(a->radius_m, 1, 1e5)) &&
              inside(a->edge_m, 1, 1e4) &&
              inside(a->factor, 0, PEL_AREA_MOST) &&
              inside(a->velocity_east_mps, -50, 50) &&
              inside(a->velocity_north_mps, -50, 50) && isfinite(a->time_s) &&
              (a->corner_count == 0 ||
               (a->corner_count >= 3 && a->corner_count <= PEL_AREA_CORNERS));
    for (int i = 0; ok && i < a->corner_count; i++) {
        ok = inside(a->corner[i].x, -1e5, 1e5) &&
             inside(a->corner[i].y, -1e5, 1e5);
    }
    return ok;
}

bool pel_areas_ok(const struct pel_sea_desc *d)
{
    bool ok = d->area_count >= 0 && d->area_count <= PEL_SEA_MAX_AREAS;
    for (int i = 0; ok && i < d->area_count; i++) {
        ok = area_ok(&d->area[i]);
    }
    return ok;
}

static double circle_distance(double radius, double x, double y,
                              struct pel_vec2 *away)
{
    double r = hypot(x, y);
    *away =
        r > 0 ? (struct pel_vec2){ x / r, y / r } : (struct pel_vec2){ 0, 0 };
    return r - radius;
}

static double polygon_distance(const struct pel_area_desc *area, double x,
                               double y, struct pel_vec2 *away)
{
    double least = INFINITY, sign = 1;
    for (int i = 0, j = area->corner_count - 1; i < area->corner_count;
         j = i++) {
        struct pel_vec2 a = area->corner[i], b = area->corner[j];
        double ex = b.x - a.x, ey = b.y - a.y, wx = x - a.x, wy = y - a.y;
        double length2 = ex * ex + ey * ey;
        double along =
            length2 > 0 ? pel_clamp((wx * ex + wy * ey) / length2, 0, 1) : 0;
        double dx = wx - along * ex, dy = wy - along * ey;
        double d2 = dx * dx + dy * dy;
        if (d2 < least) {
            least = d2;
            *away = (struct pel_vec2){ dx, dy };
        }
        /* Even or odd edges to the east. */
        if ((a.y > y) != (b.y > y) && x < a.x + ex * (y - a.y) / ey) {
            sign = -sign;
        }
    }
    double d = sqrt(least);
    double scale = d > 0 ? sign / d : 0;
    away->x *= scale;
    away->y *= scale;
    return sign * d;
}

double pel_area_distance(const struct pel_area_desc *area, double x, double y,
                         struct pel_vec2 *away)
{
    return area->corner_count ? polygon_distance(area, x, y, away)
                              : circle_distance(area->radius_m, x, y, away);
}

struct pel_vec2 pel_area_place(const struct pel_area_desc *area, double time_s)
{
    double since = time_s - area->time_s;
    return (struct pel_vec2){ area->east_m + area->velocity_east_mps * since,
                              area->north_m +
                                  area->velocity_north_mps * since };
}

double pel_areas_factor(const struct pel_sea_desc *d, double x, double y,
                        double time_s, struct pel_vec2 *slope)
{
    double product = 1;
    struct pel_vec2 sum = { 0, 0 };
    for (int i = 0; i < d->area_count; i++) {
        const struct pel_area_desc *a = &d->area[i];
        struct pel_vec2 at = pel_area_place(a, time_s), away = { 0, 0 };
        double out = pel_area_distance(a, x - at.x, y - at.y, &away);
        double t = pel_clamp(out / a->edge_m + 0.5, 0, 1);
        double more = a->factor - 1.0;
        double here = 1.0 + more * (1.0 - t * t * (3.0 - 2.0 * t));
        double rate = -more * 6.0 * t * (1.0 - t) / a->edge_m;
        /* Of the product so far and this one. */
        sum.x = sum.x * here + product * rate * away.x;
        sum.y = sum.y * here + product * rate * away.y;
        product *= here;
    }
    if (product > PEL_AREA_MOST) {
        product = PEL_AREA_MOST;
        sum = (struct pel_vec2){ 0, 0 };
    }
    if (slope) {
        *slope = sum;
    }
    return product;
}
