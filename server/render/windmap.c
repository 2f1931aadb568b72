#include "render/windmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "ocean/directional.h"
#include "ocean/foam.h"

static GLuint make_texture(GLenum target, GLint across, const char *label)
{
    GLuint texture = 0;
    glCreateTextures(target, 1, &texture);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, across);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

/* --- winds ---------------------------------------------------------------- */

/* As vectors of the Earth's axes, so that they run on over poles and date
 * line. */
static void put_winds(const struct pel_weather *w, int time, GLuint texture,
                      GLint layer)
{
    const size_t texels = (size_t)PEL_WIND_COLUMNS * PEL_WIND_ROWS;
    float *all = pel_sure_malloc(4 * texels * sizeof *all), *to = all;
    for (int y = 0; y < PEL_WIND_ROWS; y++) {
        double lat = ((y + 0.5) / PEL_WIND_ROWS - 0.5) * PEL_PI;
        for (int x = 0; x < PEL_WIND_COLUMNS; x++, to += 4) {
            double lon = (2.0 * (x + 0.5) / PEL_WIND_COLUMNS - 1.0) * PEL_PI;
            struct pel_weather_now now;
            pel_weather_at(w, lat, lon, w->unix_s[time], &now);
            double east = now.wind_east_mps, north = now.wind_north_mps;
            to[0] = (float)(-sin(lon) * east - sin(lat) * cos(lon) * north);
            to[1] = (float)(cos(lon) * east - sin(lat) * sin(lon) * north);
            to[2] = (float)(cos(lat) * north);
            to[3] = 0;
        }
    }
    glTextureSubImage3D(texture, 0, 0, 0, layer, PEL_WIND_COLUMNS,
                        PEL_WIND_ROWS, 1, GL_RGBA, GL_FLOAT, all);
    free(all);
}

/* Of the field's times, the last that is not later; before the first, that. */
static int first_of(const struct pel_weather *w, double unix_s)
{
    int low = 0, high = w->times;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        *(w->unix_s[middle] <= unix_s ? &low : &high) = middle;
    }
    return low;
}

static int next_of(const struct pel_weather *w, int time)
{
    return time + 1 < w->times ? time + 1 : time;
}

static void bring_winds(struct pel_wind_map *m, const struct pel_weather *w,
                        double unix_s)
{
    int first = first_of(w, unix_s);
    bool same = m->winds && m->serial == w->serial;
    if (same && m->first == first) {
        return;
    }
    if (!m->winds) {
        m->winds = make_texture(GL_TEXTURE_2D_ARRAY, GL_REPEAT, "winds");
        glTextureStorage3D(m->winds, 1, GL_RGBA16F, PEL_WIND_COLUMNS,
                           PEL_WIND_ROWS, 2);
    }
    if (same && m->first == first - 1) {
        glCopyImageSubData(m->winds, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 1, m->winds,
                           GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, PEL_WIND_COLUMNS,
                           PEL_WIND_ROWS, 1);
    } else {
        put_winds(w, first, m->winds, 0);
    }
    put_winds(w, next_of(w, first), m->winds, 1);
    m->serial = w->serial;
    m->first = first;
}

/* --- roughness ------------------------------------------------------------ */

static double speed_of(int i)
{
    return PEL_WIND_MOST * i / (PEL_WIND_SPEEDS - 1);
}

/* A fetch that is long for any wind. */
#define LONG_FETCH_M 1e6

/* The sea of no place: without what a field of weather leads, or the table
 * would be another at every moment, and what only the scene's place has. */
static struct pel_sea_desc of_no_place(const struct pel_sea_desc *desc)
{
    struct pel_sea_desc any;
    memcpy(&any, desc, sizeof any); /* with its padding */
    any.wind_mps = any.direction_rad = 0;
    any.fetch_m = LONG_FETCH_M;
    any.seed = 0;
    any.swell_count = any.single_count = any.area_count = 0;
    memset(any.swell, 0, sizeof any.swell);
    memset(any.single, 0, sizeof any.single);
    memset(any.area, 0, sizeof any.area);
    return any;
}

static enum pel_err tabulate(struct pel_wind_map *m,
                             const struct pel_sea_desc *desc)
{
    float texels[2][PEL_WIND_SPEEDS][4] = { 0 };
    static struct pel_sea sea; /* one thread */
    for (int i = 0; i < PEL_WIND_SPEEDS; i++) {
        struct pel_sea_desc here = *desc;
        struct pel_directional *spectrum;
        struct pel_band_moments all;
        here.wind_mps = speed_of(i);
        enum pel_err err = pel_directional_create(&here, &spectrum);
        if (err != PEL_OK) {
            return err;
        }
        pel_directional_moments(spectrum, 0, INFINITY, &all);
        pel_directional_destroy(spectrum);
        sea.slope_variance_along = all.along;
        sea.slope_variance_cross = all.cross;
        const struct pel_folding fold = pel_sea_folding(&sea);
        double foam = here.whitecaps * pel_foam_of_wind(here.wind_mps);
        m->slopes[i][0] = all.along;
        m->slopes[i][1] = all.cross;
        texels[0][i][0] = (float)all.along;
        texels[0][i][1] = (float)all.cross;
        texels[0][i][2] = (float)(fmin(foam, 0.6) * PEL_FOAM_DENSE);
        texels[1][i][0] = (float)(0.75 * fold.finest);
        texels[1][i][1] = (float)(0.75 * fold.more);
    }
    glTextureSubImage2D(m->rough, 0, 0, 0, PEL_WIND_SPEEDS, 2, GL_RGBA,
                        GL_FLOAT, texels);
    return PEL_OK;
}

static enum pel_err bring_rough(struct pel_wind_map *m,
                                const struct pel_sea_desc *desc)
{
    const struct pel_sea_desc any = of_no_place(desc);
    if (m->rough && memcmp(&any, &m->rough_desc, sizeof any) == 0) {
        return PEL_OK;
    }
    if (!m->rough) {
        m->rough = make_texture(GL_TEXTURE_2D, GL_CLAMP_TO_EDGE, "roughness");
        glTextureStorage2D(m->rough, 1, GL_RGBA32F, PEL_WIND_SPEEDS, 2);
    }
    memset(&m->rough_desc, 0, sizeof m->rough_desc);
    enum pel_err err = tabulate(m, &any);
    if (err == PEL_OK) {
        memcpy(&m->rough_desc, &any, sizeof any);
    }
    return err;
}

enum pel_err pel_wind_map_need(struct pel_wind_map *m,
                               const struct pel_environment *env)
{
    bring_winds(m, env->weather, env->weather_unix_s);
    return bring_rough(m, &env->sea->desc);
}

void pel_wind_map_bind(const struct pel_wind_map *m)
{
    glBindTextureUnit(PEL_UNIT_SPACE_WINDS, m->winds);
    glBindTextureUnit(PEL_UNIT_SPACE_ROUGH, m->rough);
}

/* Of the table, as the texture has it. */
static double slope_at(const struct pel_wind_map *m, double speed_mps, int k)
{
    double place =
        pel_clamp(speed_mps / PEL_WIND_MOST, 0, 1) * (PEL_WIND_SPEEDS - 1);
    int i = place < PEL_WIND_SPEEDS - 2 ? (int)place : PEL_WIND_SPEEDS - 2;
    double f = place - i;
    return m->slopes[i][k] * (1 - f) + m->slopes[i + 1][k] * f;
}

struct pel_vec4 pel_wind_map_place(const struct pel_wind_map *m,
                                   const struct pel_environment *env)
{
    const struct pel_weather *w = env->weather;
    int first = first_of(w, env->weather_unix_s);
    double from_s = w->unix_s[first],
           span_s = w->unix_s[next_of(w, first)] - from_s;
    const struct pel_sea *sea = env->sea;
    double speed = sea->desc.wind_mps;
    double along = slope_at(m, speed, 0), cross = slope_at(m, speed, 1);
    return (struct pel_vec4){
        (float)(span_s > 0
                    ? pel_clamp((env->weather_unix_s - from_s) / span_s, 0, 1)
                    : 0),
        (float)speed,
        (float)(along > 0 ? sea->slope_variance_along / along : 1),
        (float)(cross > 0 ? sea->slope_variance_cross / cross : 1),
    };
}

void pel_wind_map_finish(struct pel_wind_map *m)
{
    const GLuint textures[] = { m->winds, m->rough };
    glDeleteTextures(2, textures);
    *m = (struct pel_wind_map){ 0 };
}
