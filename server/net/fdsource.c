#include "net/fdsource.h"
#include "base/watch.h"

#include <stdbool.h>

struct pel_fdsource {
    GSource source;
    void *tag;
    GIOCondition wanted;
    pel_fdsource_ready ready;
    void *user;
};

static gboolean dispatch(GSource *source, GSourceFunc callback, gpointer user)
{
    (void)callback;
    (void)user;
    struct pel_fdsource *self = (struct pel_fdsource *)source;
    PEL_WATCH("sockets");
    GIOCondition ready = g_source_query_unix_fd(source, self->tag);
    g_source_set_ready_time(source, -1);
    self->ready(self->user, ready);
    return G_SOURCE_CONTINUE;
}

static GSourceFuncs functions = { .dispatch = dispatch };

struct pel_fdsource *pel_fdsource_create(int fd, GIOCondition wanted,
                                         pel_fdsource_ready ready, void *user)
{
    struct pel_fdsource *self =
        (struct pel_fdsource *)g_source_new(&functions, sizeof *self);
    self->wanted = wanted;
    self->ready = ready;
    self->user = user;
    self->tag = g_source_add_unix_fd(&self->source, fd, wanted);
    g_source_attach(&self->source, NULL);
    return self;
}

void pel_fdsource_destroy(struct pel_fdsource *self)
{
    if (self) {
        g_source_destroy(&self->source);
        g_source_unref(&self->source);
    }
}

void pel_fdsource_want(struct pel_fdsource *self, GIOCondition wanted)
{
    if (wanted != self->wanted) {
        self->wanted = wanted;
        g_source_modify_unix_fd(&self->source, self->tag, wanted);
    }
}

void pel_fdsource_wake_at(struct pel_fdsource *self, int64_t when_ns)
{
    /* GLib's monotonic time is CLOCK_MONOTONIC in microseconds. */
    int64_t when_us = when_ns > 0 ? when_ns / 1000 + 1 : when_ns;
    g_source_set_ready_time(&self->source, when_us);
}
