#include "render/programs.h"

#include <stdio.h>
#include <string.h>

#define MAX_UNROLLED_WAVES 128

static void delete_sea_programs(struct pel_sea_programs *p)
{
    for (int i = 0; i < PEL_SHADE_COUNT; i++) {
        glDeleteProgram(p->near[i]);
        glDeleteProgram(p->far[i]);
        glDeleteProgram(p->compute[i]);
        glDeleteProgram(p->coast[i]);
    }
    glDeleteProgram(p->mesh);
    *p = (struct pel_sea_programs){ 0 };
}

/* Software rasterisers are faster with fragments, hardware with compute by up
 * to thirty times (docs/benchmarks.md). */
static bool choose_compute(bool software, const char *shading)
{
    if (!shading || strcmp(shading, "auto") == 0) {
        return !software;
    }
    return strcmp(shading, "compute") == 0;
}

static const char *const kind_defines[PEL_SHADE_COUNT] = {
    [PEL_SHADE_COLOR] = "#define PEL_COLOR\n",
    [PEL_SHADE_LIGHT] = "",
    [PEL_SHADE_LAYERS] = "#define PEL_LAYERS\n",
    [PEL_SHADE_PARTS] = "#define PEL_WATER_PARTS\n",
};

static enum pel_err make_sea_program(struct pel_programs *all, bool cascades,
                                     int waves, enum pel_shading kind,
                                     bool coast, GLuint *out,
                                     struct pel_fault *fault)
{
    if (*out) {
        return PEL_OK;
    }
    char defines[224];
    bool unroll = all->software && waves <= MAX_UNROLLED_WAVES;
    snprintf(defines, sizeof defines,
             "#define PEL_WAVES %d\n%s%s%s%s"
             "#define PEL_ANISOTROPY %d\n#define PEL_SKY_FILTER %d\n",
             waves, cascades ? "#define PEL_FFT\n" : "",
             unroll ? "#define PEL_UNROLL\n" : "", kind_defines[kind],
             coast ? "#define PEL_SEABED\n" : "", all->filtering->anisotropy,
             (int)all->filtering->sky);
    if (all->compute) {
        return pel_program_create(all->shader_dir, "shade.comp", NULL, defines,
                                  out, fault);
    }
    return pel_program_create(all->shader_dir, "screen.vert",
                              coast ? "coast.frag" : "sea.frag", defines, out,
                              fault);
}

/* Makes the programs that this kind of sea and picture wants; those with
 * layers most never are. */
static enum pel_err need_sea_programs(struct pel_programs *all, bool cascades,
                                      enum pel_shading kind, bool coast,
                                      struct pel_fault *fault)
{
    struct pel_sea_programs *p = cascades ? &all->cascades : &all->trochoids;
    enum pel_err err = PEL_OK;
    if (!p->mesh) {
        const char *defines = cascades ? "#define PEL_FFT\n"
                              : all->software
                                  ? "#define PEL_CHUNKS\n#define PEL_UNROLL\n"
                                  : NULL;
        err = pel_program_create(all->shader_dir, "mesh.comp", NULL, defines,
                                 &p->mesh, fault);
    }
    if (err == PEL_OK && all->compute && !all->search) {
        err = pel_program_create(all->shader_dir, "search.comp", NULL, NULL,
                                 &all->search, fault);
    }
    if (err == PEL_OK && coast) {
        err = make_sea_program(all, cascades, all->waves, kind, true,
                               &p->coast[kind], fault);
    }
    if (err == PEL_OK && all->compute) {
        return make_sea_program(all, cascades, all->waves, kind, false,
                                &p->compute[kind], fault);
    }
    if (err == PEL_OK) {
        err = make_sea_program(all, cascades, all->waves, kind, false,
                               &p->near[kind], fault);
    }
    /* The first picture does without it, a quarter of a second sooner: zero
     * weights add nothing, so the bits are the same. */
    if (err == PEL_OK && !cascades && all->settled) {
        err = make_sea_program(all, cascades, PEL_FAR_WAVES, kind, false,
                               &p->far[kind], fault);
    }
    if (err == PEL_OK && !all->backdrop[kind]) {
        err =
            pel_program_create(all->shader_dir, "screen.vert", "backdrop.frag",
                               kind_defines[kind], &all->backdrop[kind], fault);
    }
    return err;
}

enum pel_err pel_programs_need(struct pel_programs *all,
                               const struct pel_sea *sea, enum pel_shading kind,
                               bool coast, struct pel_fault *fault)
{
    if (sea->cascades) {
        return need_sea_programs(all, true, kind, coast, fault);
    }
    /* Steps of the written-out sums, so that few programs are ever made. */
    static const int steps[] = { 24, 40, 48, 60, 64, 80, 96, 112, 128, 256 };
    int waves = 256;
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        if (sea->count <= steps[i]) {
            waves = steps[i];
            break;
        }
    }
    if (waves > all->waves) {
        delete_sea_programs(&all->trochoids);
        all->waves = waves;
    }
    return need_sea_programs(all, false, kind, coast, fault);
}

enum pel_err pel_programs_init(struct pel_programs *p, const char *shader_dir,
                               bool software, const char *shading,
                               const struct pel_filtering *filtering,
                               struct pel_fault *fault)
{
    *p = (struct pel_programs){
        .shader_dir = shader_dir,
        .filtering = filtering,
        .software = software,
        .compute = choose_compute(software, shading),
    };
    enum pel_err err = pel_program_create(
        shader_dir, "surface.vert", "surface.frag", NULL, &p->surface, fault);
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "screen.vert", "tone.frag", NULL,
                                 &p->tone, fault);
    }
    return err;
}

void pel_programs_finish(struct pel_programs *p)
{
    delete_sea_programs(&p->trochoids);
    delete_sea_programs(&p->cascades);
    glDeleteProgram(p->surface);
    glDeleteProgram(p->search);
    glDeleteProgram(p->tone);
    for (int i = 0; i < PEL_SHADE_COUNT; i++) {
        glDeleteProgram(p->backdrop[i]);
    }
    *p = (struct pel_programs){ 0 };
}
