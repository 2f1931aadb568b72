#include "render/stages.h"

#include "base/clock.h"

const char *pel_stage_name(enum pel_stage stage)
{
    static const char *const names[] = { "waves", "sky",  "mesh",    "raster",
                                         "shade", "tone", "readback" };
    return (unsigned)stage < PEL_STAGE_COUNT ? names[stage] : "";
}

void pel_stage_timer_init(struct pel_stage_timer *t, bool software)
{
    *t = (struct pel_stage_timer){ .software = software };
    glCreateQueries(GL_TIMESTAMP, 2, t->queries);
}

void pel_stage_timer_finish(struct pel_stage_timer *t)
{
    glDeleteQueries(2, t->queries);
}

void pel_timer_begin(struct pel_stage_timer *t)
{
    glFinish();
    t->last_ns = pel_now_ns();
    glQueryCounter(t->queries[0], GL_TIMESTAMP);
}

double pel_timer_end(struct pel_stage_timer *t)
{
    glQueryCounter(t->queries[1], GL_TIMESTAMP);
    glFinish();
    if (t->software) {
        return (double)(pel_now_ns() - t->last_ns) * 1e-6;
    }
    GLuint64 start = 0, end = 0;
    glGetQueryObjectui64v(t->queries[0], GL_QUERY_RESULT, &start);
    glGetQueryObjectui64v(t->queries[1], GL_QUERY_RESULT, &end);
    return (double)(end - start) * 1e-6;
}

void pel_stage_begin(struct pel_stage_timer *t)
{
    if (t->on) {
        pel_timer_begin(t);
    }
}

void pel_stage_end(struct pel_stage_timer *t, enum pel_stage stage)
{
    if (t->on) {
        t->ms[stage] += pel_timer_end(t);
        pel_timer_begin(t);
    }
}
