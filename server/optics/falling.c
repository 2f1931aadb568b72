#include "optics/falling.h"

#include <math.h>

#include "base/hash.h"
#include "optics/rain.h"

#define RAIN_KINDS PEL_FALL_DROPS
#define SNOW_KINDS PEL_FALL_FLAKES
_Static_assert(RAIN_KINDS + SNOW_KINDS == PEL_FALL_KINDS, "one each");

#define LARGEST_DROP_MM 6.0
#define LARGEST_FLAKE_MM 12.0
#define FAINTEST 4e-4 /* deviation of a shell's cover */
/* Squares of the drops or flakes that a cell has at most. */
#define MOST_DROPS 2.0
#define MOST_FLAKES 3.0
#define BLUR 0.4375 /* 7/16: a bump's half-width squared by a disc's d² */

double pel_drop_speed(double d)
{
    return fmax(9.65 - 10.3 * exp(-0.6 * d), 0.3);
}

double pel_flake_speed(double melted)
{
    return 0.98 * pow(melted, 0.31);
}

/* Means of x over `count` parts of x^power e^-x that are equal. */
static void parts_of(int power, int count, double mean[])
{
    const double step = 0.02, most = 20;
    double all = 0, sum = 0;
    for (int i = 0; i < power; i++) { /* the factorial */
        all = (all > 0 ? all : 1) * (i + 1);
    }
    for (int i = 0; i < count; i++) {
        mean[i] = 0;
    }
    for (double x = 0.5 * step; x < most; x += step) {
        double here = pow(x, power) * exp(-x) * step / all;
        int i = (int)((sum + 0.5 * here) * count);
        mean[i < count ? i : count - 1] += here * count * x;
        sum += here;
    }
}

static void place_axis(const struct pel_fall_desc *d, struct pel_fall_kind *k)
{
    const struct pel_vec3 past = {
        d->wind_mps * cos(d->wind_to_rad) - d->eye_mps.x,
        d->wind_mps * sin(d->wind_to_rad) - d->eye_mps.y,
        -k->speed_mps - d->eye_mps.z
    };
    k->past_mps = fmax(sqrt(pel_vec3_dot(past, past)), 1e-3);
    k->axis = k->past_mps > 1e-3 ? pel_vec3_scale(past, 1 / k->past_mps)
                                 : (struct pel_vec3){ 0, 0, -1 };
    k->streak_m = k->past_mps * d->shutter_s;
    /* The east's part normal to it, which changes little as it tilts. */
    struct pel_vec3 east = { 1, 0, 0 };
    if (fabs(k->axis.x) > 0.999) {
        east = (struct pel_vec3){ 0, 1, 0 };
    }
    k->side = pel_vec3_normalize(pel_vec3_add(
        east, pel_vec3_scale(k->axis, -pel_vec3_dot(east, k->axis))));
}

/* Half the width of what a drop or flake looks like without motion, squared:
 * its own and the lens's blur. */
static double still_m2(const struct pel_fall_kind *k)
{
    return BLUR *
           (k->diameter_m * k->diameter_m + PEL_FALL_LENS_M * PEL_FALL_LENS_M);
}

/* Without its chance and weight; returns the drops of a cell. */
static double shell_of(const struct pel_fall_kind *k, double near_m,
                       struct pel_fall_shell *out)
{
    const double middle_m = 1.5 * near_m;
    double number =
        k->extinction / (0.25 * PEL_PI * k->diameter_m * k->diameter_m);
    double across_m = PEL_FALL_ACROSS * sqrt(still_m2(k)) * fmax(near_m, 1);
    out->near_m = near_m;
    out->columns = (int)fmax(round(2 * PEL_PI * middle_m / across_m), 8);
    across_m = 2 * PEL_PI * middle_m / out->columns;
    out->cell_m = 2 * k->streak_m + across_m;
    return number * near_m * across_m * out->cell_m;
}

/* Of so many drops of a cell each streak has what they deviate from their
 * mean; the rest is left to that. */
static double share_of(double drops)
{
    return 1 / fmax(sqrt(drops), 1);
}

/* Of the cover of pixels. */
static double deviation(const struct pel_fall_kind *k,
                        const struct pel_fall_shell *s, double drops,
                        double pixel_rad)
{
    double across_m = 3 * PEL_PI * s->near_m / s->columns;
    double pixel_m = 1.5 * s->near_m * pixel_rad;
    double half_m = sqrt(still_m2(k) + PEL_FALL_PIXEL * pixel_m * pixel_m);
    double area = 0.25 * PEL_PI * k->diameter_m * k->diameter_m;
    return area *
           sqrt(0.714 * drops /
                (half_m * fmax(k->streak_m, half_m) * across_m * s->cell_m));
}

/* As far as single ones are told from the next and seen. */
static double far_of(const struct pel_fall_kind *k, double pixel_rad,
                     double *share)
{
    double most = k->flake ? MOST_FLAKES : MOST_DROPS;
    double far_m = PEL_FALL_NEAREST_M;
    for (; far_m < PEL_FALL_FARTHEST_M; far_m *= 2) {
        struct pel_fall_shell s;
        double drops = shell_of(k, far_m, &s);
        if (drops > most * most ||
            deviation(k, &s, drops, pixel_rad) < FAINTEST) {
            break;
        }
        *share = share_of(drops);
    }
    return far_m;
}

static void place_shells(const struct pel_fall_desc *d, int kind,
                         struct pel_fall_kind *k)
{
    double share = 0;
    k->far_m = far_of(k, d->pixel_rad, &share);
    k->covers = share * k->extinction *
                (0.5 * (1 + PEL_FALL_FADES) * k->far_m - PEL_FALL_NEAREST_M);
    double near_m = PEL_FALL_INMOST_M;
    for (int i = 0; share > 0 && near_m < k->far_m; i++, near_m *= 2) {
        struct pel_fall_shell *s = &k->shells[k->shell_count++];
        double drops = share * shell_of(k, near_m, s);
        double across_m = 3 * PEL_PI * near_m / s->columns;
        s->chance = fmin(drops, 1);
        s->weight = fmax(drops, 1);
        s->spread_m2 =
            drops > 1 ? 0.01 * across_m * across_m * (1 - 1 / drops) : 0;
        s->seed = (uint32_t)pel_hash_mix(
            (uint64_t)d->seed << 16 | (uint64_t)(kind * PEL_FALL_SHELLS + i));
    }
}

static void add_kind(const struct pel_fall_desc *d, struct pel_fall_kind k,
                     int kind, struct pel_fall_plan *out)
{
    if (d->only && d->only != kind + 1) {
        return;
    }
    double turns = d->time_s / PEL_FALL_LIFE_S + 0.37 * kind;
    k.turn = turns - 65536 * floor(turns / 65536);
    place_axis(d, &k);
    place_shells(d, kind, &k);
    out->kinds[out->count++] = k;
}

void pel_fall_plan(const struct pel_fall_desc *d, struct pel_fall_plan *out)
{
    double x[PEL_FALL_KINDS];
    *out = (struct pel_fall_plan){ 0 };
    parts_of(2, RAIN_KINDS, x);
    for (int i = 0; i < RAIN_KINDS && d->rain_mm_h > 0; i++) {
        double mm =
            fmin(x[i] / (4.1 * pow(d->rain_mm_h, -0.21)), LARGEST_DROP_MM);
        add_kind(d,
                 (struct pel_fall_kind){
                     .diameter_m = 1e-3 * mm,
                     .speed_mps = pel_drop_speed(mm),
                     .extinction =
                         0.5 * pel_rain_extinction(d->rain_mm_h) / RAIN_KINDS },
                 i, out);
    }
    parts_of(3, SNOW_KINDS, x);
    for (int i = 0; i < SNOW_KINDS && d->snow_mm_h > 0; i++) {
        double melted = x[i] / (2.29 * pow(d->snow_mm_h, -0.45));
        double mm = fmin(sqrt(pow(melted, 3) / 0.17), LARGEST_FLAKE_MM);
        add_kind(d,
                 (struct pel_fall_kind){
                     .flake = true,
                     .diameter_m = 1e-3 * mm,
                     .speed_mps = pel_flake_speed(melted),
                     .extinction =
                         0.5 * pel_snow_extinction(d->snow_mm_h) / SNOW_KINDS },
                 RAIN_KINDS + i, out);
    }
}

/* --- what a picture shows ------------------------------------------------- */

#define BORDER 64 /* directions */
#define SLACK 0.02
#define STEEPEST 40.0 /* nearer to the axis nothing is drawn */
#define BESIDE 0.15   /* tangent: what is so near to the axis counts as it */

static struct pel_vec3 border(const struct pel_mat3 *m, const double low[2],
                              const double high[2], int i)
{
    double s = 4.0 * i / BORDER, u = s - floor(s);
    const struct pel_vec3 at = { s < 1   ? low[0] + u * (high[0] - low[0])
                                 : s < 2 ? high[0]
                                 : s < 3 ? high[0] - u * (high[0] - low[0])
                                         : low[0],
                                 s < 1   ? low[1]
                                 : s < 2 ? low[1] + u * (high[1] - low[1])
                                 : s < 3 ? high[1]
                                         : high[1] - u * (high[1] - low[1]),
                                 -1 };
    return pel_mat3_apply(m, at);
}

static bool in_sight(const struct pel_mat3 *m, const double low[2],
                     const double high[2], struct pel_vec3 to)
{
    double ahead = -pel_vec3_dot(to, m->z);
    double x = pel_vec3_dot(to, m->x), y = pel_vec3_dot(to, m->y);
    return ahead > 0 && x > (low[0] - BESIDE) * ahead &&
           x < (high[0] + BESIDE) * ahead && y > (low[1] - BESIDE) * ahead &&
           y < (high[1] + BESIDE) * ahead;
}

struct pel_fall_range pel_fall_range(const struct pel_fall_kind *k,
                                     const struct pel_mat3 *m, double tan_left,
                                     double tan_right, double tan_bottom,
                                     double tan_top)
{
    double grow_x = SLACK * (tan_right - tan_left) + 1e-3,
           grow_y = SLACK * (tan_top - tan_bottom) + 1e-3;
    const double low[2] = { tan_left - grow_x, tan_bottom - grow_y },
                 high[2] = { tan_right + grow_x, tan_top + grow_y };
    const struct pel_vec3 other = pel_vec3_cross(k->axis, k->side);
    double first = 0, least = 0, most = 0, turn = 0;
    struct pel_fall_range r = { 0, 1, STEEPEST, -STEEPEST };
    for (int i = 0; i < BORDER; i++) {
        struct pel_vec3 to = border(m, low, high, i);
        double x = pel_vec3_dot(to, k->side), y = pel_vec3_dot(to, other);
        double slope = pel_vec3_dot(to, k->axis) / fmax(hypot(x, y), 1e-6);
        double now = atan2(y, x) / (2 * PEL_PI) + 0.5;
        turn = i ? turn + remainder(now - turn, 1) : now;
        first = i ? first : now;
        least = fmin(least, turn - first);
        most = fmax(most, turn - first);
        r.slope_first = fmin(r.slope_first, slope);
        r.slope_last = fmax(r.slope_last, slope);
    }
    bool down = in_sight(m, low, high, k->axis),
         up = in_sight(m, low, high, pel_vec3_scale(k->axis, -1));
    double slack[2] = { SLACK * (1 + 5 * fabs(r.slope_first)),
                        SLACK * (1 + 5 * fabs(r.slope_last)) };
    r.slope_first = up ? -STEEPEST : fmax(r.slope_first - slack[0], -STEEPEST);
    r.slope_last = down ? STEEPEST : fmin(r.slope_last + slack[1], STEEPEST);
    if (!up && !down) {
        r.turn_first = first + least - 0.5 * SLACK;
        r.turn_first -= floor(r.turn_first);
        r.turns = fmin(most - least + SLACK, 1);
    }
    return r;
}
