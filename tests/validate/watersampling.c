#include "watersampling.h"

#include <math.h>

#include "base/vec.h"
#include "optics/waterkernel.h"
#include "shaders/lib/blocks.h"

#define N PEL_KERNEL_NODES
#define M PEL_KERNEL_MODES
#define COUNT(a) (int)(sizeof(a) / sizeof *(a))

static const double media[][2] = {
    { 0.05, 0.1 }, { 0.05, 0.4 }, { 0.15, 1.7 }, { 0.4, 0.2 }
};
static const double depths[] = { 1, 10, 1000 };
static const double suns[] = { 0, 30, 60, 80, 88 };
static const double zeniths[] = { 0, 20, 40, 60, 75, 88 };
#define WATERS (COUNT(media) * COUNT(depths) * 2)

static struct pel_medium water(int i)
{
    return (struct pel_medium){
        .absorption = media[i / 6][0],
        .scattering = media[i / 6][1],
        .asymmetry = i / 3 % 2 ? 0.75 : 0.924,
        .depth_m = depths[i % 3],
    };
}

typedef double response[M][N][N];

/* Modes of a response for one Sun and line of sight. */
static void modes_at(response r, double sun_sine, double view_sine,
                     double modes[M])
{
    double a[N], b[N];
    pel_kernel_weights(sun_sine, a);
    pel_kernel_weights(view_sine, b);
    for (int m = 0; m < M; m++) {
        modes[m] = 0.0;
        for (int i = 0; i < N * N; i++) {
            modes[m] += a[i / N] * b[i % N] * r[m][i / N][i % N];
        }
    }
}

static double at_azimuth(const double modes[M], double azimuth)
{
    double sum = 0.0;
    for (int m = 0; m < M; m++) {
        sum += modes[m] * cos(m * azimuth);
    }
    return sum;
}

/* Worst error of the second order over waters, Suns and views, each of the
 * maximum over the views of its water and Sun, against the quadrature. */
static double second_error(const struct pel_water_sampling *s)
{
    double worst = 0.0;
    for (int k = 0; k < WATERS; k++) {
        static response r;
        struct pel_medium m = water(k);
        pel_kernel_second(&m, s, r);
        for (int i = 0; i < COUNT(suns); i++) {
            double most = 0.0, error = 0.0;
            for (int v = 0; v < COUNT(zeniths) * 3; v++) {
                struct pel_geometry at = { suns[i] * PEL_DEG,
                                           zeniths[v / 3] * PEL_DEG,
                                           v % 3 * 0.5 * PEL_PI };
                struct pel_interface f = pel_interface_at(&at);
                double modes[M];
                modes_at(r, sqrt(1.0 - f.sun_mu * f.sun_mu),
                         sqrt(1.0 - f.view_mu * f.view_mu), modes);
                double factor = f.beam * f.leaving / PEL_KERNEL_LEAVING;
                double exact = pel_transport_second(&m, &at);
                double mine = factor * at_azimuth(modes, at.azimuth_rad);
                most = fmax(most, exact);
                error = fmax(error, fabs(mine - exact));
            }
            worst = fmax(worst, error / most);
        }
    }
    return worst;
}

/* Radiance that a map of `size` × `size` holds, single scattering and second
 * order, at column x of 0..1 and modes of a row. */
static double shown(const struct pel_medium *m, const double modes[M],
                    double sun_sine, double view_sine, double x)
{
    double cosine = 2.0 * x - 1.0;
    double sun_mu = sqrt(1.0 - sun_sine * sun_sine);
    double view_mu = sqrt(1.0 - view_sine * view_sine);
    double nu = sun_sine * view_sine * cosine - sun_mu * view_mu;
    struct pel_phase phase = pel_medium_phase(m);
    double rate =
        (m->absorption + m->scattering) * (1.0 / sun_mu + 1.0 / view_mu);
    double single = m->scattering * pel_phase_at(&phase, nu) *
                    -expm1(-rate * m->depth_m) / (rate * view_mu);
    return PEL_KERNEL_LEAVING * single + at_azimuth(modes, acos(cosine));
}

/* Worst error between texels of a linear filter, of the maximum of the map. */
static double map_error(int size)
{
    static const struct pel_water_sampling exact = { 0, 48, 48 };
    double worst = 0.0, step = 1.0 / (size - 1), top = pel_kernel_sine(N - 1);
    for (int k = 0; k < WATERS; k += 2) {
        static response r;
        struct pel_medium m = water(k);
        pel_kernel_second(&m, &exact, r);
        for (int i = 0; i < COUNT(suns); i++) {
            double sun = sin(suns[i] * PEL_DEG) * top, most = 0.0, error = 0.0;
            for (int row = 0; row + 1 < size; row++) {
                double low[M], middle[M], high[M], y = row * step;
                modes_at(r, sun, y * top, low);
                modes_at(r, sun, (y + 0.5 * step) * top, middle);
                modes_at(r, sun, (y + step) * top, high);
                for (int column = 0; column + 1 < size; column += 3) {
                    double x = column * step, mean = 0.0;
                    for (int c = 0; c < 4; c++) {
                        mean += 0.25 * shown(&m, c / 2 ? high : low, sun,
                                             (y + c / 2 * step) * top,
                                             x + c % 2 * step);
                    }
                    double truth =
                        shown(&m, middle, sun, (y + 0.5 * step) * top,
                              x + 0.5 * step);
                    most = fmax(most, truth);
                    error = fmax(error, fabs(mean - truth));
                }
            }
            worst = fmax(worst, error / most);
        }
    }
    return worst;
}

double put_sampling(FILE *md, FILE *json, bool quick)
{
    const struct pel_water_sampling *made = &pel_water_sampling_default;
    static const int planes[] = { 2, 3, 4, 6, 8, 10, 12, 16, 24 };
    static const int zenith[] = { 8, 12, 16, 24, 32, 40, 48, 64 };
    static const int azimuth[] = { 8, 12, 16, 24, 32, 40, 48, 64 };
    static const int size[] = { 8, 16, 24, 32, 48, 64, 96 };
    const struct {
        const char *title, *head;
        const int *values;
        int count, made;
    } tables[] = {
        { "planes", "n_z", planes, COUNT(planes), made->planes },
        { "zeniths", "zeniths", zenith, COUNT(zenith), made->zeniths },
        { "azimuths", "azimuths", azimuth, COUNT(azimuth), made->azimuths },
        { "size", "texels", size, COUNT(size), PEL_WATER_MAP_SIZE },
    };
    double all = second_error(made);
    fprintf(md,
            "\n## Sampling of the maps (figs. 7, 8 of the 2003 paper)\n\n"
            "Worst error in %% of the maximum over views, %d waters and %d "
            "Suns, one number changed at a time from n_z = %d planes, n_d = "
            "4 × %d zeniths × %d azimuths = %d directions, %d × %d texels. "
            "1/255 is 0.39 %%, 1/1000 is 0.1 %%. With all of these the "
            "second order is within 1/%.0f.\n",
            WATERS, COUNT(suns), made->planes, made->zeniths, made->azimuths,
            4 * made->zeniths * made->azimuths, PEL_WATER_MAP_SIZE,
            PEL_WATER_MAP_SIZE, 1.0 / all);
    fprintf(json, "{");
    for (int t = 0; t < COUNT(tables); t++) {
        fprintf(md, "\n| %s | error %% |\n|---|---|\n", tables[t].head);
        fprintf(json, "%s\"%s\": [", t ? ",\n" : "", tables[t].title);
        for (int i = 0; i < tables[t].count; i++) {
            int n = tables[t].values[i];
            if (quick && n != tables[t].made) {
                continue;
            }
            struct pel_water_sampling s = *made;
            s.planes = t == 0 ? n : s.planes;
            s.zeniths = t == 1 ? n : s.zeniths;
            s.azimuths = t == 2 ? n : s.azimuths;
            double error = t == 3                ? map_error(n)
                           : n == tables[t].made ? all
                                                 : second_error(&s);
            fprintf(md, "| %d%s | %.4f |\n", n,
                    n == tables[t].made ? " (made)" : "", 100.0 * error);
            fprintf(json, "%s[%d, %.3g]", quick || !i ? "" : ", ", n, error);
            fprintf(stderr, "\rsampling %s %d   ", tables[t].head, n);
        }
        fprintf(json, "]");
    }
    fprintf(json, ",\n\"made\": [%d, %d, %d, %d]}\n", made->planes,
            made->zeniths, made->azimuths, PEL_WATER_MAP_SIZE);
    return all;
}
