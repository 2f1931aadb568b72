/* Consoles and the Modbus server, with a scene of its own: four connections,
 * whose bytes come as they are or as PDUs with a right header, in pieces; time,
 * in which heartbeats fail; connections that end in the middle. */
#include <string.h>

#include "bridges/modbus.h"
#include "fuzz_steps.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { FEED, PDU, HALF, WAIT, CLOSE, STEPS };
#define CONSOLES 4

struct consoles {
    struct pel_scene *scene;
    struct pel_modbus *modbus;
    struct pel_modbus_session *open[CONSOLES];
};

/* Every answer must be whole: a header and as many bytes as it says. */
static void check_answers(const uint8_t *answer, long size)
{
    while (size > 0) {
        long length = size >= 9 ? 6 + (answer[4] << 8 | answer[5]) : size + 1;
        if (length > size || answer[2] != 0 || answer[3] != 0) {
            abort();
        }
        answer += length;
        size -= length;
    }
}

static void feed(struct pel_modbus_session **open, const uint8_t *bytes,
                 size_t size)
{
    static uint8_t answer[1 << 16];
    /* Answers of 64 KiB at most: 8 bytes in can be 260 out. */
    long got = pel_modbus_session_feed(*open, bytes, size < 2000 ? size : 2000,
                                       answer, sizeof answer);
    check_answers(answer, got);
    if (got < 0) {
        pel_modbus_session_close(*open);
        *open = NULL;
    }
}

static void take(struct consoles *c, const struct fuzz_step *s)
{
    unsigned who = s->what / STEPS % CONSOLES, what = s->what % STEPS;
    size_t length = s->size < 253 ? s->size : 253;
    uint8_t adu[260] = {
        0, 1, 0, 0, 0, (uint8_t)(length + 1), (uint8_t)(1 + s->what / 128)
    };
    memcpy(adu + 7, s->data, length);
    if (what == WAIT) {
        fuzz_wait(s);
        fuzz_rest();
        return;
    }
    if (!c->open[who]) {
        c->open[who] = pel_modbus_session_open(c->modbus);
    }
    switch (what) {
    case FEED:
        feed(&c->open[who], s->data, s->size);
        break;
    case PDU:
        feed(&c->open[who], adu, length + 7);
        break;
    case HALF: /* and the rest, if the connection still stands */
        feed(&c->open[who], adu, (length + 7) / 2);
        if (c->open[who]) {
            feed(&c->open[who], adu + (length + 7) / 2,
                 length + 7 - (length + 7) / 2);
        }
        break;
    default:
        pel_modbus_session_close(c->open[who]);
        c->open[who] = NULL;
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    struct pel_modbus_options options = pel_modbus_default_options();
    struct consoles c = { .scene = fuzz_world() };
    double time_s = 0;
    options.listen = NULL;
    if (pel_modbus_create(&options, c.scene, &c.modbus, NULL) != PEL_OK) {
        abort();
    }
    for (int i = 0; i < 64 && fuzz_next(&steps, &step); i++) {
        take(&c, &step);
        pel_scene_settle(c.scene);
        fuzz_rest();
        if (step.what % STEPS == WAIT) {
            fuzz_look(c.scene, &time_s); /* a console may set the clock */
        }
        time_s = pel_scene_time(c.scene);
        const struct pel_modbus_counters *n = pel_modbus_counters(c.modbus);
        fuzz_demand(n->commits + n->refused_commits <= n->requests);
    }
    for (int i = 0; i < CONSOLES; i++) {
        if (c.open[i]) {
            pel_modbus_session_close(c.open[i]);
        }
    }
    pel_modbus_destroy(c.modbus);
    pel_scene_destroy(c.scene);
    return 0;
}
