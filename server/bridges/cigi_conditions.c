/* Which weather and water hold where the first view is, and their way into the
 * patch. */
#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"

/* Within a transition the wind changes in such steps: each makes a new sea. */
#define WIND_STEP_MPS 0.5
#define WIND_STEP_DEG 5.0

/* --- where --------------------------------------------------------------- */

/* How far a region holds at `eye`: 1 within a rectangle of sides x and y about
 * the centre whose corners are rounded off outside by the corner radius, then
 * falling to 0 across the transition. */
static double weight_at(const struct pel_cigi_edit *edit,
                        const struct pel_cigi_region *r, struct pel_vec2 eye)
{
    double place[3] = { r->latitude, r->longitude, 0 };
    struct pel_vec3 centre;
    if (!pel_cigi_place(edit->snapshot, edit->time_s, false, 0, place,
                        &centre)) {
        return 0;
    }
    double dx = eye.x - centre.x, dy = eye.y - centre.y;
    double turn = r->rotation_deg * PEL_DEG;
    double along = fabs(dx * sin(turn) + dy * cos(turn));
    double across = fabs(dx * cos(turn) - dy * sin(turn));
    double out_x = fmax(along - 0.5 * r->x_m, 0);
    double out_y = fmax(across - 0.5 * r->y_m, 0);
    double beyond = hypot(out_x, out_y) - fmax(r->radius_m, 0);
    if (beyond <= 0) {
        return 1;
    }
    return beyond < r->transition_m ? 1 - beyond / r->transition_m : 0;
}

/* --- mixing -------------------------------------------------------------- */

static double mix(double a, double b, double weight)
{
    return a + weight * (b - a);
}

/* Of what is seen and of what absorbs, by ratio. */
static double mix_ratio(double a, double b, double weight)
{
    return weight >= 1 || a <= 0 ? b : a * pow(b / a, weight);
}

/* `to` is where the value was commanded by what lies around; where nothing
 * was, the region's holds from the middle of its transition on. */
static void blend(bool *has, double *to, bool with_has, double with,
                  double weight, double (*how)(double, double, double))
{
    if (!with_has) {
        return;
    }
    if (*has && weight < 1) {
        *to = how(*to, with, weight);
    } else if (weight >= 0.5) {
        *has = true;
        *to = with;
    }
}

/* The wind goes over as a vector, in steps. */
static void blend_wind(bool *has, double *mps, double *deg, bool with_has,
                       double with_mps, double with_deg, double weight)
{
    if (!with_has) {
        return;
    }
    if (!*has || weight >= 1) {
        if (weight >= 0.5) {
            *has = true;
            *mps = with_mps;
            *deg = with_deg;
        }
        return;
    }
    double east = mix(*mps * sin(*deg * PEL_DEG),
                      with_mps * sin(with_deg * PEL_DEG), weight);
    double north = mix(*mps * cos(*deg * PEL_DEG),
                       with_mps * cos(with_deg * PEL_DEG), weight);
    *mps = round(hypot(east, north) / WIND_STEP_MPS) * WIND_STEP_MPS;
    *deg = pel_cigi_wrap(round(atan2(east, north) / PEL_DEG / WIND_STEP_DEG) *
                         WIND_STEP_DEG);
}

static void blend_trains(bool *has, struct pel_cigi_train *to, bool with_has,
                         const struct pel_cigi_train *with, double weight)
{
    if (with_has && weight >= 0.5) {
        *has = true;
        memcpy(to, with, PEL_CIGI_TRAINS * sizeof *to);
    }
}

static void overlay(struct pel_cigi_conditions *on,
                    const struct pel_cigi_conditions *with, double weight)
{
    blend(&on->has_visibility, &on->visibility_m, with->has_visibility,
          with->visibility_m, weight, mix_ratio);
    /* A layer of fog goes over into the clear air around it. */
    if (with->has_layer_visibility && !on->has_layer_visibility &&
        on->has_visibility) {
        on->has_layer_visibility = true;
        on->layer_visibility_m = on->visibility_m;
    }
    blend(&on->has_layer_visibility, &on->layer_visibility_m,
          with->has_layer_visibility, with->layer_visibility_m, weight,
          mix_ratio);
    blend_wind(&on->has_wind, &on->wind_mps, &on->wind_deg, with->has_wind,
               with->wind_mps, with->wind_deg, weight);
    if (with->has_layer_wind && !on->has_layer_wind && on->has_wind) {
        on->has_layer_wind = true;
        on->layer_wind_mps = on->wind_mps;
        on->layer_wind_deg = on->wind_deg;
    }
    blend_wind(&on->has_layer_wind, &on->layer_wind_mps, &on->layer_wind_deg,
               with->has_layer_wind, with->layer_wind_mps, with->layer_wind_deg,
               weight);
    blend(&on->has_chlorophyll, &on->chlorophyll_mg_m3, with->has_chlorophyll,
          with->chlorophyll_mg_m3, weight, mix_ratio);
    blend(&on->has_level, &on->level_m, with->has_level, with->level_m, weight,
          mix);
    blend(&on->has_whitecaps, &on->whitecaps, with->has_whitecaps,
          with->whitecaps, weight, mix);
    blend_trains(&on->has_swell, on->swell, with->has_swell, with->swell,
                 weight);
    blend_trains(&on->has_waves, on->waves, with->has_waves, with->waves,
                 weight);
}

/* The world's, overlaid by those of the regions the first view is in. */
static struct pel_cigi_conditions effective(const struct pel_cigi_edit *edit)
{
    struct pel_cigi_conditions all = edit->world->global;
    struct pel_vec2 eye = { 0, 0 };
    if (edit->snapshot->view_count > 0) {
        struct pel_camera camera;
        pel_snapshot_camera(edit->snapshot, 0, edit->time_s, 0, 0, &camera);
        eye = (struct pel_vec2){ camera.east_m, camera.north_m };
    }
    bool done[PEL_CIGI_REGIONS] = { false };
    for (size_t n = 0; n < PEL_CIGI_REGIONS; n++) {
        const struct pel_cigi_region *next = NULL;
        for (size_t i = 0; i < PEL_CIGI_REGIONS; i++) {
            const struct pel_cigi_region *r = &edit->world->regions[i];
            if (r->used && r->active && !done[i] &&
                (!next || r->id < next->id)) {
                next = r;
            }
        }
        if (!next) {
            break;
        }
        done[next - edit->world->regions] = true;
        double weight = weight_at(edit, next, eye);
        if (weight > 0) {
            overlay(&all, &next->conditions, weight);
        }
    }
    return all;
}

/* --- into the patch ------------------------------------------------------ */

/* Values that end become what they were before the host's. True: this one is
 * the host's, and now remembered in *was. */
static bool begins(bool has, bool *was_has, double now, double *before)
{
    if (has && !*was_has) {
        *before = now;
    }
    bool ends = !has && *was_has;
    *was_has = has;
    return !ends;
}

static void set_wind(struct pel_cigi_edit *edit, double mps, double deg)
{
    edit->state.sea = &edit->sea;
    edit->sea.has_wind_speed = edit->sea.has_wind_direction = true;
    edit->sea.wind_speed = mps;
    edit->sea.wind_direction = deg;
}

static void apply_wind(struct pel_cigi_edit *edit,
                       const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    struct pel_cigi_before *before = &edit->world->before;
    bool layer = now->has_layer_wind;
    double mps = layer ? now->layer_wind_mps : now->wind_mps;
    double deg = layer ? now->layer_wind_deg : now->wind_deg;
    bool had = was->has_wind, has = layer || now->has_wind;
    if (has && !had) {
        before->wind_deg = edit->scene->sea->wind_direction;
    }
    if (!begins(has, &was->has_wind, edit->scene->sea->wind_speed,
                &before->wind_mps)) {
        set_wind(edit, before->wind_mps, before->wind_deg);
    } else if (has && !(had && was->wind_mps == mps && was->wind_deg == deg)) {
        was->wind_mps = mps;
        was->wind_deg = deg;
        set_wind(edit, mps, deg);
    }
}

static void set_visibility(struct pel_cigi_edit *edit, double metres)
{
    edit->state.sky = &edit->sky;
    edit->sky.has_visibility = true;
    edit->sky.visibility = metres;
}

static void apply_visibility(struct pel_cigi_edit *edit,
                             const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    double *before = &edit->world->before.visibility_m;
    bool layer = now->has_layer_visibility;
    double metres = layer ? now->layer_visibility_m : now->visibility_m;
    bool had = was->has_visibility, has = layer || now->has_visibility;
    if (!begins(has, &was->has_visibility, edit->scene->sky->visibility,
                before)) {
        set_visibility(edit, *before);
    } else if (has && !(had && was->visibility_m == metres)) {
        was->visibility_m = metres;
        set_visibility(edit, metres);
    }
}

static bool same_trains(const struct pel_cigi_train *a,
                        const struct pel_cigi_train *b)
{
    bool same = true;
    for (size_t i = 0; i < PEL_CIGI_TRAINS && same; i++) {
        same = a[i].used == b[i].used &&
               (!a[i].used || (a[i].height_m == b[i].height_m &&
                               a[i].period_s == b[i].period_s &&
                               a[i].from_deg == b[i].from_deg &&
                               a[i].spread_deg == b[i].spread_deg &&
                               a[i].phase_deg == b[i].phase_deg));
    }
    return same;
}

/* Whether the trains are news, and then remembers them; *now becomes `before`
 * where the host's end. */
static bool news(bool *was_has, struct pel_cigi_train *was, bool has,
                 const struct pel_cigi_train **now,
                 const struct pel_cigi_train *before)
{
    bool ends = *was_has && !has;
    bool same = *was_has && has && same_trains(was, *now);
    if (same || (!has && !ends)) {
        return false;
    }
    *was_has = has;
    memcpy(was, *now, PEL_CIGI_TRAINS * sizeof *was);
    *now = ends ? before : *now;
    return true;
}

static void keep_swell(struct pel_cigi_edit *edit)
{
    const Pelagos__Sea *sea = edit->scene->sea;
    struct pel_cigi_train *to = edit->world->before.swell;
    memset(to, 0, PEL_CIGI_TRAINS * sizeof *to);
    for (size_t i = 0; i < sea->n_swell && i < PEL_CIGI_TRAINS; i++) {
        to[i] = (struct pel_cigi_train){
            .used = true,
            .height_m = sea->swell[i]->height,
            .period_s = sea->swell[i]->period,
            .from_deg = sea->swell[i]->direction,
            .spread_deg = sea->swell[i]->spread,
        };
    }
}

static void apply_swell(struct pel_cigi_edit *edit,
                        const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    const struct pel_cigi_train *list = now->swell;
    if (now->has_swell && !was->has_swell) {
        keep_swell(edit);
    }
    if (!news(&was->has_swell, was->swell, now->has_swell, &list,
              edit->world->before.swell)) {
        return;
    }
    for (size_t i = 0; i < PEL_CIGI_TRAINS; i++) {
        const struct pel_cigi_train *s = &list[i];
        if (!s->used) {
            continue;
        }
        Pelagos__Swell *to = &edit->swell[edit->sea.n_swell];
        pelagos__swell__init(to);
        to->has_height = to->has_period = true;
        to->has_direction = to->has_spread = true;
        to->height = s->height_m;
        to->period = s->period_s;
        to->direction = s->from_deg;
        to->spread = s->spread_deg;
        edit->swell_list[edit->sea.n_swell++] = to;
        edit->state.sea = &edit->sea;
    }
    if (edit->sea.n_swell == 0) {
        pel_cigi_edit_remove(edit, "sea.swell");
    }
}

static void keep_waves(struct pel_cigi_edit *edit)
{
    const Pelagos__Sea *sea = edit->scene->sea;
    struct pel_cigi_train *to = edit->world->before.waves;
    memset(to, 0, PEL_CIGI_TRAINS * sizeof *to);
    for (size_t i = 0; i < sea->n_wave && i < PEL_CIGI_TRAINS; i++) {
        to[i] = (struct pel_cigi_train){
            .used = true,
            .height_m = sea->wave[i]->height,
            .period_s = sea->wave[i]->period,
            .from_deg = sea->wave[i]->direction,
            .phase_deg = sea->wave[i]->phase,
        };
    }
}

static void apply_waves(struct pel_cigi_edit *edit,
                        const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    const struct pel_cigi_train *list = now->waves;
    if (now->has_waves && !was->has_waves) {
        keep_waves(edit);
    }
    if (!news(&was->has_waves, was->waves, now->has_waves, &list,
              edit->world->before.waves)) {
        return;
    }
    for (size_t i = 0; i < PEL_CIGI_TRAINS; i++) {
        const struct pel_cigi_train *w = &list[i];
        if (!w->used) {
            continue;
        }
        Pelagos__Wave *to = &edit->wave[edit->sea.n_wave];
        pelagos__wave__init(to);
        to->has_height = to->has_period = true;
        to->has_direction = to->has_phase = true;
        to->height = w->height_m;
        to->period = w->period_s;
        to->direction = w->from_deg;
        to->phase = w->phase_deg;
        edit->wave_list[edit->sea.n_wave++] = to;
        edit->state.sea = &edit->sea;
    }
    if (edit->sea.n_wave == 0) {
        pel_cigi_edit_remove(edit, "sea.wave");
    }
}

static void set_chlorophyll(struct pel_cigi_edit *edit, double mg_m3)
{
    edit->state.water = &edit->water;
    edit->water.has_chlorophyll = true;
    edit->water.chlorophyll = mg_m3;
}

static void set_level(struct pel_cigi_edit *edit, double metres)
{
    edit->state.sea = &edit->sea;
    edit->sea.has_level = true;
    edit->sea.level = metres;
}

static void apply_water(struct pel_cigi_edit *edit,
                        const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    struct pel_cigi_before *before = &edit->world->before;
    bool green = was->has_chlorophyll, tide = was->has_level;
    if (!begins(now->has_chlorophyll, &was->has_chlorophyll,
                edit->scene->water->chlorophyll, &before->chlorophyll_mg_m3)) {
        set_chlorophyll(edit, before->chlorophyll_mg_m3);
    } else if (now->has_chlorophyll &&
               !(green && was->chlorophyll_mg_m3 == now->chlorophyll_mg_m3)) {
        was->chlorophyll_mg_m3 = now->chlorophyll_mg_m3;
        set_chlorophyll(edit, now->chlorophyll_mg_m3);
    }
    if (!begins(now->has_level, &was->has_level, edit->scene->sea->level,
                &before->level_m)) {
        set_level(edit, before->level_m);
    } else if (now->has_level && !(tide && was->level_m == now->level_m)) {
        was->level_m = now->level_m;
        set_level(edit, now->level_m);
    }
}

static void set_whitecaps(struct pel_cigi_edit *edit, double times)
{
    edit->state.sea = &edit->sea;
    edit->sea.has_whitecaps = true;
    edit->sea.whitecaps = times;
}

/* On: as many as there were before the host; where those were off, one time
 * what the wind makes. */
static void apply_whitecaps(struct pel_cigi_edit *edit,
                            const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    struct pel_cigi_before *before = &edit->world->before;
    bool known = was->has_whitecaps;
    if (!begins(now->has_whitecaps, &was->has_whitecaps,
                edit->scene->sea->whitecaps, &before->whitecaps)) {
        set_whitecaps(edit, before->whitecaps);
    } else if (now->has_whitecaps &&
               !(known && was->whitecaps == now->whitecaps)) {
        double whole = before->whitecaps > 0 ? before->whitecaps : 1.0;
        was->whitecaps = now->whitecaps;
        set_whitecaps(edit, now->whitecaps * whole);
    }
}

void pel_cigi_apply_conditions(struct pel_cigi_edit *edit)
{
    struct pel_cigi_conditions now = effective(edit);
    apply_wind(edit, &now);
    apply_visibility(edit, &now);
    apply_swell(edit, &now);
    apply_waves(edit, &now);
    apply_water(edit, &now);
    apply_whitecaps(edit, &now);
    pel_cigi_apply_areas(edit);
    pel_cigi_apply_layers(edit);
}
