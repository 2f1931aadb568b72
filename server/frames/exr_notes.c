#include "frames/exr_notes.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "frames/picture_notes.h"
#include "ocean/directional.h"
#include "ocean/report.h"
#include "pelagos.pb-c.h"

/* Text that the list points into; what has no room is left out. */
__attribute__((format(printf, 2, 3))) static const char *
keep(struct pel_exr_notes *n, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    size_t room = sizeof n->text - n->used;
    char *at = n->text + n->used;
    int size = vsnprintf(at, room, format, args);
    va_end(args);
    if (size < 0 || (size_t)size >= room) {
        return "";
    }
    n->used += (size_t)size + 1;
    return at;
}

static void add(struct pel_exr_notes *n, struct pel_exr_attribute attribute)
{
    if (n->count < PEL_EXR_NOTES) {
        n->list[n->count++] = attribute;
    }
}

static void add_text(struct pel_exr_notes *n, const char *name,
                     const char *text)
{
    add(n, (struct pel_exr_attribute){
               .name = name, .type = PEL_EXR_STRING, .string = text });
}

static void add_number(struct pel_exr_notes *n, const char *name, double v)
{
    add(n, (struct pel_exr_attribute){
               .name = name, .type = PEL_EXR_DOUBLE, .number = v });
}

/* Of a mathematical direction that waves go to. */
static double from_deg(double to_rad)
{
    double d = fmod(270.0 - to_rad / PEL_DEG, 360.0);
    return d < 0 ? d + 360.0 : d;
}

static const char *enum_word(const ProtobufCEnumDescriptor *all, int value)
{
    const ProtobufCEnumValue *v =
        protobuf_c_enum_descriptor_get_value(all, value);
    return v ? v->name : "";
}

static void list_trains(struct pel_exr_notes *n,
                        const struct pel_sea_desc *desc)
{
    char text[1024];
    int used = 0;
    for (int i = 0; i < desc->swell_count; i++) {
        const struct pel_swell_desc *s = &desc->swell[i];
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s%g m, %g s, from %g deg, spread %g deg",
                         i ? "; " : "", s->height_m, s->period_s,
                         from_deg(s->direction_rad), s->spread_rad / PEL_DEG);
    }
    if (desc->swell_count > 0) {
        add_text(n, "pelagos.swell", keep(n, "%s", text));
    }
    used = 0;
    for (int i = 0; i < desc->single_count; i++) {
        const struct pel_single_desc *s = &desc->single[i];
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s%g m, %g s, from %g deg, phase %g deg",
                         i ? "; " : "", s->height_m, s->period_s,
                         from_deg(s->direction_rad), s->phase_rad / PEL_DEG);
    }
    if (desc->single_count > 0) {
        add_text(n, "pelagos.singleWaves", keep(n, "%s", text));
    }
}

static void list_sea(struct pel_exr_notes *n, const struct pel_environment *env)
{
    const struct pel_sea *sea = env->sea;
    struct pel_directional *spectrum = NULL;
    add_text(
        n, "pelagos.spectrum",
        enum_word(&pelagos__spectrum_kind__descriptor, (int)sea->desc.kind));
    add_number(n, "pelagos.drawnHeight", 4.0 * sqrt(sea->m0));
    if (pel_directional_create(&sea->desc, &spectrum) == PEL_OK) {
        struct pel_sea_report report;
        pel_sea_report(sea, spectrum, 0, &report);
        add_number(n, "pelagos.significantHeight",
                   4.0 * sqrt(report.spectrum.m0));
        if (report.spectrum.m0 > 0 && report.peak_omega > 0) {
            add_number(n, "pelagos.peakPeriod",
                       2.0 * PEL_PI / report.peak_omega);
            add_number(n, "pelagos.waveDirection",
                       from_deg(report.mean_to_rad));
        }
        pel_directional_destroy(spectrum);
    }
    list_trains(n, &sea->desc);
    add_number(n, "pelagos.seaLevel", env->sea_level_m);
}

static const char *three(struct pel_exr_notes *n, const double v[3])
{
    return keep(n, "%.9g %.9g %.9g", v[0], v[1], v[2]);
}

static void list_constituents(struct pel_exr_notes *n,
                              const struct pel_water_desc *d)
{
    struct pel_iop iop = pel_water_iop(d, 440.0);
    add_number(n, "pelagos.chlorophyll", d->chlorophyll_mg_m3);
    add_number(n, "pelagos.cdom", iop.dissolved);
    add_number(n, "pelagos.detritus", iop.detritus);
    add_number(n, "pelagos.minerals", d->minerals_g_m3);
}

static void list_water(struct pel_exr_notes *n, const struct pel_snapshot *s,
                       const struct pel_water_body *water)
{
    const struct pel_water_desc *d = &s->water_desc;
    double back[PEL_WATER_WAVELENGTHS];
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        struct pel_medium m = pel_water_medium(water, i);
        back[i] = 1.0 - pel_medium_forward(&m);
    }
    add_text(n, "pelagos.water",
             d->kind == PEL_WATER_CHLOROPHYLL ? "constituents"
             : d->kind == PEL_WATER_JERLOV
                 ? keep(n, "Jerlov %s", pel_jerlov_word((int)d->jerlov))
             : d->kind == PEL_WATER_NAMED
                 ? keep(n, "%s", pel_water_name_word((int)d->name))
                 : "coefficients");
    if (d->kind == PEL_WATER_CHLOROPHYLL) {
        list_constituents(n, d);
    }
    add_number(n, "pelagos.salinity", d->salinity_g_kg);
    add_number(n, "pelagos.waterTemperature", d->temperature_c);
    add_number(n, "pelagos.waterDepth", water->depth_m);
    add_text(n, "pelagos.absorption", three(n, water->absorption));
    add_text(n, "pelagos.scattering", three(n, water->scattering));
    add_text(n, "pelagos.backscatterRatio", three(n, back));
    add_text(n, "pelagos.bottomAlbedo", three(n, water->albedo));
}

static void list_camera(struct pel_exr_notes *n, const struct pel_job *job,
                        size_t draw)
{
    const struct pel_camera *c = &job->draws[draw].camera;
    double heading, pitch, roll;
    pel_camera_attitude(job, draw, &heading, &pitch, &roll);
    add_text(n, "pelagos.projection", "rectilinear");
    add_number(n, "pelagos.horizontalField",
               pel_camera_field(c->tan_left, c->tan_right));
    add_number(n, "pelagos.verticalField",
               pel_camera_field(c->tan_bottom, c->tan_top));
    add_number(n, "pelagos.tanLeft", c->tan_left);
    add_number(n, "pelagos.tanRight", c->tan_right);
    add_number(n, "pelagos.tanTop", c->tan_top);
    add_number(n, "pelagos.tanBottom", c->tan_bottom);
    add_number(n, "pelagos.heading", heading);
    add_number(n, "pelagos.pitch", pitch);
    add_number(n, "pelagos.roll", roll);
    add_number(n, "pelagos.east", c->east_m);
    add_number(n, "pelagos.north", c->north_m);
    if (pel_camera_in_ground(job, draw)) {
        add_text(n, "pelagos.ground", "inside");
    }
}

void pel_exr_notes_list(const struct pel_output *output,
                        struct pel_exr_notes *out)
{
    const struct pel_job *job = output->job;
    out->count = out->used = 0;
    list_sea(out, &job->environment);
    list_water(out, job->snapshot, &job->environment.water);
    add_text(out, "pelagos.wavelengths", "680 550 440");
    add_text(out, "pelagos.bandwidths", "0 0 0"); /* monochromatic */
    list_camera(out, job, output->draw);
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        if (output->layers & l->bit) {
            const char *name = keep(out, "pelagos.unit.%s", l->name);
            if (*name) {
                add_text(out, name, l->unit);
            }
        }
    }
}
