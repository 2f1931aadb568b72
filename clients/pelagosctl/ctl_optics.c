/* pelagosctl optics water: numbers from the reference code of server/optics.
 * Needs no daemon. */
#include "pelagosctl/ctl.h"

#include <stdint.h>
#include <string.h>

#include <glib.h>

#include "base/vec.h"
#include "optics/waterbody.h"
#include "optics/watermontecarlo.h"
#include "optics/waterreport.h"
#include "path.h"

enum { N = PEL_WATER_WAVELENGTHS };

static const char *const order_words[] = { "all", "2", "paper", "single",
                                           NULL };

#define MOST 61 /* wavelengths at once */

struct question {
    struct pel_water_desc desc;
    struct pel_water_body body;
    double nm[MOST];
    int count;                               /* of them */
    double sun_zenith, view_zenith, azimuth; /* degrees */
    enum pel_water_orders orders;
    bool montecarlo, gpu;
    double paths, seed;
};

/* One number for all wavelengths or three with commas between; `given` (NULL
 * allowed) tells whether the option was there. */
static enum ctl_exit three(const struct ctl *ctl, const char *name,
                           const char *text, double out[N])
{
    g_auto(GStrv) parts = g_strsplit(text, ",", -1);
    guint count = g_strv_length(parts);
    for (guint i = 0; i < count && i < N; i++) {
        if (!ctl_parse_number(parts[i], &out[i])) {
            count = 0;
        }
    }
    if (count == 1) {
        out[1] = out[2] = out[0];
    } else if (count != N) {
        return ctl_say(CTL_USAGE,
                       "--%s %s: one number, or three for 680, 550 and 440 nm "
                       "(0.5,0.06,0.02), are wanted; see `pelagosctl %s "
                       "--help`",
                       name, text, ctl->command->name);
    }
    return CTL_DONE;
}

/* The number of the word that option `name` gives; *out keeps its value
 * without the option. */
static enum ctl_exit choose(const struct ctl *ctl, const char *name,
                            const char *(*word)(int), int *out)
{
    const char *text = ctl_value(ctl, name);
    if (!text) {
        return CTL_DONE;
    }
    g_autoptr(GString) all = g_string_new(NULL);
    for (int i = 0; word(i); i++) {
        if (g_ascii_strcasecmp(word(i), text) == 0) {
            *out = i;
            return CTL_DONE;
        }
        g_string_append_printf(all, "%s%s", i ? ", " : "", word(i));
    }
    return ctl_say(CTL_USAGE, "--%s %s: one of %s is wanted", name, text,
                   all->str);
}

static const char *order_word(int i)
{
    return order_words[i];
}

static const char *source_word(int i)
{
    static const char *const words[] = { "reference", "montecarlo", "gpu",
                                         NULL };
    return words[i];
}

static const char *named_bottom_word(int i)
{
    return i == PEL_BOTTOM_ALBEDO ? NULL : pel_bottom_word(i);
}

static enum ctl_exit read_bottom(const struct ctl *ctl,
                                 struct pel_water_desc *desc)
{
    const char *text = ctl_value(ctl, "bottom");
    if (text && (g_ascii_isdigit(text[0]) || strchr(".-+", text[0]))) {
        desc->bottom = PEL_BOTTOM_ALBEDO;
        return three(ctl, "bottom", text, desc->albedo);
    }
    int bottom = PEL_BOTTOM_BLACK;
    enum ctl_exit status = choose(ctl, "bottom", named_bottom_word, &bottom);
    desc->bottom = (enum pel_bottom)bottom;
    return status;
}

static enum ctl_exit read_coefficients(const struct ctl *ctl,
                                       struct pel_water_desc *desc)
{
    const char *a = ctl_value(ctl, "absorption");
    const char *b = ctl_value(ctl, "scattering");
    const char *g = ctl_value(ctl, "asymmetry");
    if (!a || !b) {
        return ctl_say(CTL_USAGE, "--absorption and --scattering go together");
    }
    desc->kind = PEL_WATER_COEFFICIENTS;
    enum ctl_exit status = three(ctl, "absorption", a, desc->absorption);
    if (status == CTL_DONE) {
        status = three(ctl, "scattering", b, desc->scattering);
    }
    if (status == CTL_DONE) {
        status = three(ctl, "asymmetry", g ? g : "0.924", desc->asymmetry);
    }
    return status;
}

/* What --cdom and the like say of a water. */
static enum ctl_exit read_constituents(struct ctl *ctl,
                                       struct pel_water_desc *desc)
{
    const struct {
        const char *name;
        double minimum, maximum, *out;
        bool *given, chlorophyll;
    } all[] = {
        { "cdom", 0.0, PEL_CONSTITUENT_MAX, &desc->dissolved_per_m,
          &desc->has_dissolved, true },
        { "cdom-slope", 0.005, 0.03, &desc->dissolved_slope, NULL, true },
        { "detritus", 0.0, PEL_CONSTITUENT_MAX, &desc->detritus_per_m,
          &desc->has_detritus, true },
        { "detritus-slope", 0.005, 0.03, &desc->detritus_slope, NULL, true },
        { "minerals", 0.0, PEL_MINERALS_MAX, &desc->minerals_g_m3, NULL, true },
        { "backscatter-ratio", PEL_PHASE_BACK_MIN, PEL_PHASE_BACK_MAX,
          &desc->back, &desc->has_back, false },
    };
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; i < G_N_ELEMENTS(all) && status == CTL_DONE; i++) {
        if (!ctl_flag(ctl, all[i].name)) {
            continue;
        }
        if (all[i].chlorophyll && desc->kind != PEL_WATER_CHLOROPHYLL) {
            return ctl_say(CTL_USAGE,
                           "--%s is a constituent of a water by --chlorophyll",
                           all[i].name);
        }
        status = ctl_number(ctl, all[i].name, all[i].minimum, all[i].maximum,
                            all[i].out);
        if (all[i].given) {
            *all[i].given = true;
        }
    }
    int phase = PEL_PARTICLES_FOURNIER_FORAND;
    if (status == CTL_DONE) {
        status = choose(ctl, "phase", pel_particles_word, &phase);
    }
    desc->phase = (enum pel_particles)phase;
    return status;
}

/* --wavelengths: numbers with commas between, or FROM:TO:STEP. */
static enum ctl_exit read_wavelengths(const struct ctl *ctl, struct question *q)
{
    const char *text = ctl_value(ctl, "wavelengths");
    if (!text) {
        memcpy(q->nm, pel_water_wavelength_nm, N * sizeof *q->nm);
        q->count = N;
        return CTL_DONE;
    }
    bool range = strchr(text, ':') != NULL;
    g_auto(GStrv) parts = g_strsplit(text, range ? ":" : ",", -1);
    double given[MOST];
    int count = 0;
    bool right = true;
    for (int i = 0; parts[i] && right; i++) {
        right = count < MOST && ctl_parse_number(parts[i], &given[count++]);
    }
    if (range && right && count == 3 && given[2] >= 5.0) {
        for (double nm = given[0]; nm <= given[1] + 1e-9 && q->count < MOST;
             nm += given[2]) {
            q->nm[q->count++] = nm;
        }
    } else if (!range && right) {
        memcpy(q->nm, given, sizeof given);
        q->count = count;
    }
    for (int i = 0; i < q->count; i++) {
        right = right && q->nm[i] >= PEL_SEAWATER_NM_MIN &&
                q->nm[i] <= PEL_SEAWATER_NM_MAX;
    }
    return right && q->count > 0
               ? CTL_DONE
               : ctl_say(CTL_USAGE,
                         "--wavelengths %s: up to %d of 400 to 700 nm are "
                         "wanted (440,550), or FROM:TO:STEP with steps of 5 at "
                         "least (400:700:10)",
                         text, MOST);
}

static enum ctl_exit read_water(struct ctl *ctl,
                                struct pel_water_desc *out_desc,
                                struct pel_water_body *out)
{
    bool direct = ctl_flag(ctl, "absorption") || ctl_flag(ctl, "scattering") ||
                  ctl_flag(ctl, "asymmetry");
    int ways = direct + ctl_flag(ctl, "chlorophyll") + ctl_flag(ctl, "jerlov") +
               ctl_flag(ctl, "name");
    if (ways > 1) {
        return ctl_say(CTL_USAGE,
                       "say what the water is in one way: --absorption with "
                       "--scattering, --chlorophyll, --jerlov or --name");
    }
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 0.2,
                                   .salinity_g_kg = PEL_SALINITY_USUAL,
                                   .temperature_c = PEL_TEMPERATURE_USUAL,
                                   .depth_m = 1000.0,
                                   .raman = !ctl_flag(ctl, "no-raman") };
    int jerlov = 0, name = 0;
    enum ctl_exit status = direct ? read_coefficients(ctl, &desc) : CTL_DONE;
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "chlorophyll", PEL_CHLOROPHYLL_MIN,
                            PEL_CHLOROPHYLL_MAX, &desc.chlorophyll_mg_m3);
    }
    if (status == CTL_DONE) {
        status = choose(ctl, "jerlov", pel_jerlov_word, &jerlov);
    }
    if (status == CTL_DONE) {
        status = choose(ctl, "name", pel_water_name_word, &name);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "salinity", 0.0, PEL_SALINITY_MAX,
                            &desc.salinity_g_kg);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "temperature", PEL_TEMPERATURE_MIN,
                            PEL_TEMPERATURE_MAX, &desc.temperature_c);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "depth", PEL_DEPTH_MIN, PEL_DEPTH_MAX,
                            &desc.depth_m);
    }
    if (status == CTL_DONE) {
        status = read_bottom(ctl, &desc);
    }
    if (status != CTL_DONE) {
        return status;
    }
    if (ctl_flag(ctl, "jerlov") || ctl_flag(ctl, "name")) {
        desc.kind = ctl_flag(ctl, "name") ? PEL_WATER_NAMED : PEL_WATER_JERLOV;
        desc.jerlov = (enum pel_jerlov)jerlov;
        desc.name = (enum pel_water_name)name;
    }
    status = read_constituents(ctl, &desc);
    struct pel_fault fault;
    if (status == CTL_DONE && pel_water_resolve(&desc, out, &fault)) {
        return ctl_say(CTL_USAGE, "%s", fault.message);
    }
    *out_desc = desc;
    return status;
}

static enum ctl_exit read_question(struct ctl *ctl, struct question *q)
{
    int orders = PEL_ORDERS_ALL, source = 0;
    const struct {
        const char *name;
        double minimum, maximum, *out;
    } numbers[] = {
        { "sun-zenith", 0.0, 90.0, &q->sun_zenith },
        { "view-zenith", 0.0, 90.0, &q->view_zenith },
        { "azimuth", -360.0, 360.0, &q->azimuth },
        { "paths", 1000.0, 1e9, &q->paths },
        { "seed", 0.0, 4294967295.0, &q->seed },
    };
    enum ctl_exit status = read_water(ctl, &q->desc, &q->body);
    if (status == CTL_DONE) {
        status = read_wavelengths(ctl, q);
    }
    for (size_t i = 0; i < G_N_ELEMENTS(numbers) && status == CTL_DONE; i++) {
        status = ctl_number(ctl, numbers[i].name, numbers[i].minimum,
                            numbers[i].maximum, numbers[i].out);
    }
    if (status == CTL_DONE) {
        status = choose(ctl, "orders", order_word, &orders);
    }
    if (status == CTL_DONE) {
        status = choose(ctl, "from", source_word, &source);
    }
    q->orders = (enum pel_water_orders)orders;
    q->montecarlo = source == 1;
    q->gpu = source == 2;
    if (status == CTL_DONE && (q->montecarlo || q->gpu) &&
        ctl_flag(ctl, "wavelengths")) {
        return ctl_say(CTL_USAGE, "--wavelengths is for --from reference");
    }
    if (status == CTL_DONE && q->montecarlo && ctl_flag(ctl, "orders")) {
        return ctl_say(
            CTL_USAGE,
            "--orders is for --from reference and gpu: a Monte Carlo "
            "keeps all of them apart");
    }
    return status;
}

static void put_list(const char *name, const double *v, int count,
                     const char *after)
{
    printf("\"%s\": [", name);
    for (int i = 0; i < count; i++) {
        printf("%s%.6g", i ? ", " : "", v[i]);
    }
    printf("]%s", after);
}

static void put_three(const char *name, const double v[N], const char *after)
{
    put_list(name, v, N, after);
}

/* Properties of the water that are printed, by wavelength. */
static void put_properties(const struct question *q)
{
    static const char *const names[] = {
        "absorption",          "scattering",
        "asymmetry",           "albedo",
        "waterAbsorption",     "phytoplanktonAbsorption",
        "dissolvedAbsorption", "detritusAbsorption",
        "molecularScattering", "particleScattering",
        "backscattering",      "backscatterRatio",
    };
    double v[G_N_ELEMENTS(names)][MOST];
    for (int i = 0; i < q->count; i++) {
        struct pel_iop iop = pel_water_iop(&q->desc, q->nm[i]);
        struct pel_medium m = pel_water_medium_at(&q->desc, &q->body, q->nm[i]);
        const double all[] = {
            m.absorption,
            m.scattering,
            pel_medium_mean_cosine(&m),
            m.albedo,
            iop.water,
            iop.phytoplankton,
            iop.dissolved,
            iop.detritus,
            iop.molecular,
            iop.particles,
            m.scattering * (1.0 - pel_medium_forward(&m)),
            m.back > 0.0 ? m.back : 1.0 - pel_hg_forward_fraction(m.asymmetry),
        };
        for (size_t k = 0; k < G_N_ELEMENTS(names); k++) {
            v[k][i] = all[k];
        }
    }
    for (size_t k = 0; k < G_N_ELEMENTS(names); k++) {
        printf("    ");
        put_list(names[k], v[k], q->count, ",\n");
    }
}

static void put_question(const struct question *q)
{
    const struct pel_water_body *b = &q->body;
    printf("{\n  \"from\": \"%s\",\n", source_word(q->gpu ? 2 : q->montecarlo));
    printf("  \"orders\": \"%s\",\n", order_words[q->orders]);
    printf("  \"sunZenith\": %g,\n  \"viewZenith\": %g,\n  \"azimuth\": %g,\n",
           q->sun_zenith, q->view_zenith, q->azimuth);
    printf("  \"water\": {");
    put_list("wavelength", q->nm, q->count, ",\n");
    put_properties(q);
    printf("    \"depth\": %g},\n", b->depth_m);
    printf("  \"unit\": \"1/sr\",\n");
}

/* Parts of an answer, in the order they are printed. */
static const char *const parts[] = {
    "single",          "second", "higher", "bottomDirect",
    "bottomScattered", "raman",  "total"
};
#define PARTS G_N_ELEMENTS(parts)

static void put_parts(const char *name, double v[PARTS][MOST], int count,
                      const char *after)
{
    printf("  \"%s\": {\n", name);
    for (size_t k = 0; k < PARTS; k++) {
        printf("    ");
        put_list(parts[k], v[k], count, k + 1 < PARTS ? ",\n" : "\n");
    }
    printf("  }%s\n", after);
}

static enum ctl_exit answer_reference(const struct question *q)
{
    struct pel_geometry at = { q->sun_zenith * PEL_DEG,
                               q->view_zenith * PEL_DEG, q->azimuth * PEL_DEG };
    double v[PARTS][MOST], rrs[MOST], reflectance[MOST], attenuation[MOST];
    for (int i = 0; i < q->count; i++) {
        struct pel_water_report r;
        if (pel_water_report(&q->desc, &q->body, q->nm[i], &at, q->orders,
                             &r)) {
            return ctl_say(CTL_FAILED, "no memory");
        }
        const struct pel_leaving *l = &r.leaving;
        const double all[PARTS] = { l->single,           l->second,
                                    l->higher,           l->bottom_direct,
                                    l->bottom_scattered, r.raman,
                                    l->total + r.raman };
        for (size_t k = 0; k < PARTS; k++) {
            v[k][i] = all[k];
        }
        rrs[i] = r.rrs;
        reflectance[i] = r.reflectance;
        attenuation[i] = r.attenuation;
    }
    put_question(q);
    put_parts("leaving", v, q->count, ",");
    printf("  ");
    put_list("remoteSensingReflectance", rrs, q->count, ",\n  ");
    put_list("irradianceReflectance", reflectance, q->count, ",\n  ");
    put_list("diffuseAttenuation", attenuation, q->count, "\n}\n");
    return CTL_DONE;
}

static enum ctl_exit answer_montecarlo(const struct question *q)
{
    struct pel_montecarlo_sun sun = { q->sun_zenith * PEL_DEG,
                                      q->azimuth * PEL_DEG };
    double v[PARTS][MOST], error[PARTS][MOST];
    for (int i = 0; i < N; i++) {
        struct pel_medium m = pel_water_medium(&q->body, i);
        struct pel_montecarlo_result r;
        pel_montecarlo_leaving(&m, NULL, q->view_zenith * PEL_DEG, &sun, 1,
                               (uint64_t)q->paths, (uint64_t)q->seed + i, &r,
                               NULL);
        const struct pel_estimate all[PARTS] = {
            r.single,           r.second,     r.higher, r.bottom_direct,
            r.bottom_scattered, { 0.0, 0.0 }, r.total
        };
        for (size_t k = 0; k < PARTS; k++) {
            v[k][i] = all[k].mean;
            error[k][i] = all[k].error;
        }
    }
    put_question(q);
    put_parts("leaving", v, N, ",");
    put_parts("standardError", error, N, "\n}");
    return CTL_DONE;
}

static int set(Pelagos__Patch *patch, const char *path, bool given,
               double value)
{
    return given ? pel_path_set_number(patch, NULL, path, value, NULL)
                 : pel_path_set(patch, NULL, path, NULL, NULL);
}

/* The question's water: whatever the state says of it, the answer is for
 * this. */
static void patch_water(Pelagos__Patch *patch, const struct question *q)
{
    static const char *const names[] = { "absorption", "scattering",
                                         "asymmetry", "albedo" };
    const struct pel_water_desc *d = &q->desc;
    const double *values[] = { d->absorption, d->scattering, d->asymmetry,
                               q->body.albedo };
    static const char *const words[] = { "ALL", "TWO", "PAPER", "SINGLE" };
    bool direct = d->kind == PEL_WATER_COEFFICIENTS;
    bool by_chlorophyll = d->kind == PEL_WATER_CHLOROPHYLL;
    int err =
        set(patch, "water.jerlov", d->kind == PEL_WATER_JERLOV, d->jerlov) |
        set(patch, "water.named", d->kind == PEL_WATER_NAMED, d->name) |
        set(patch, "water.chlorophyll", by_chlorophyll, d->chlorophyll_mg_m3) |
        set(patch, "water.cdom", d->has_dissolved, d->dissolved_per_m) |
        set(patch, "water.cdomSlope", d->dissolved_slope > 0.0,
            d->dissolved_slope) |
        set(patch, "water.detritus", d->has_detritus, d->detritus_per_m) |
        set(patch, "water.detritusSlope", d->detritus_slope > 0.0,
            d->detritus_slope) |
        set(patch, "water.minerals", true, d->minerals_g_m3) |
        set(patch, "water.backscatterRatio", d->has_back, d->back) |
        set(patch, "water.phase", true, d->phase) |
        set(patch, "water.salinity", true, d->salinity_g_kg) |
        set(patch, "water.temperature", true, d->temperature_c) |
        set(patch, "water.depth", true, q->body.depth_m) |
        pel_path_set(patch, NULL, "water.raman", d->raman ? "true" : "false",
                     NULL) |
        pel_path_set(patch, NULL, "water.orders", words[q->orders], NULL);
    for (int k = 0; k < 4 * N; k++) {
        char path[40];
        snprintf(path, sizeof path, "water.%s%g", names[k / N],
                 pel_water_wavelength_nm[k % N]);
        err |= set(patch, path, direct || k / N == 3, values[k / N][k % N]);
    }
    g_assert(!err); /* our own paths */
}

/* The question as pelagosd takes it; the caller frees its patch. */
static void ask_water(const struct question *q, Pelagos__WaterQuery *water,
                      Pelagos__OpticsQuery *query)
{
    water->has_sun_zenith = water->has_view_zenith = water->has_azimuth = true;
    water->sun_zenith = q->sun_zenith;
    water->view_zenith = q->view_zenith;
    water->azimuth = q->azimuth;
    query->question_case = PELAGOS__OPTICS_QUERY__QUESTION_WATER;
    query->water = water;
    query->has_from = true;
    query->from = PELAGOS__OPTICS_SOURCE__GPU;
    query->patch = pel_patch_new();
    patch_water(query->patch, q);
}

/* From the running pelagosd: the code that colours its pictures. */
static enum ctl_exit answer_gpu(struct ctl *ctl, const struct question *q)
{
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    Pelagos__WaterQuery water = PELAGOS__WATER_QUERY__INIT;
    Pelagos__OpticsQuery query = PELAGOS__OPTICS_QUERY__INIT;
    ask_water(q, &water, &query);
    Pelagos__Optics *answer = NULL;
    struct pel_client_error error;
    if (pel_client_optics(ctl->client, &query, &answer, &error)) {
        status = ctl_report(ctl, &error);
    }
    const Pelagos__WaterLight *l = answer ? answer->water : NULL;
    if (status == CTL_DONE &&
        (!l || answer->answer_case != PELAGOS__OPTICS__ANSWER_WATER ||
         l->n_single != N || l->n_second != N || l->n_higher != N ||
         l->n_bottom != N || l->n_total != N)) {
        status = ctl_say(CTL_UNREACHABLE, "the answer lacks its numbers");
    } else if (status == CTL_DONE) {
        put_question(q);
        const double *v[] = { l->single, l->second, l->higher, l->bottom,
                              l->total };
        static const char *const names[] = { "single", "second", "higher",
                                             "bottom", "total" };
        printf("  \"device\": \"%s\",\n  \"leaving\": {\n",
               answer->device ? answer->device : "");
        for (int k = 0; k < 5; k++) {
            printf("    ");
            put_three(names[k], v[k], k < 4 ? ",\n" : "\n  }\n}\n");
        }
    }
    if (answer) {
        pelagos__optics__free_unpacked(answer, NULL);
    }
    pelagos__patch__free_unpacked(query.patch, NULL);
    return status;
}

/* Of a named bottom the whole spectrum, not what the three wavelengths see. */
static void patch_bottom(Pelagos__Patch *patch, const struct question *q)
{
    int err = 0;
    if (q->desc.bottom == PEL_BOTTOM_ALBEDO) {
        return;
    }
    for (int k = 0; k < N; k++) {
        char path[40];
        snprintf(path, sizeof path, "water.albedo%g",
                 pel_water_wavelength_nm[k]);
        err |= pel_path_set(patch, NULL, path, NULL, NULL);
    }
    g_autofree char *word = g_ascii_strup(pel_bottom_word(q->desc.bottom), -1);
    err |= pel_path_set(patch, NULL, "water.bottom", word, NULL);
    g_assert(!err); /* our own paths */
}

/* A series, from the running pelagosd. */
static enum ctl_exit answer_series(struct ctl *ctl, const struct question *q)
{
    Pelagos__WaterQuery water = PELAGOS__WATER_QUERY__INIT;
    Pelagos__OpticsQuery query = PELAGOS__OPTICS_QUERY__INIT;
    Pelagos__SeriesQuery series = PELAGOS__SERIES_QUERY__INIT;
    if (ctl_flag(ctl, "wavelengths")) {
        return ctl_say(CTL_USAGE, "with --sweep, wavelengths are an axis: "
                                  "--sweep wavelength=400:700:10");
    }
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    ask_water(q, &water, &query);
    query.from = q->gpu          ? PELAGOS__OPTICS_SOURCE__GPU
                 : q->montecarlo ? PELAGOS__OPTICS_SOURCE__MONTECARLO
                                 : PELAGOS__OPTICS_SOURCE__REFERENCE;
    water.has_paths = water.has_seed = q->montecarlo;
    water.paths = (uint32_t)q->paths;
    water.seed = (uint32_t)q->seed;
    patch_bottom(query.patch, q);
    series.question_case = PELAGOS__SERIES_QUERY__QUESTION_OPTICS;
    series.optics = &query;
    status = ctl_series(ctl, &series);
    pelagos__patch__free_unpacked(query.patch, NULL);
    return status;
}

enum ctl_exit ctl_optics(struct ctl *ctl)
{
    const char *what = ctl->args[0];
    if (strcmp(what, "brdf") == 0 || strcmp(what, "sky") == 0) {
        return ctl_light(ctl);
    }
    if (strcmp(what, "water") != 0) {
        return ctl_say(CTL_USAGE,
                       "optics of what? `pelagosctl optics water`, `brdf`, "
                       "`sky`");
    }
    if (ctl->arg_count > 1) {
        return ctl_say(CTL_USAGE, "optics water takes options, not %s",
                       ctl->args[1]);
    }
    struct question q = { .sun_zenith = 30.0, .paths = 1e5, .seed = 1.0 };
    enum ctl_exit status = read_question(ctl, &q);
    if (status != CTL_DONE) {
        return status;
    }
    if (ctl_wants_series(ctl)) {
        return answer_series(ctl, &q);
    }
    return q.gpu          ? answer_gpu(ctl, &q)
           : q.montecarlo ? answer_montecarlo(&q)
                          : answer_reference(&q);
}
