/* A host's session with the CIGI bridge and a scene of its own: datagrams as
 * they are, or packets behind a sound IG Control of either byte order, alone or
 * several as one edit; frames that come back, silence, and an operator. */
#include <string.h>

#include "base/metrics.h"
#include "bridges/cigi.h"
#include "fuzz_steps.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum {
    FEED,    /* bytes */
    PACKETS, /* how, then kind and content by turns */
    ADD,     /* as PACKETS: together with the next */
    WAIT,
    FRAME,
    OPERATOR,
    JUMP, /* of the host's frame number */
    STEPS,
};

struct host {
    struct pel_scene *scene;
    struct pel_cigi *cigi;
    uint32_t frame, ig_frame;
    uint64_t datagrams;
};

/* What the data says about order and timestamps, with the next frame. */
static size_t put_control(struct host *h, uint8_t *out, size_t room,
                          uint8_t how)
{
    struct pel_cigi_packet p = pel_cigi_packet_of(PEL_CIGI_KIND_IG_CONTROL);
    h->frame += 1 + (how >> 6);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAJOR, 3);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MINOR, how & 2 ? 2 : 3);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAGIC, 0x8000);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MODE, how & 32 ? 0 : 1);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_FRAME, h->frame);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_STAMPED, (how & 8) != 0);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_TIMESTAMP, h->frame * 1667.0);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_DATABASE, how & 16 ? 5 : 0);
    return pel_cigi_put(&p, (how & 4) != 0, out, room);
}

/* Kind and content follow each other; sizes are right. */
static size_t put_packets(uint8_t *out, size_t room, const uint8_t *data,
                          size_t size)
{
    size_t used = 0;
    while (size > 0) {
        size_t kind = data[0] % PEL_CIGI_KIND_COUNT;
        const struct pel_cigi_info *info = &pel_cigi_packets[kind];
        size_t body = info->size - 2u < size - 1 ? info->size - 2u : size - 1;
        if (kind == PEL_CIGI_KIND_IG_CONTROL || used + info->size > room) {
            break;
        }
        memset(out + used, 0, info->size);
        out[used] = info->id;
        out[used + 1] = info->size;
        memcpy(out + used + 2, data + 1, body);
        used += info->size;
        data += 1 + body;
        size -= 1 + body;
    }
    return used;
}

/* What we send is sound, whatever we were sent. */
static void take_frame(struct host *h)
{
    const uint8_t *answer;
    struct pel_cigi_reader reader;
    struct pel_cigi_packet p;
    size_t got = pel_cigi_frame(h->cigi, &answer);
    fuzz_demand(pel_cigi_open(answer, got, PEL_CIGI_KIND_START_OF_FRAME,
                              &reader) == PEL_CIGI_GOOD);
    h->ig_frame++;
    while (pel_cigi_next(&reader, &p)) {
        fuzz_demand(p.kind != PEL_CIGI_KIND_COUNT &&
                    !pel_cigi_packets[p.kind].from_host);
        fuzz_demand(p.kind != PEL_CIGI_KIND_START_OF_FRAME ||
                    pel_cigi_get(&p, PEL_CIGI_START_OF_FRAME_FRAME) ==
                        h->ig_frame);
    }
}

static void operate(struct host *h, uint8_t mode)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    clock.has_mode = true;
    clock.mode = mode % 4;
    state.clock = &clock;
    patch.state = &state;
    (void)!pel_scene_patch(h->scene, &patch, NULL);
}

static void take(struct host *h, const struct fuzz_step *s)
{
    static uint8_t datagrams[16][16384];
    uint8_t *datagram = datagrams[h->datagrams % 16]; /* stay until applied */
    size_t used = 0;
    switch (s->what % STEPS) {
    case FEED:
        h->datagrams++;
        pel_cigi_feed(h->cigi, s->data, s->size);
        break;
    case PACKETS:
    case ADD:
        used = put_control(h, datagram, sizeof datagrams[0], fuzz_byte(s, 0));
        if (s->size > 1) {
            used += put_packets(datagram + used, sizeof datagrams[0] - used,
                                s->data + 1, s->size - 1);
        }
        h->datagrams++;
        if (s->what % STEPS == ADD) {
            pel_cigi_add(h->cigi, datagram, used);
        } else {
            pel_cigi_feed(h->cigi, datagram, used);
        }
        break;
    case WAIT:
        fuzz_wait(s);
        break;
    case FRAME:
        take_frame(h);
        break;
    case OPERATOR:
        operate(h, fuzz_byte(s, 0));
        break;
    default:
        h->frame += (uint32_t)((int8_t)fuzz_byte(s, 0) * 100);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    struct pel_cigi_options options = pel_cigi_default_options();
    struct host h = { .scene = fuzz_world() };
    double time_s = 0;
    options.listen = NULL;
    options.metrics = pel_metrics_create();
    options.hold = size > 0 && data[0] >= 128;
    if (pel_cigi_create(&options, h.scene, &h.cigi, NULL) != PEL_OK) {
        abort();
    }
    for (int i = 0; i < 64 && fuzz_next(&steps, &step); i++) {
        take(&h, &step);
        pel_cigi_settle(h.cigi);
        fuzz_look(h.scene, &time_s);
        struct pel_cigi_status status;
        pel_cigi_status(h.cigi, &status);
        fuzz_demand(pel_cigi_counters(h.cigi)->datagrams == h.datagrams);
        fuzz_demand(status.ig_frame == h.ig_frame);
    }
    free(pel_metrics_text(options.metrics, NULL));
    pel_cigi_destroy(h.cigi);
    pel_metrics_destroy(options.metrics);
    pel_scene_destroy(h.scene);
    return 0;
}
