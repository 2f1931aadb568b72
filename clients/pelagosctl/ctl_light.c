/* pelagosctl optics brdf and optics sky: numbers of light from pelagosd. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"
#include "path.h"

static void print_three(const char *name, const char *unit, const double *v)
{
    printf("%-24s %12.6g %12.6g %12.6g  %s\n", name, v[0], v[1], v[2], unit);
}

static void print_one(const char *name, bool given, double v, const char *unit)
{
    if (given) {
        printf("%-24s %12.6g  %s\n", name, v, unit);
    }
}

static void print_brdf(const Pelagos__Brdf *b)
{
#define ROW(name, field, unit) print_one(name, b->has_##field, b->field, unit)
    ROW("slope variance along", slope_along, "");
    ROW("slope variance across", slope_cross, "");
    ROW("half-vector's zenith", half_zenith, "deg");
    ROW("slope density P", slope_density, "");
    ROW("lambda of the eye", lambda_view, "");
    ROW("lambda of the Sun", lambda_sun, "");
    ROW("shadowing", shadowing, "");
    ROW("Fresnel at half-vector", fresnel, "");
    ROW("effective Fresnel, Smith", mean_fresnel, "eq. 24");
    ROW("effective Fresnel, seen", seen_fresnel, "as drawn");
    ROW("BRDF", brdf, "1/sr");
    ROW("reflected Sun", reflected_sun, "1/sr");
#undef ROW
}

static void print_sky(const Pelagos__SkyLight *s)
{
    printf("%-24s %12s %12s %12s\n", "", "680 nm", "550 nm", "440 nm");
    print_three("sky radiance", "W/m2/sr/nm", s->radiance);
    print_three("transmittance", "to space", s->transmittance);
    print_three("Sun's transmittance", "", s->sun_transmittance);
    print_three("Sun's irradiance", "W/m2/nm", s->sun_irradiance);
    if (s->n_moon_irradiance == 3) {
        print_three("Moon's irradiance", "W/m2/nm", s->moon_irradiance);
    }
    if (s->n_night_radiance == 3 && s->night_radiance[1] > 0) {
        print_three("of it the night's own", "W/m2/sr/nm", s->night_radiance);
    }
    print_one("sky luminance", s->has_luminance, s->luminance, "cd/m2");
}

static bool complete(const Pelagos__Optics *o)
{
    const Pelagos__SkyLight *s = o->sky;
    if (o->answer_case == PELAGOS__OPTICS__ANSWER_BRDF) {
        return o->brdf != NULL;
    }
    return o->answer_case == PELAGOS__OPTICS__ANSWER_SKY && s &&
           s->n_radiance == 3 && s->n_transmittance == 3 &&
           s->n_sun_transmittance == 3 && s->n_sun_irradiance == 3;
}

static void print_answer(const Pelagos__Optics *o)
{
    printf("from %s, Sun at %.3f deg, azimuth %.3f deg\n",
           o->from == PELAGOS__OPTICS_SOURCE__GPU ? o->device : "the reference",
           o->sun_elevation, o->sun_azimuth);
    if (o->has_moon_elevation) {
        printf("Moon at %.3f deg, azimuth %.3f deg, %.1f %% lit\n",
               o->moon_elevation, o->moon_azimuth, 100.0 * o->moon_phase);
    }
    if (o->answer_case == PELAGOS__OPTICS__ANSWER_SKY) {
        print_sky(o->sky);
    } else {
        print_brdf(o->brdf);
    }
}

static enum ctl_exit read_numbers(struct ctl *ctl, Pelagos__BrdfQuery *brdf,
                                  Pelagos__SkyQuery *sky)
{
    const struct {
        const char *name;
        double minimum, maximum, *out;
    } numbers[] = {
        { "slope-along", 1e-8, 1.0, &brdf->slope_along },
        { "slope-cross", 1e-8, 1.0, &brdf->slope_cross },
        { "view-zenith", 0.0, 90.0, &brdf->view_zenith },
        { "view-azimuth", 0.0, 360.0, &brdf->view_azimuth },
        { "height", 0.5, 1e6, &sky->height },
        { "elevation", -90.0, 90.0, &sky->elevation },
        { "azimuth", 0.0, 360.0, &sky->azimuth },
    };
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; i < G_N_ELEMENTS(numbers) && status == CTL_DONE; i++) {
        status = ctl_number(ctl, numbers[i].name, numbers[i].minimum,
                            numbers[i].maximum, numbers[i].out);
    }
    brdf->has_slope_along = ctl_flag(ctl, "slope-along");
    brdf->has_slope_cross = ctl_flag(ctl, "slope-cross");
    brdf->has_view_zenith = true;
    brdf->has_view_azimuth = ctl_flag(ctl, "view-azimuth");
    sky->has_height = sky->has_elevation = sky->has_azimuth = true;
    return status;
}

/* Options that are short for paths, then the paths themselves. */
static enum ctl_exit read_paths(struct ctl *ctl, const Pelagos__State *now,
                                Pelagos__Patch *patch)
{
    static const char *const shorts[][2] = {
        { "wind", "sea.windSpeed" },
        { "sun-elevation", "sky.sunElevation" },
        { "sun-azimuth", "sky.sunAzimuth" },
        { "visibility", "sky.visibility" },
    };
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; i < G_N_ELEMENTS(shorts) && status == CTL_DONE; i++) {
        const char *value = ctl_value(ctl, shorts[i][0]);
        if (value) {
            g_autofree char *text =
                g_strdup_printf("%s=%s", shorts[i][1], value);
            g_autofree char *path = NULL;
            status = ctl_assign(ctl, patch, now, text, &path);
        }
    }
    for (size_t i = 1; i < ctl->arg_count && status == CTL_DONE; i++) {
        g_autofree char *path = NULL;
        status = ctl_assign(ctl, patch, now, ctl->args[i], &path);
    }
    return status;
}

static enum ctl_exit read_source(const struct ctl *ctl,
                                 Pelagos__OpticsQuery *query)
{
    const char *from = ctl_value(ctl, "from");
    query->has_from = true;
    if (from && g_ascii_strcasecmp(from, "gpu") == 0) {
        query->from = PELAGOS__OPTICS_SOURCE__GPU;
    } else if (from && g_ascii_strcasecmp(from, "reference") != 0) {
        return ctl_say(CTL_USAGE, "--from %s: one of reference, gpu is wanted",
                       from);
    }
    return CTL_DONE;
}

enum ctl_exit ctl_light(struct ctl *ctl)
{
    Pelagos__OpticsQuery query = PELAGOS__OPTICS_QUERY__INIT;
    Pelagos__BrdfQuery brdf = PELAGOS__BRDF_QUERY__INIT;
    Pelagos__SkyQuery sky = PELAGOS__SKY_QUERY__INIT;
    Pelagos__State *now = NULL;
    Pelagos__Optics *answer = NULL;
    struct pel_client_error error;
    enum ctl_exit status = read_numbers(ctl, &brdf, &sky);
    if (status == CTL_DONE) {
        status = read_source(ctl, &query);
    }
    if (status == CTL_DONE) {
        status = ctl_fetch(ctl, &now);
    }
    if (status != CTL_DONE) {
        return status;
    }
    if (strcmp(ctl->args[0], "sky") == 0) {
        query.question_case = PELAGOS__OPTICS_QUERY__QUESTION_SKY;
        query.sky = &sky;
    } else {
        query.question_case = PELAGOS__OPTICS_QUERY__QUESTION_BRDF;
        query.brdf = &brdf;
    }
    query.patch = pel_patch_new();
    status = read_paths(ctl, now, query.patch);
    bool sweeps = ctl_wants_series(ctl);
    if (status == CTL_DONE && sweeps) {
        Pelagos__SeriesQuery series = PELAGOS__SERIES_QUERY__INIT;
        series.question_case = PELAGOS__SERIES_QUERY__QUESTION_OPTICS;
        series.optics = &query;
        status = ctl_series(ctl, &series);
    } else if (status == CTL_DONE &&
               pel_client_optics(ctl->client, &query, &answer, &error)) {
        status = ctl_report(ctl, &error);
    }
    if (status != CTL_DONE || sweeps) {
        /* said already */
    } else if (!complete(answer)) {
        status = ctl_say(CTL_UNREACHABLE, "the answer lacks its numbers");
    } else if (ctl_flag(ctl, "json")) {
        char *text = pel_json_from_message(&answer->base, true);
        puts(text);
        free(text);
    } else {
        print_answer(answer);
    }
    if (answer) {
        pelagos__optics__free_unpacked(answer, NULL);
    }
    pelagos__patch__free_unpacked(query.patch, NULL);
    pelagos__state__free_unpacked(now, NULL);
    return status;
}
