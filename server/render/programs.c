#include "render/programs.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "ocean/foam.h"
#include "render/coast.h"
#include "render/shader.h"

static void delete_sea_programs(struct pel_sea_programs *p)
{
    for (int i = 0; i < PEL_SHADE_COUNT; i++) {
        pel_program_delete(p->fragments[i]);
        pel_program_delete(p->compute_program[i]);
        pel_program_delete(p->coast[i]);
        pel_program_delete(p->shallow[i]);
        for (int k = 0; k < PEL_OBJECTS_KNOWN_COUNT; k++) {
            pel_program_delete(p->near[k][i]);
        }
        for (int k = 0; k < PEL_COAST_TILES; k++) {
            pel_program_delete(p->objects[k][i]);
        }
    }
    pel_program_delete(p->mesh);
    pel_program_delete(p->together_mesh);
    pel_program_delete(p->together);
    *p = (struct pel_sea_programs){ 0 };
}

static const char *const kind_defines[PEL_SHADE_COUNT] = {
    [PEL_SHADE_COLOR] = "#define PEL_COLOR\n",
    [PEL_SHADE_BOTH] = "#define PEL_COLOR\n#define PEL_RADIANCE\n",
    [PEL_SHADE_LIGHT] = "#define PEL_RADIANCE\n",
    [PEL_SHADE_LAYERS] = "#define PEL_RADIANCE\n#define PEL_LAYERS\n",
    [PEL_SHADE_PARTS] =
        "#define PEL_RADIANCE\n#define PEL_LAYERS\n#define PEL_WATER_PARTS\n",
};

const char *pel_shading_defines(enum pel_shading kind)
{
    return kind_defines[kind];
}

const char *pel_cameras_define(enum pel_programs_light light)
{
    return light >= PEL_LIGHT_CAMERAS ? "#define PEL_CAMERAS\n" : "";
}

const char *pel_light_defines(enum pel_programs_light light)
{
    static const char *const lit[PEL_LIGHT_NIGHT] = {
        [PEL_LIGHT_ONE] = "",
        [PEL_LIGHT_ONE_AND_DISC] = "#define PEL_DISCS 2\n",
        [PEL_LIGHT_TWO] = "#define PEL_LIT 2\n",
    };
    static const char *const looks[] = { "", "#define PEL_NIGHT\n",
                                         "#define PEL_PANORAMA\n" };
    static char texts[PEL_LIGHT_KINDS][PEL_LIGHT_TEXT];
    static bool made[PEL_LIGHT_KINDS]; /* others read them from then on */
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    const int fog = light / PEL_LIGHT_FOGGED % PEL_FOG_KINDS;
    char *text = texts[light];
    pthread_mutex_lock(&lock); /* of several renderers */
    if (!made[light]) {
        made[light] = true;
        int n = snprintf(
            text, PEL_LIGHT_TEXT, "%s%s%s%s", pel_cameras_define(light),
            lit[light % PEL_LIGHT_NIGHT],
            looks[light % PEL_LIGHT_CLOUDED / PEL_LIGHT_NIGHT],
            light / PEL_LIGHT_CLOUDED % 2 ? "#define PEL_CLOUDS\n" : "");
        if (fog) {
            snprintf(
                text + n, (size_t)(PEL_LIGHT_TEXT - n),
                "#define PEL_FOG\n#define PEL_FOG_LAYERS %d\n"
                "#define PEL_FOG_BANKS %d\n#define PEL_FOG_LIFTED %s\n",
                fog % (PEL_FOGS + 1), fog / (PEL_FOGS + 1) % (PEL_FOGS + 1),
                fog / ((PEL_FOGS + 1) * (PEL_FOGS + 1)) ? "true" : "false");
        }
    }
    pthread_mutex_unlock(&lock);
    return text;
}

const char *pel_sky_look_defines(enum pel_sky_look look)
{
    static const char *const defines[PEL_SKY_LOOKS] = {
        [PEL_SKY_DAY] = "",
        [PEL_SKY_NIGHT] = "#define PEL_NIGHT\n",
        [PEL_SKY_PANORAMA] = "#define PEL_PANORAMA\n",
    };
    return defines[look];
}

/* By the number of layers, of banks, and whether any layer is above the sea. */
static int fog_kind(const struct pel_environment *env)
{
    int layers = 0, banks = 0, lifted = 0;
    for (int i = 0; i < env->fog_count; i++) {
        bool bank = env->fog[i].radius_m > 0;
        banks += bank;
        layers += !bank;
        lifted |= !bank && env->fog[i].base_m > 0;
    }
    return layers + (PEL_FOGS + 1) * (banks + (PEL_FOGS + 1) * lifted);
}

int pel_light_program(const struct pel_environment *env)
{
    return env->lit - 1 + (env->clouds.cover > 0 ? PEL_LIGHTS : 0) +
           2 * PEL_LIGHTS * fog_kind(env);
}

bool pel_light_veiled(const struct pel_environment *env)
{
    return env->clouds.cover > 0 || env->fog_count > 0;
}

enum pel_programs_light pel_light_veils(const struct pel_environment *env)
{
    return (env->clouds.cover > 0 ? PEL_LIGHT_CLOUDED : 0) +
           PEL_LIGHT_FOGGED * fog_kind(env);
}

const char *pel_light_program_defines(const struct pel_environment *env)
{
    enum pel_programs_light light =
        env->lit > 1 ? PEL_LIGHT_TWO : PEL_LIGHT_ONE;
    return pel_light_defines(light + pel_light_veils(env));
}

static const char *const tile_defines[PEL_COAST_TILES] = {
    [PEL_COAST_NONE] = "",
    [PEL_COAST_BOTTOM] = "#define PEL_SEABED\n",
    [PEL_COAST_LAND] = "#define PEL_SEABED\n#define PEL_LAND\n",
};

static void delete_objects(struct pel_sea_programs *p)
{
    for (int i = 0; i < PEL_OBJECTS_KNOWN_COUNT * PEL_SHADE_COUNT; i++) {
        GLuint *program = &p->near[i / PEL_SHADE_COUNT][i % PEL_SHADE_COUNT];
        pel_program_delete(*program);
        *program = 0;
    }
    for (int i = 0; i < PEL_COAST_TILES * PEL_SHADE_COUNT; i++) {
        GLuint *program = &p->objects[i / PEL_SHADE_COUNT][i % PEL_SHADE_COUNT];
        pel_program_delete(*program);
        *program = 0;
    }
}

void pel_programs_texture(struct pel_programs *p, bool textured)
{
    p->textured = textured;
    for (int i = 0; i < PEL_SEA_PROGRAMS; i++) {
        delete_objects(&p->seas[i]);
    }
}

static bool has_streaks(const struct pel_sea *sea)
{
    return sea->foam && sea->foam->spread > 0;
}

const char *pel_programs_foam(const struct pel_sea *sea)
{
    return has_streaks(sea) ? "#define PEL_FOAM\n#define PEL_STREAKS\n"
           : sea->foam      ? "#define PEL_FOAM\n"
                            : "";
}

void pel_programs_surface(const struct pel_programs *all,
                          const struct pel_sea *sea, char out[PEL_SURFACE_TEXT])
{
    snprintf(out, PEL_SURFACE_TEXT, "%s%s%s%s%s%s",
             sea->cascades ? "#define PEL_FFT\n" : "",
             sea->desc.area_count || all->wash ? "#define PEL_AREAS\n" : "",
             all->wash ? "#define PEL_WASH\n" : "",
             all->wakes ? "#define PEL_WAKES\n" : "",
             sea->shore ? "#define PEL_SHORE\n" : "",
             pel_hardware_defines(all->software));
}

static struct pel_sea_programs *programs_with(struct pel_programs *p,
                                              const struct pel_sea *sea,
                                              bool wakes, bool wash)
{
    int foam = has_streaks(sea) ? 2 : sea->foam ? 1 : 0;
    int kind = 2 * (2 * p->lamps + p->above) + (sea->shore != NULL);
    kind = 2 * kind + wakes;
    kind = 3 * kind + (wash ? 2 : sea->desc.area_count > 0);
    kind = 3 * kind + foam;
    return &p->seas[2 * kind + (sea->cascades != NULL)];
}

static struct pel_sea_programs *programs_of(struct pel_programs *p,
                                            const struct pel_sea *sea)
{
    return programs_with(p, sea, p->wakes, p->wash);
}

const struct pel_sea_programs *pel_programs_still(struct pel_programs *p,
                                                  const struct pel_sea *sea)
{
    return programs_with(p, sea, false, false);
}

const struct pel_sea_programs *pel_programs_of(struct pel_programs *p,
                                               const struct pel_sea *sea)
{
    return programs_of(p, sea);
}

static void delete_all_seas(struct pel_programs *p)
{
    for (int i = 0; i < PEL_SEA_PROGRAMS; i++) {
        delete_sea_programs(&p->seas[i]);
    }
}

static const char *const objects_defines[PEL_OBJECTS_KNOWN_COUNT] = {
    [PEL_OBJECTS_UNKNOWN] = "",
    [PEL_OBJECTS_MIRRORED] = "#define PEL_OBJECTS\n",
    [PEL_OBJECTS_ALL] = "#define PEL_OBJECTS\n#define PEL_SHADED\n",
    [PEL_OBJECTS_ONE_MIRRORED] =
        "#define PEL_OBJECTS\n#define PEL_ONE_OBJECT\n",
    [PEL_OBJECTS_ONE] =
        "#define PEL_OBJECTS\n#define PEL_SHADED\n#define PEL_ONE_OBJECT\n",
};

static enum pel_err make_sea_program(struct pel_programs *all,
                                     const struct pel_sea *sea,
                                     enum pel_shading kind,
                                     enum pel_coast_tile tile,
                                     enum pel_objects_known objects,
                                     GLuint *out, struct pel_fault *fault)
{
    if (*out) {
        return PEL_OK;
    }
    char defines[640], surface[PEL_SURFACE_TEXT];
    pel_programs_surface(all, sea, surface);
    snprintf(defines, sizeof defines, "%s%s%s%s%s%s%s%s%s%s", surface,
             pel_light_defines(all->light),
             all->lamps ? "#define PEL_LAMPS\n" : "",
             all->above ? "#define PEL_CLOUDS_BELOW\n" : "",
             pel_programs_foam(sea), kind_defines[kind], tile_defines[tile],
             all->filtering->paper ? "#define PEL_PAPER\n" : "",
             objects_defines[objects],
             objects && all->compute && all->textured ? "#define PEL_TEXTURED\n"
                                                      : "");
    if (all->compute) {
        return pel_program_create(all->shader_dir, "shade.comp", NULL, defines,
                                  out, fault);
    }
    return pel_program_create(all->shader_dir, "shade.vert",
                              tile == PEL_COAST_LAND ? "coast.frag"
                                                     : "sea.frag",
                              defines, out, fault);
}

GLuint *pel_programs_cloudscape(struct pel_programs *p)
{
    return &p->cloudscape[p->storm][p->look];
}

static enum pel_err need_cloudscape(struct pel_programs *p,
                                    struct pel_fault *fault)
{
    GLuint *program = pel_programs_cloudscape(p);
    if (p->light < PEL_LIGHT_CLOUDED || *program) {
        return PEL_OK;
    }
    char defines[128];
    snprintf(defines, sizeof defines, "#define PEL_CLOUDS\n%s%s%s",
             p->storm ? "#define PEL_STORM\n" : "",
             pel_sky_look_defines(p->look),
             p->light % PEL_LIGHT_NIGHT == PEL_LIGHT_TWO ? "#define PEL_LIT 2\n"
                                                         : "");
    return pel_program_create(p->shader_dir, "shade.vert", "cloudscape.frag",
                              defines, program, fault);
}

int pel_programs_backdrop(const struct pel_programs *p, enum pel_shading kind)
{
    bool toned = kind < PEL_SHADE_LIGHT;
    return (int)kind + (toned && p->lamps ? PEL_SHADE_COUNT : 0);
}

/* Makes the programs that this kind of sea and picture wants; those with
 * layers most never are. */
static enum pel_err need_sea_programs(struct pel_programs *all,
                                      const struct pel_sea *sea,
                                      enum pel_shading kind, bool coast,
                                      bool objects, struct pel_fault *fault)
{
    struct pel_sea_programs *p = programs_of(all, sea);
    enum pel_err err = PEL_OK;
    if (!p->mesh) {
        char defines[PEL_SURFACE_TEXT];
        pel_programs_surface(all, sea, defines);
        err = pel_program_create(all->shader_dir, "mesh.comp", NULL, defines,
                                 &p->mesh, fault);
    }
    if (err == PEL_OK) {
        err = need_cloudscape(all, fault);
    }
    if (err == PEL_OK && all->compute && !all->search) {
        err = pel_program_create(all->shader_dir, "search.comp", NULL, NULL,
                                 &all->search, fault);
    }
    if (err == PEL_OK && coast) {
        err = make_sea_program(all, sea, kind, PEL_COAST_LAND,
                               PEL_OBJECTS_UNKNOWN, &p->coast[kind], fault);
    }
    if (err == PEL_OK && coast) {
        err = make_sea_program(all, sea, kind, PEL_COAST_BOTTOM,
                               PEL_OBJECTS_UNKNOWN, &p->shallow[kind], fault);
    }
    for (int tile = 0; tile < PEL_COAST_TILES && objects; tile++) {
        if (err == PEL_OK && (coast || !tile)) {
            err = make_sea_program(all, sea, kind, tile, PEL_OBJECTS_ALL,
                                   &p->objects[tile][kind], fault);
        }
    }
    for (int k = PEL_OBJECTS_MIRRORED; k < PEL_OBJECTS_KNOWN_COUNT; k++) {
        if (err == PEL_OK && objects && !all->compute && k != PEL_OBJECTS_ALL) {
            err = make_sea_program(all, sea, kind, PEL_COAST_NONE, k,
                                   &p->near[k][kind], fault);
        }
    }
    if (err == PEL_OK && all->compute) {
        return make_sea_program(all, sea, kind, PEL_COAST_NONE,
                                PEL_OBJECTS_UNKNOWN, &p->compute_program[kind],
                                fault);
    }
    if (err == PEL_OK) {
        err = make_sea_program(all, sea, kind, PEL_COAST_NONE,
                               PEL_OBJECTS_UNKNOWN, &p->fragments[kind], fault);
    }
    for (int disc = 0; disc < 2; disc++) {
        const int place = pel_programs_backdrop(all, kind);
        GLuint *program = disc ? &all->disc[all->look][place]
                               : &all->backdrop[all->look][place];
        char defines[340];
        /* Another's disc may be in its box. */
        snprintf(defines, sizeof defines, "%s%s%s%s%s%s", kind_defines[kind],
                 place != (int)kind ? "#define PEL_LAMPS\n" : "",
                 pel_light_defines(all->light - all->light % PEL_LIGHT_CLOUDED),
                 pel_sky_look_defines(all->look),
                 all->light % PEL_LIGHT_NIGHT == PEL_LIGHT_TWO
                     ? "#define PEL_LIT 2\n"
                     : "",
                 disc ? "#define PEL_DISCS 2\n" : "#define PEL_NO_DISC\n");
        if (err == PEL_OK && !*program) {
            err = pel_program_create(all->shader_dir, "shade.vert",
                                     "backdrop.frag", defines, program, fault);
        }
    }
    return err;
}

enum pel_err pel_programs_need(struct pel_programs *all,
                               const struct pel_sea *sea, enum pel_shading kind,
                               bool coast, bool objects,
                               struct pel_fault *fault)
{
    enum pel_err err = need_sea_programs(all, sea, kind, coast, objects, fault);
    if (err != PEL_OK && all->compute && all->automatic) {
        pel_warn("RND-042", "%s; pixels are shaded as fragments",
                 fault->message);
        all->compute = false;
        /* Coasts were made for the other wrapper. */
        delete_all_seas(all);
        err = need_sea_programs(all, sea, kind, coast, objects, fault);
    }
    return err;
}

enum pel_err pel_programs_need_still(struct pel_programs *p,
                                     const struct pel_sea *sea,
                                     enum pel_shading kind, bool coast,
                                     bool objects, struct pel_fault *fault)
{
    bool wakes = p->wakes, wash = p->wash;
    p->wakes = p->wash = false;
    enum pel_err err = pel_programs_need(p, sea, kind, coast, objects, fault);
    p->wakes = wakes;
    p->wash = wash;
    return err;
}

bool pel_programs_have_edges(const struct pel_programs *p)
{
    return p->compute || p->software || !p->automatic;
}

enum pel_err pel_programs_need_edges(struct pel_programs *all,
                                     struct pel_fault *fault)
{
    char put[64 + PEL_LIGHT_TEXT];
    snprintf(put, sizeof put, "#define PEL_PUT\n%s%s",
             all->lamps ? "#define PEL_LAMPS\n" : "",
             pel_light_defines(all->light));
    const char *keys = all->compute ? "#define PEL_KEYS\n" : NULL;
    const struct {
        GLuint *program;
        const char *file, *defines;
        bool wanted;
    } needed[] = {
        { &all->outline_find, "outline_find.comp", keys, true },
        { &all->outline, "outline.comp", keys, true },
        { &all->outline_mix, "outline_mix.comp", pel_light_defines(all->light),
          true },
        { &all->outline_put[all->lamps], "outline_mix.comp", put, true },
        { &all->clear_keys, "clear.comp", NULL, all->compute },
    };
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        if (err == PEL_OK && needed[i].wanted && !*needed[i].program) {
            err =
                pel_program_create(all->shader_dir, needed[i].file, NULL,
                                   needed[i].defines, needed[i].program, fault);
        }
    }
    return err;
}

enum pel_err pel_programs_need_together(struct pel_programs *all,
                                        const struct pel_sea *sea,
                                        bool outlines, struct pel_fault *fault)
{
    struct pel_sea_programs *p = programs_of(all, sea);
    char surface[PEL_SURFACE_TEXT], defines[640];
    pel_programs_surface(all, sea, surface);
    enum pel_err err = PEL_OK;
    if (!p->together_mesh) {
        snprintf(defines, sizeof defines, "#define PEL_TOGETHER\n%s", surface);
        err = pel_program_create(all->shader_dir, "mesh.comp", NULL, defines,
                                 &p->together_mesh, fault);
    }
    if (err == PEL_OK && !p->together) {
        snprintf(defines, sizeof defines, "#define PEL_TOGETHER\n%s%s%s%s%s",
                 surface, pel_light_defines(all->light), pel_programs_foam(sea),
                 kind_defines[PEL_SHADE_LIGHT],
                 all->filtering->paper ? "#define PEL_PAPER\n" : "");
        err = pel_program_create(all->shader_dir, "shade.comp", NULL, defines,
                                 &p->together, fault);
    }
    if (err == PEL_OK && outlines && !all->together_mix) {
        err = pel_program_create(all->shader_dir, "outline_together.comp", NULL,
                                 pel_light_defines(all->light),
                                 &all->together_mix, fault);
    }
    return err;
}

enum pel_err pel_programs_need_alone(struct pel_programs *p,
                                     struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    if (!p->surface) {
        err = pel_program_create(p->shader_dir, "surface.vert", "surface.frag",
                                 NULL, &p->surface, fault);
    }
    if (err == PEL_OK && !p->tone) {
        err = pel_program_create(p->shader_dir, "screen.vert", "tone.frag",
                                 pel_light_defines(p->light), &p->tone, fault);
    }
    return err;
}

void pel_programs_init(struct pel_programs *p, const char *shader_dir,
                       bool software, const char *shading,
                       const struct pel_filtering *filtering)
{
    bool automatic = !shading || strcmp(shading, "auto") == 0;
    *p = (struct pel_programs){
        .shader_dir = shader_dir,
        .filtering = filtering,
        .software = software,
        .compute = automatic ? !software : strcmp(shading, "compute") == 0,
        .automatic = automatic,
    };
}

enum pel_err pel_programs_take_light(struct pel_programs *p,
                                     enum pel_programs_light light,
                                     struct pel_fault *fault)
{
    if (p->light == light) {
        return PEL_OK;
    }
    struct pel_programs **kept = &p->others[p->light];
    struct pel_programs *next = p->others[light];
    if (!*kept && !(*kept = malloc(sizeof **kept))) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    **kept = *p;
    struct pel_programs now = next ? *next : (struct pel_programs){ 0 };
    if (now.compute != p->compute) {
        delete_all_seas(&now);
    }
    now.shader_dir = p->shader_dir;
    now.filtering = p->filtering;
    now.software = p->software;
    now.compute = p->compute;
    now.automatic = p->automatic;
    now.wakes = p->wakes;
    now.wash = p->wash;
    now.above = p->above;
    now.lamps = p->lamps;
    now.look = p->look;
    now.light = light;
    memcpy(now.others, p->others, sizeof now.others);
    bool textured = p->textured;
    *p = now;
    if (p->textured != textured) {
        pel_programs_texture(p, textured);
    }
    return PEL_OK;
}

static void finish_light(struct pel_programs *p)
{
    delete_all_seas(p);
    pel_program_delete(p->surface);
    pel_program_delete(p->search);
    pel_program_delete(p->tone);
    pel_program_delete(p->outline_find);
    pel_program_delete(p->outline);
    pel_program_delete(p->outline_mix);
    pel_program_delete(p->outline_put[0]);
    pel_program_delete(p->outline_put[1]);
    pel_program_delete(p->clear_keys);
    pel_program_delete(p->together_mix);
    for (int i = 0; i < PEL_SKY_LOOKS; i++) {
        for (int k = 0; k < PEL_BACKDROPS; k++) {
            pel_program_delete(p->backdrop[i][k]);
            pel_program_delete(p->disc[i][k]);
        }
        pel_program_delete(p->cloudscape[0][i]);
        pel_program_delete(p->cloudscape[1][i]);
    }
}

void pel_programs_finish(struct pel_programs *p)
{
    for (int i = 0; i < PEL_LIGHT_KINDS; i++) {
        struct pel_programs *other = p->others[i];
        if (other && i != (int)p->light) {
            finish_light(other);
        }
        free(other);
    }
    finish_light(p);
    *p = (struct pel_programs){ 0 };
}
