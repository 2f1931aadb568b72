#include "render/waterprobe.h"

#include <math.h>
#include <stdlib.h>

#include "base/reserve.h"
#include "base/vec.h"
#include "optics/brdf.h"
#include "render/shader.h"
#include "render/uniforms.h"

static enum pel_err make(struct pel_water_prober *p, const char *shader_dir,
                         struct pel_fault *fault)
{
    if (p->program) {
        return PEL_OK;
    }
    enum pel_err err = pel_water_light_init(&p->light, shader_dir, fault);
    if (err == PEL_OK) {
        err = pel_program_create(shader_dir, "water_probe.comp", NULL, NULL,
                                 &p->program, fault);
    }
    if (err != PEL_OK) {
        return err;
    }
    const struct pel_block_light unit = { .beams = { { 1, 1, 1, 0 } } };
    glCreateBuffers(1, &p->unit);
    glNamedBufferStorage(p->unit, sizeof unit, &unit, 0);
    glObjectLabel(GL_BUFFER, p->unit, -1, "unit of light");
    const GLfloat none[4] = { 0 };
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &p->black);
    glTextureStorage3D(p->black, 1, GL_RGBA32F, 1, 1, PEL_LIGHTS);
    glClearTexImage(p->black, 0, GL_RGBA, GL_FLOAT, none);
    glObjectLabel(GL_TEXTURE, p->black, -1, "no sky");
    return PEL_OK;
}

void pel_water_prober_finish(struct pel_water_prober *p)
{
    if (p->program) {
        pel_water_light_finish(&p->light);
        pel_program_delete(p->program);
        glDeleteBuffers(1, &p->unit);
        glDeleteTextures(1, &p->black);
    }
    *p = (struct pel_water_prober){ 0 };
}

/* The Sun stands where azimuth 0 looks: the line of sight goes to +x. */
static void look(struct pel_water_prober *p, const double (*views)[2],
                 double depth_m, int count, struct pel_water_parts *out)
{
    GLfloat(*to)[4] = pel_sure_malloc(sizeof *to * (size_t)count);
    GLfloat(*found)[PEL_WATER_PARTS][4] =
        pel_sure_malloc(sizeof *found * (size_t)count);
    for (int i = 0; i < count; i++) {
        double sine = sin(views[i][0]);
        to[i][0] = (GLfloat)(-sine * cos(views[i][1]));
        to[i][1] = (GLfloat)(-sine * sin(views[i][1]));
        to[i][2] = (GLfloat)cos(views[i][0]);
        to[i][3] = (GLfloat)depth_m;
    }
    GLuint buffers[2];
    glCreateBuffers(2, buffers);
    glNamedBufferStorage(buffers[0], (GLsizeiptr)sizeof *to * count, to, 0);
    glNamedBufferStorage(buffers[1], (GLsizeiptr)sizeof *found * count, NULL,
                         0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PROBE, buffers[0]);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PROBE_ANSWERS,
                     buffers[1]);
    glBindTextureUnit(PEL_UNIT_WATER, p->light.map);
    pel_program_use(p->program);
    glDispatchCompute((GLuint)(count + PEL_GROUP_WATER - 1) / PEL_GROUP_WATER,
                      1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[1], 0, (GLsizeiptr)sizeof *found * count,
                            found);
    for (int i = 0; i < count; i++) {
        double through =
            1.0 - pel_fresnel_exact(cos(views[i][0]), PEL_WATER_INDEX);
        for (int k = 0; k < PEL_WATER_PARTS * PEL_WATER_WAVELENGTHS; k++) {
            int part = k / PEL_WATER_WAVELENGTHS, c = k % PEL_WATER_WAVELENGTHS;
            out[i].part[part][c] = through * (double)found[i][part][c];
        }
    }
    glDeleteBuffers(2, buffers);
    free(to);
    free(found);
}

enum pel_err
pel_water_prober_run(struct pel_water_prober *p, const char *shader_dir,
                     const struct pel_water_body *body,
                     const struct pel_water_depths *depths, double depth_m,
                     enum pel_water_orders orders, double sun_zenith_rad,
                     const double (*views)[2], int count,
                     struct pel_water_parts *out, struct pel_fault *fault)
{
    enum pel_err err = make(p, shader_dir, fault);
    if (err != PEL_OK) {
        return err;
    }
    struct pel_environment env = { .water = *body,
                                   .depths = *depths,
                                   .orders = orders };
    double sine = sin(sun_zenith_rad), cosine = cos(sun_zenith_rad);
    err = pel_water_light_update(&p->light, &env);
    if (err != PEL_OK) {
        return pel_fault_set(fault, err,
                             "no memory for the light in the water");
    }
    struct pel_block_frame frame = {
        .lights = { { .direction = { (float)sine, 0, (float)cosine, 0 } } },
        .water = pel_water_levels(&env, 0.0),
    };
    GLuint block = 0;
    glCreateBuffers(1, &block);
    glNamedBufferStorage(block, sizeof frame, &frame, 0);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, block);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_LIGHT, p->unit);
    struct pel_light lights[PEL_LIGHTS];
    pel_lights_of_sun((struct pel_vec3){ sine, 0, cosine }, lights);
    pel_water_light_map(&p->light, lights, 1, NULL, p->black, p->unit);
    look(p, views, depth_m, count, out);
    glDeleteBuffers(1, &block);
    return PEL_OK;
}
