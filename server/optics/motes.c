#include "optics/motes.h"

#include <math.h>
#include <stdbool.h>

#include "base/hash.h"

#define DRIFTS_MPS 0.02 /* with the wind's stir */
#define DAY_S 86400.0
#define LEFT 3.0 /* optical depths: a twentieth of the light is left */
#define FARTHEST_M 60.0
/* Cells that are looked through for a picture. */
#define MOST_CELLS 8e4 /* PEL_MOTE_MOST: all of them may be seen */

double pel_motes_larger(const struct pel_mote_water *w, double diameter_m)
{
    double s = 1 - w->exponent, least = pow(PEL_MOTE_LEAST_M, s),
           most = pow(w->largest_m, s);
    double d = fmin(fmax(diameter_m, PEL_MOTE_LEAST_M), w->largest_m);
    return w->per_m3 * (pow(d, s) - most) / (least - most);
}

double pel_mote_sinks(double diameter_m)
{
    return 50.0 / DAY_S * pow(1e3 * diameter_m, 0.26);
}

/* An octave of diameters, and the box about what of it may be seen. */
struct octave {
    double first_m, last_m;
    double per_m3, side_m; /* of a cell */
    double reach_m;
    double drift[3]; /* of its cells, m */
    double low[3], high[3];
};

static void box_of(const struct pel_mote_view *v, struct octave *o)
{
    for (int i = 0; i < 3; i++) {
        o->low[i] = o->high[i] = 0.0;
    }
    for (int i = 0; i < 4; i++) {
        struct pel_vec3 to = { i & 1 ? v->tan_right : v->tan_left,
                               i & 2 ? v->tan_top : v->tan_bottom, -1.0 };
        to = pel_vec3_scale(pel_mat3_apply(&v->world_from_camera, to),
                            o->reach_m);
        const double at[3] = { to.x, to.y, to.z };
        for (int k = 0; k < 3; k++) {
            o->low[k] = fmin(o->low[k], at[k]);
            o->high[k] = fmax(o->high[k], at[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        o->low[k] -= v->sways_m;
        o->high[k] += v->sways_m;
    }
}

static double cells_of(const struct octave *o)
{
    double cells = 1;
    for (int k = 0; k < 3; k++) {
        cells *= (o->high[k] - o->low[k]) / o->side_m + 1;
    }
    return cells;
}

/* False: beyond the largest. Of small ones in high waves there may be too many
 * to look through: they have none. */
static bool octave_of(const struct pel_mote_water *w,
                      const struct pel_mote_view *v, int i, double reach,
                      struct octave *o)
{
    o->first_m = PEL_MOTE_LEAST_M * ldexp(1.0, i);
    o->last_m = fmin(2.0 * o->first_m, w->largest_m);
    if (o->first_m >= o->last_m) {
        return false;
    }
    o->per_m3 =
        pel_motes_larger(w, o->first_m) - pel_motes_larger(w, o->last_m);
    o->side_m = pow(o->per_m3, -1.0 / 3.0);
    o->reach_m = fmin(reach * o->last_m,
                      fmin(LEFT / fmax(v->extinction, 1e-3), FARTHEST_M));
    double sunk = pel_mote_sinks(sqrt(o->first_m * o->last_m)) * v->time_s;
    o->drift[0] = DRIFTS_MPS * v->time_s * cos(v->wind_to_rad);
    o->drift[1] = DRIFTS_MPS * v->time_s * sin(v->wind_to_rad);
    o->drift[2] = -sunk;
    box_of(v, o);
    if (cells_of(o) > 0.5 * MOST_CELLS) {
        o->reach_m = -1.0;
    }
    return true;
}

double pel_mote_reach(const struct pel_mote_water *w,
                      const struct pel_mote_view *v)
{
    const double all = PEL_MOTE_SEEN / v->pixel_rad;
    double reach = all;
    while (reach > 0.1 * all) {
        double cells = 0;
        struct octave o;
        bool dropped = false;
        for (int i = 0; octave_of(w, v, i, reach, &o); i++) {
            dropped = dropped || o.reach_m < 0;
            cells += o.reach_m < 0 ? 0 : cells_of(&o);
        }
        if (cells <= MOST_CELLS && !dropped) {
            break;
        }
        reach *= 0.85;
    }
    return reach;
}

static double part(uint64_t bits, int first)
{
    return ((double)(bits >> first & 0xffff) + 0.5) / 65536.0;
}

/* Between the planes of a view, or so near them that waves or the lens bring it
 * there. */
static bool may_show(const struct pel_mote_view *v, struct pel_vec3 p,
                     double reach_m)
{
    const struct pel_mat3 *m = &v->world_from_camera;
    double right = pel_vec3_dot(p, m->x), up = pel_vec3_dot(p, m->y),
           ahead = -pel_vec3_dot(p, m->z);
    double slack = v->sways_m + 2.0 * PEL_FALL_LENS_M + 0.02 * fabs(ahead);
    return ahead > -v->sways_m && ahead < reach_m + v->sways_m &&
           right > v->tan_left * ahead - slack * (1 + fabs(v->tan_left)) &&
           right < v->tan_right * ahead + slack * (1 + fabs(v->tan_right)) &&
           up > v->tan_bottom * ahead - slack * (1 + fabs(v->tan_bottom)) &&
           up < v->tan_top * ahead + slack * (1 + fabs(v->tan_top));
}

static size_t put_octave(const struct pel_mote_water *w,
                         const struct pel_mote_view *v, int number,
                         double reach, const struct octave *o,
                         struct pel_mote *out, size_t room)
{
    const double eye[3] = { v->eye.x, v->eye.y, v->eye.z };
    int64_t first[3], last[3];
    for (int k = 0; k < 3; k++) {
        double from = (eye[k] - o->drift[k]) / o->side_m;
        first[k] = (int64_t)floor(from + o->low[k] / o->side_m);
        last[k] = (int64_t)floor(from + o->high[k] / o->side_m);
    }
    double s = 1 - w->exponent, low = pow(o->first_m, s),
           high = pow(o->last_m, s);
    uint64_t key = pel_hash_mix((uint64_t)v->seed << 32 | (uint32_t)number);
    size_t count = 0;
    for (int64_t x = first[0]; x <= last[0]; x++) {
        uint64_t by_x = pel_hash_mix(key + (uint64_t)x);
        for (int64_t y = first[1]; y <= last[1]; y++) {
            uint64_t by_y = pel_hash_mix(by_x + (uint64_t)y);
            for (int64_t z = first[2]; z <= last[2] && count < room; z++) {
                uint64_t bits = pel_hash_mix(by_y + (uint64_t)z);
                const struct pel_vec3 p = {
                    ((double)x + part(bits, 0)) * o->side_m + o->drift[0] -
                        eye[0],
                    ((double)y + part(bits, 16)) * o->side_m + o->drift[1] -
                        eye[1],
                    ((double)z + part(bits, 32)) * o->side_m + o->drift[2] -
                        eye[2],
                };
                if (!may_show(v, p, o->reach_m)) {
                    continue;
                }
                double d = pow(low + (high - low) * part(bits, 48), 1 / s);
                double far = reach * d + v->sways_m;
                if (pel_vec3_dot(p, p) < far * far) {
                    out[count++] = (struct pel_mote){
                        { (float)p.x, (float)p.y, (float)p.z }, (float)d
                    };
                }
            }
        }
    }
    return count;
}

size_t pel_motes_seen(const struct pel_mote_water *w,
                      const struct pel_mote_view *v, struct pel_mote *out,
                      size_t room)
{
    double reach = pel_mote_reach(w, v);
    size_t count = 0;
    struct octave o;
    for (int i = 0; octave_of(w, v, i, reach, &o); i++) {
        if (o.reach_m > 0) {
            count += put_octave(w, v, i, reach, &o, out + count, room - count);
        }
    }
    return count;
}
