#include "render/meter.h"

#include <stdio.h>

#include "render/programs.h"
#include "render/shader.h"
#include "shaders/lib/blocks.h"

void pel_meter_init(struct pel_meter *m)
{
    glCreateBuffers(1, &m->exposure);
    glNamedBufferStorage(m->exposure,
                         PEL_TOGETHER_MOST * sizeof(struct pel_block_exposure),
                         NULL, 0);
    glObjectLabel(GL_BUFFER, m->exposure, -1, "exposure");
}

enum pel_err pel_meter_need(struct pel_meter *m,
                            const struct pel_environment *env, bool under,
                            const char *shader_dir, struct pel_fault *fault)
{
    GLuint *program = &m->program[under][pel_light_program(env)];
    char defines[32 + PEL_LIGHT_TEXT];
    snprintf(defines, sizeof defines, "%s%s", pel_light_program_defines(env),
             under ? "#define PEL_UNDER\n" : "");
    return *program ? PEL_OK
                    : pel_program_create(shader_dir, "meter.comp", NULL,
                                         defines, program, fault);
}

void pel_meter_finish(struct pel_meter *m)
{
    for (int i = 0; i < PEL_LIGHT_PROGRAMS; i++) {
        pel_program_delete(m->together[i]);
        pel_program_delete(m->program[0][i]);
        pel_program_delete(m->program[1][i]);
    }
    glDeleteBuffers(1, &m->exposure);
    *m = (struct pel_meter){ 0 };
}

void pel_meter_use(struct pel_meter *m, GLuint program)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_EXPOSURE, m->exposure);
    pel_program_use(program);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_EXPOSURE, m->exposure);
}

void pel_meter_run(struct pel_meter *m, const struct pel_environment *env,
                   bool under)
{
    pel_meter_use(m, m->program[under][pel_light_program(env)]);
}

enum pel_err pel_meter_need_together(struct pel_meter *m,
                                     const struct pel_environment *env,
                                     const char *shader_dir,
                                     struct pel_fault *fault)
{
    GLuint *program = &m->together[pel_light_program(env)];
    char defines[32 + PEL_LIGHT_TEXT];
    snprintf(defines, sizeof defines, "#define PEL_TOGETHER\n%s",
             pel_light_program_defines(env));
    return *program ? PEL_OK
                    : pel_program_create(shader_dir, "meter.comp", NULL,
                                         defines, program, fault);
}

void pel_meter_run_together(struct pel_meter *m,
                            const struct pel_environment *env, GLuint views)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_EXPOSURE, m->exposure);
    pel_program_use(m->together[pel_light_program(env)]);
    glDispatchCompute(1, 1, views);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_EXPOSURE, m->exposure);
}
