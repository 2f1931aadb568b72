#include "optics/nightsky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LAYER_M 90e3
#define ECLIPTIC (23.4392911 * PEL_DEG)

/* Leinert et al. 1998, table 16: rows by the longitude from the Sun, columns by
 * latitude. Within 15° of the Sun the nearest known. */
static const double zodiacal_at[] = { 0,   5,   10,  15,  20, 25, 30,
                                      35,  40,  45,  60,  75, 90, 105,
                                      120, 135, 150, 165, 180 };
static const double zodiacal_latitude[] = { 0,  5,  10, 15, 20, 25,
                                            30, 45, 60, 75, 90 };
#define ZODIACAL_ROWS (sizeof zodiacal_at / sizeof *zodiacal_at)
#define ZODIACAL_COLUMNS (sizeof zodiacal_latitude / sizeof *zodiacal_latitude)
static const double zodiacal[ZODIACAL_ROWS][ZODIACAL_COLUMNS] = {
    { 11500, 6780, 4740, 3140, 1610, 985, 640, 275, 150, 100, 60 },
    { 11500, 6780, 4740, 2940, 1540, 945, 625, 271, 150, 100, 60 },
    { 11500, 6780, 4740, 2470, 1370, 865, 590, 264, 148, 100, 60 },
    { 11500, 6780, 3440, 1860, 1110, 755, 525, 251, 146, 100, 60 },
    { 6400, 4480, 2410, 1410, 910, 635, 454, 237, 141, 99, 60 },
    { 3840, 2830, 1730, 1100, 749, 545, 410, 223, 136, 97, 60 },
    { 2480, 1870, 1220, 845, 615, 467, 365, 207, 131, 95, 60 },
    { 1650, 1270, 910, 680, 510, 397, 320, 193, 125, 93, 60 },
    { 1180, 940, 700, 530, 416, 338, 282, 179, 120, 92, 60 },
    { 910, 730, 555, 442, 356, 292, 250, 166, 116, 90, 60 },
    { 505, 442, 352, 292, 243, 209, 183, 134, 104, 86, 60 },
    { 338, 317, 269, 227, 196, 172, 151, 116, 93, 82, 60 },
    { 259, 251, 225, 193, 166, 147, 132, 104, 86, 79, 60 },
    { 212, 210, 197, 170, 150, 133, 119, 96, 82, 77, 60 },
    { 188, 186, 177, 154, 138, 125, 113, 90, 77, 74, 60 },
    { 179, 178, 166, 147, 134, 122, 110, 90, 77, 73, 60 },
    { 179, 178, 165, 148, 137, 127, 116, 96, 79, 72, 60 },
    { 196, 192, 179, 165, 151, 141, 131, 104, 82, 72, 60 },
    { 230, 212, 195, 178, 163, 148, 134, 105, 83, 72, 60 },
};

static size_t place(const double *at, size_t count, double v, double *share)
{
    size_t i = 0;
    while (i + 2 < count && v > at[i + 1]) {
        i++;
    }
    *share = pel_clamp((v - at[i]) / (at[i + 1] - at[i]), 0.0, 1.0);
    return i;
}

double pel_night_zodiacal(double longitude, double latitude)
{
    double a, b, l = fabs(remainder(longitude, 2.0 * PEL_PI)) / PEL_DEG;
    size_t i = place(zodiacal_at, ZODIACAL_ROWS, l, &a);
    size_t j = place(zodiacal_latitude, ZODIACAL_COLUMNS,
                     fabs(latitude) / PEL_DEG, &b);
    double low = log(zodiacal[i][j]) * (1 - b) + log(zodiacal[i][j + 1]) * b;
    double high =
        log(zodiacal[i + 1][j]) * (1 - b) + log(zodiacal[i + 1][j + 1]) * b;
    return exp(low * (1 - a) + high * a);
}

static double bump(double x, double width)
{
    return exp(-0.5 * x * x / (width * width));
}

double pel_night_starlight(double longitude, double latitude)
{
    double l = remainder(longitude, 2.0 * PEL_PI) / PEL_DEG,
           b = latitude / PEL_DEG, s = sin(latitude);
    double disc = 24.0 / sqrt(s * s + 0.008);
    double middle = 1.0 + 0.5 * cos(longitude) * exp(-fabs(b) / 20.0);
    /* The bulge, and the dust before it. */
    double bulge = 150.0 * bump(l, 18.0) * bump(b + 3.0, 7.0);
    double rift = 1.0 - 0.5 * bump(l - 25.0, 28.0) * bump(b - 1.5, 2.5);
    return (disc * middle + bulge) * rift;
}

struct pel_rgb pel_night_above(const struct pel_night_sky *night,
                               const struct pel_mat3 *local,
                               struct pel_vec3 dir)
{
    const struct pel_vec3 q = { pel_vec3_dot(local->x, dir),
                                pel_vec3_dot(local->y, dir),
                                pel_vec3_dot(local->z, dir) };
    double c = cos(ECLIPTIC), s = sin(ECLIPTIC);
    double longitude = atan2(c * q.y + s * q.z, q.x);
    double latitude = asin(pel_clamp(c * q.z - s * q.y, -1.0, 1.0));
    double dust =
        pel_night_zodiacal(longitude - night->sun_longitude_rad, latitude);
    /* Galactic axes in J2000 (Hipparcos catalogue, vol. 1, eq. 1.5.11). */
    const struct pel_vec3 gx = { -0.0548755604, -0.8734370902, -0.4838350155 },
                          gy = { 0.4941094279, -0.4448296300, 0.7469822445 },
                          gz = { -0.8676661490, -0.1980763734, 0.4559837762 };
    double stars =
        pel_night_starlight(atan2(pel_vec3_dot(gy, q), pel_vec3_dot(gx, q)),
                            asin(pel_clamp(pel_vec3_dot(gz, q), -1.0, 1.0)));
    /* Of the Sun's colour, and of the mean of stars (B − V 0.8). */
    const struct pel_rgb sun = PEL_SUN_IRRADIANCE;
    double r = sun.r / sun.g, b = sun.b / sun.g;
    return (struct pel_rgb){ PEL_S10 * (dust * r + stars * r * 1.08),
                             PEL_S10 * (dust + stars),
                             PEL_S10 * (dust * b + stars * b * 0.87) };
}

struct pel_rgb pel_night_airglow(double mu)
{
    double x = PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + LAYER_M);
    double v = PEL_S10 * PEL_AIRGLOW_S10 / sqrt(1.0 - x * x * (1.0 - mu * mu));
    /* Of the dark sky's B − V 0.9, V − R 0.9 (Patat 2003), less the zodiacal
     * light; 680 nm, between the red line and the bands of OH, has less of R.
     */
    return (struct pel_rgb){ 1.2 * v, v, 0.75 * v };
}

#define AROUND 96 /* directions of a mean around the horizon */

struct row {
    double mu, weight; /* share of the hemisphere */
    double through[3];
    double above[3]; /* mean around the horizon, through the air */
    double sum[3];   /* with the airglow */
};

static void put(double out[3], struct pel_rgb c)
{
    out[0] = c.r;
    out[1] = c.g;
    out[2] = c.b;
}

static double elevation_of(double at)
{
    double x = at / (PEL_NIGHT_ROWS - 1);
    return 0.5 * PEL_PI * x * x;
}

/* Of a sky that is wide: light that aerosols turn by their mean angle stays, so
 * that of their scattering 1 − g counts (similarity). `share`: of what is lost,
 * what is scattered. */
static void diffuse_through(const struct pel_atmosphere *air, double mu,
                            double through[3], double share[3])
{
    struct pel_columns way = pel_atmosphere_columns(air, 0.0, mu);
    double rayleigh[3], ozone[3];
    put(rayleigh, air->rayleigh);
    put(ozone, air->ozone);
    double turned = (1.0 - air->mie_g) * air->mie_scattering * way.mie;
    double taken = (air->mie_extinction - air->mie_scattering) * way.mie;
    for (int k = 0; k < 3; k++) {
        double scattered = rayleigh[k] * way.rayleigh + turned;
        double lost = scattered + taken + ozone[k] * way.ozone;
        through[k] = exp(-lost);
        if (share) {
            share[k] = scattered / lost;
        }
    }
}

static void fill_rows(const struct pel_night_sky *night,
                      const struct pel_atmosphere *air,
                      struct row rows[PEL_NIGHT_ROWS])
{
    for (int i = 0; i < PEL_NIGHT_ROWS; i++) {
        struct row *row = &rows[i];
        double e = elevation_of(i);
        row->mu = sin(e);
        row->weight = sin(elevation_of(fmin(i + 0.5, PEL_NIGHT_ROWS - 1))) -
                      sin(elevation_of(fmax(i - 0.5, 0)));
        diffuse_through(air, fmax(row->mu, 1e-4), row->through, NULL);
        double glow[3];
        put(glow, pel_night_airglow(row->mu));
        memset(row->above, 0, sizeof row->above);
        for (int j = 0; j < AROUND; j++) {
            double a = 2.0 * PEL_PI * (j + 0.5) / AROUND, c[3];
            const struct pel_vec3 dir = { cos(e) * cos(a), cos(e) * sin(a),
                                          sin(e) };
            put(c, pel_night_above(night, &night->local_minute, dir));
            for (int k = 0; k < 3; k++) {
                row->above[k] += c[k] * row->through[k] / AROUND;
            }
        }
        for (int k = 0; k < 3; k++) {
            row->sum[k] = row->above[k] + glow[k] * row->through[k];
        }
    }
}

/* Of this elevation's place between the rows. */
static double row_of(double sine, int *row)
{
    double at = sqrt(asin(pel_clamp(sine, 0.0, 1.0)) / (0.5 * PEL_PI)) *
                (PEL_NIGHT_ROWS - 1);
    *row = (int)fmin(at, PEL_NIGHT_ROWS - 2);
    return at - *row;
}

static void fill_map(const struct pel_night_sky *night,
                     const struct row rows[PEL_NIGHT_ROWS],
                     struct pel_night_map *out)
{
    for (int i = 0; i < PEL_NIGHT_SIDE * PEL_NIGHT_SIDE; i++) {
        int x = i % PEL_NIGHT_SIDE, y = i / PEL_NIGHT_SIDE, row;
        double u = 2.0 * (x + 0.5) / PEL_NIGHT_SIDE - 1.0,
               v = 2.0 * (y + 0.5) / PEL_NIGHT_SIDE - 1.0;
        double r = hypot(u, v), inside = fmin(r, 1.0); /* beyond: its rim */
        double z = 1.0 - inside * inside, c[3];
        double across = sqrt(1.0 - z * z) / fmax(r, 1e-9);
        const struct pel_vec3 dir = { u * across, v * across, z };
        put(c, pel_night_above(night, &night->local_minute, dir));
        double t = row_of(z, &row);
        for (int k = 0; k < 3; k++) {
            const struct row *a = &rows[row], *b = &rows[row + 1];
            double through = (1 - t) * a->through[k] + t * b->through[k];
            double mean = (1 - t) * a->above[k] + t * b->above[k];
            out->off[y][x][k] = (float)(c[k] * through - mean);
        }
    }
}

void pel_night_map_make(const struct pel_night_sky *night, double visibility_m,
                        struct pel_night_map *out)
{
    struct pel_atmosphere *air = malloc(sizeof *air);
    struct row rows[PEL_NIGHT_ROWS];
    const struct pel_atmosphere_desc desc = { visibility_m };
    memset(out, 0, sizeof *out);
    if (!air) {
        return;
    }
    pel_atmosphere_init(&desc, air);
    fill_rows(night, air, rows);
    fill_map(night, rows, out);
    double source[3], share[3], up[3];
    diffuse_through(air, 1.0, up, share);
    for (int k = 0; k < 3; k++) {
        /* source = half · Σ weight (sum + source (1 − through)). */
        double half = 0.5 * share[k], direct = 0.0, again = 0.0;
        for (int i = 0; i < PEL_NIGHT_ROWS; i++) {
            direct += rows[i].weight * rows[i].sum[k];
            again += rows[i].weight * (1.0 - rows[i].through[k]);
        }
        source[k] = half * direct / (1.0 - half * again);
        for (int i = 0; i < PEL_NIGHT_ROWS; i++) {
            out->zonal[i][k] = (float)(rows[i].sum[k] +
                                       source[k] * (1.0 - rows[i].through[k]));
        }
    }
    out->air = (struct pel_rgb){ source[0], source[1], source[2] };
    pel_atmosphere_finish(air);
    free(air);
}

/* Linear between rows and texels, as shaders/lib/night.glsl. */
struct pel_rgb pel_night_seen(const struct pel_night_map *map,
                              struct pel_vec3 dir, bool off)
{
    if (dir.z < 0.0) {
        return (struct pel_rgb){ 0, 0, 0 };
    }
    int row;
    double t = row_of(dir.z, &row), k = 0.5 / sqrt(1.0 + dir.z), v[3];
    double u = pel_clamp((0.5 + k * dir.x) * PEL_NIGHT_SIDE - 0.5, 0.0,
                         PEL_NIGHT_SIDE - 1.001);
    double w = pel_clamp((0.5 + k * dir.y) * PEL_NIGHT_SIDE - 0.5, 0.0,
                         PEL_NIGHT_SIDE - 1.001);
    int x = (int)u, y = (int)w;
    u -= x;
    w -= y;
    for (int c = 0; c < 3; c++) {
        double low = (1 - u) * (double)map->off[y][x][c] +
                     u * (double)map->off[y][x + 1][c];
        double high = (1 - u) * (double)map->off[y + 1][x][c] +
                      u * (double)map->off[y + 1][x + 1][c];
        v[c] = (1 - w) * low + w * high;
        if (!off) {
            v[c] += (1 - t) * (double)map->zonal[row][c] +
                    t * (double)map->zonal[row + 1][c];
        }
    }
    return (struct pel_rgb){ v[0], v[1], v[2] };
}
