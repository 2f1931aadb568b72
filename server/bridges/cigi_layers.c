/* Weather Control's layers that are seen: ground fog as sky.fog, a layer over
 * the whole sea or a bank in the place of a region, and the cloud layer that
 * covers most as the scene's clouds. */
#include <math.h>
#include <string.h>

#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"

#define GROUND_FOG 0
#define FIRST_CLOUD 1
#define LAST_CLOUD 3
#define REGIONAL 1
#define ON_THE_SEA_M 10.0

static struct pel_cigi_layer *layer_of(struct pel_cigi_edit *edit,
                                       unsigned layer, bool regional,
                                       unsigned region, bool make)
{
    struct pel_cigi_layer *spare = NULL;
    for (size_t i = 0; i < PEL_CIGI_LAYERS; i++) {
        struct pel_cigi_layer *l = &edit->world->layers[i];
        if (l->used && l->layer == layer && l->regional == regional &&
            (!regional || l->region == region)) {
            return l;
        }
        spare = !l->used && !spare ? l : spare;
    }
    edit->skipped += make && !spare;
    return make ? spare : NULL;
}

bool pel_cigi_take_layer(struct pel_cigi_edit *edit,
                         const struct pel_cigi_packet *p)
{
    unsigned layer = (unsigned)pel_cigi_get(p, PEL_CIGI_WEATHER_LAYER);
    unsigned region = (unsigned)pel_cigi_get(p, PEL_CIGI_WEATHER_REGION);
    double scope = pel_cigi_get(p, PEL_CIGI_WEATHER_SCOPE);
    double thickness = pel_cigi_get(p, PEL_CIGI_WEATHER_THICKNESS);
    bool cloud = layer >= FIRST_CLOUD && layer <= LAST_CLOUD &&
                 pel_cigi_get(p, PEL_CIGI_WEATHER_CLOUD) > 0 && scope == 0;
    bool fog = layer == GROUND_FOG && thickness > 0 && scope <= REGIONAL;
    bool on = pel_cigi_get(p, PEL_CIGI_WEATHER_ENABLE) != 0 && (cloud || fog);
    struct pel_cigi_layer *l =
        layer_of(edit, layer, scope == REGIONAL, region, on);
    if (!l) {
        return false;
    }
    *l = (struct pel_cigi_layer){
        .used = on,
        .layer = layer,
        .regional = scope == REGIONAL,
        .region = scope == REGIONAL ? region : 0,
        .type = (int)pel_cigi_get(p, PEL_CIGI_WEATHER_CLOUD),
        .coverage = pel_cigi_get(p, PEL_CIGI_WEATHER_COVERAGE),
        .base_m = pel_cigi_get(p, PEL_CIGI_WEATHER_BASE),
        .thickness_m = thickness,
        .band_m = pel_cigi_get(p, PEL_CIGI_WEATHER_BAND),
        .visibility_m = pel_cigi_get(p, PEL_CIGI_WEATHER_VISIBILITY),
    };
    return on;
}

/* --- fog ------------------------------------------------------------------ */

static const struct pel_cigi_region *region_at(const struct pel_cigi_world *w,
                                               unsigned id)
{
    for (size_t i = 0; i < PEL_CIGI_REGIONS; i++) {
        const struct pel_cigi_region *r = &w->regions[i];
        if (r->used && r->active && r->id == id) {
            return r;
        }
    }
    return NULL;
}

/* A bank has the region's area; half of it, where q is 0.5, is full. */
static double radius_of(const struct pel_cigi_region *r)
{
    double x = fmax(r->x_m, 0) + 2 * fmax(r->radius_m, 0) + r->transition_m;
    double y = fmax(r->y_m, 0) + 2 * fmax(r->radius_m, 0) + r->transition_m;
    return pel_clamp(sqrt(x * y / PEL_PI), 50, 20000);
}

static bool fog_of(const struct pel_cigi_world *w,
                   const struct pel_cigi_layer *l, Pelagos__Fog *f)
{
    const struct pel_cigi_region *r =
        l->regional ? region_at(w, l->region) : NULL;
    if (!l->used || l->layer != GROUND_FOG || (l->regional && !r)) {
        return false;
    }
    pelagos__fog__init(f);
    f->has_visibility = f->has_bottom = f->has_top = f->has_edge = true;
    f->visibility = pel_clamp(l->visibility_m, 20, 100000);
    f->bottom = l->base_m > ON_THE_SEA_M ? pel_clamp(l->base_m, 0, 10000) : 0;
    f->top =
        pel_clamp(fmax(l->base_m, 0) + l->thickness_m, f->bottom + 2, 12000);
    f->edge = pel_clamp(l->band_m, 1, 2000);
    if (r) {
        f->has_radius = f->has_latitude = f->has_longitude = true;
        f->has_speed = true;
        f->radius = radius_of(r);
        f->latitude = pel_clamp(r->latitude, -90, 90);
        f->longitude = pel_clamp(r->longitude, -180, 180);
        f->speed = 0;
    }
    return true;
}

static bool same_fog(const Pelagos__Fog *a, const Pelagos__Fog *b)
{
    return a->visibility == b->visibility && a->bottom == b->bottom &&
           a->top == b->top && a->edge == b->edge &&
           a->has_radius == b->has_radius &&
           (!a->has_radius ||
            (a->radius == b->radius && a->latitude == b->latitude &&
             a->longitude == b->longitude));
}

static void put_fog(struct pel_cigi_edit *edit, const Pelagos__Fog *f)
{
    size_t n = edit->sky.n_fog;
    if (n < PEL_FOG_MAX) {
        edit->fog[n] = *f;
        edit->fog_list[n] = &edit->fog[n];
        edit->sky.n_fog = n + 1;
        edit->state.sky = &edit->sky;
    }
}

/* Those of others come first in the list. */
static void apply_fog(struct pel_cigi_edit *edit)
{
    struct pel_cigi_world *w = edit->world;
    const Pelagos__Sky *now = edit->scene->sky;
    Pelagos__Fog ours[PEL_FOG_MAX];
    size_t count = 0, others = now->n_fog;
    others -= others < w->fog_count ? others : w->fog_count;
    for (size_t i = 0; i < PEL_CIGI_LAYERS && others + count < PEL_FOG_MAX;
         i++) {
        count += fog_of(w, &w->layers[i], &ours[count]) ? 1 : 0;
    }
    bool same = others + count == now->n_fog && count == w->fog_count;
    for (size_t i = 0; same && i < count; i++) {
        same = same_fog(now->fog[others + i], &ours[i]);
    }
    if (same) {
        return;
    }
    for (size_t i = 0; i < others; i++) {
        put_fog(edit, now->fog[i]);
    }
    for (size_t i = 0; i < count; i++) {
        put_fog(edit, &ours[i]);
    }
    w->fog_count = count;
    if (edit->sky.n_fog == 0) {
        pel_cigi_edit_remove(edit, "sky.fog");
    }
}

/* --- clouds --------------------------------------------------------------- */

static Pelagos__CloudGenus genus_of(int type)
{
    static const Pelagos__CloudGenus genera[] = {
        PELAGOS__CLOUD_GENUS__CUMULUS,      PELAGOS__CLOUD_GENUS__ALTOCUMULUS,
        PELAGOS__CLOUD_GENUS__ALTOSTRATUS,  PELAGOS__CLOUD_GENUS__CIRRUS,
        PELAGOS__CLOUD_GENUS__CIRRUS,       PELAGOS__CLOUD_GENUS__CIRRUS,
        PELAGOS__CLOUD_GENUS__CUMULONIMBUS, PELAGOS__CLOUD_GENUS__CUMULUS,
        PELAGOS__CLOUD_GENUS__NIMBOSTRATUS, PELAGOS__CLOUD_GENUS__STRATOCUMULUS,
        PELAGOS__CLOUD_GENUS__STRATUS
    };
    return type >= 0 && type <= 10 ? genera[type]
                                   : PELAGOS__CLOUD_GENUS__CUMULUS;
}

static void put_clouds(struct pel_cigi_edit *edit,
                       const struct pel_cigi_layer *l)
{
    edit->state.sky = &edit->sky;
    edit->sky.has_cloud_cover = true;
    edit->sky.cloud_cover = l ? pel_clamp(0.08 * l->coverage, 0, 8) : 0;
    if (l) {
        edit->sky.has_cloud_genus = edit->sky.has_cloud_base = true;
        edit->sky.cloud_genus = genus_of(l->type);
        edit->sky.cloud_base = pel_clamp(l->base_m, 30, 12000);
        edit->sky.has_cloud_thickness = l->thickness_m > 0;
        edit->sky.cloud_thickness = pel_clamp(l->thickness_m, 50, 12000);
    }
}

static void apply_clouds(struct pel_cigi_edit *edit)
{
    struct pel_cigi_world *w = edit->world;
    const Pelagos__Sky *now = edit->scene->sky;
    const struct pel_cigi_layer *most = NULL;
    for (size_t i = 0; i < PEL_CIGI_LAYERS; i++) {
        const struct pel_cigi_layer *l = &w->layers[i];
        if (l->used && l->layer != GROUND_FOG &&
            (!most || l->coverage > most->coverage)) {
            most = l;
        }
    }
    if (!most && !w->clouded) {
        return;
    }
    w->clouded = most != NULL;
    double cover = most ? pel_clamp(0.08 * most->coverage, 0, 8) : 0;
    if (now->cloud_cover != cover ||
        (most &&
         (now->cloud_genus != genus_of(most->type) ||
          now->cloud_base != pel_clamp(most->base_m, 30, 12000) ||
          (most->thickness_m > 0 &&
           now->cloud_thickness != pel_clamp(most->thickness_m, 50, 12000))))) {
        put_clouds(edit, most);
    }
}

void pel_cigi_apply_layers(struct pel_cigi_edit *edit)
{
    apply_fog(edit);
    apply_clouds(edit);
}
