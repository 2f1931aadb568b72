#include "render/probe.h"

#include "render/shader.h"
#include "shaders/lib/blocks.h"

enum pel_err pel_prober_init(struct pel_prober *p, int lit,
                             const char *shader_dir, struct pel_fault *fault)
{
    if (p->program[lit - 1]) {
        return PEL_OK;
    }
    enum pel_err err = pel_program_create(
        shader_dir, "probe.comp", NULL, lit > 1 ? "#define PEL_LIT 2\n" : NULL,
        &p->program[lit - 1], fault);
    if (err == PEL_OK && !p->buffer) {
        glCreateBuffers(1, &p->buffer);
        glNamedBufferStorage(p->buffer, sizeof(GLfloat) * 4 * PEL_PROBE_ANSWERS,
                             NULL, 0);
        glObjectLabel(GL_BUFFER, p->buffer, -1, "probe");
    }
    return err;
}

void pel_prober_finish(struct pel_prober *p)
{
    for (int i = 0; i < PEL_LIGHTS; i++) {
        pel_program_delete(p->program[i]);
    }
    glDeleteBuffers(1, &p->buffer);
    *p = (struct pel_prober){ 0 };
}

static struct pel_rgb rgb(const GLfloat v[4])
{
    return (struct pel_rgb){ (double)v[0], (double)v[1], (double)v[2] };
}

void pel_prober_run(struct pel_prober *p, int lit, int sun,
                    const struct pel_probe *probe, struct pel_probe_answer *out)
{
    GLfloat v[PEL_PROBE_ANSWERS][4];
    GLuint program = p->program[lit - 1];
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PROBE, p->buffer);
    pel_program_use(program);
    glUniform3f(0, (GLfloat)probe->dir.x, (GLfloat)probe->dir.y,
                (GLfloat)probe->dir.z);
    glUniform2f(1, (GLfloat)probe->slope_along, (GLfloat)probe->slope_cross);
    glUniform1i(2, sun);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(p->buffer, 0, sizeof v, v);
    *out = (struct pel_probe_answer){
        .sea = { .lambda_view = (double)v[0][0],
                 .lambda_light = (double)v[0][1],
                 .mean_fresnel = (double)v[0][2],
                 .seen_fresnel = (double)v[0][3],
                 .half_cosine = (double)v[1][0],
                 .brdf = (double)v[1][1],
                 .reflected_sun = (double)v[1][2],
                 .fresnel = (double)v[1][3],
                 .slope_density = (double)v[2][0] },
        .sky = { rgb(v[3]), rgb(v[4]), rgb(v[5]) },
    };
}
