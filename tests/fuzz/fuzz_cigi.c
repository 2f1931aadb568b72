/* Datagrams into the CIGI bridge and a real scene, and the frames that come
 * back. The first byte chooses: as they are, or the rest as packets behind a
 * sound IG Control of either byte order, to get past the head. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "bridges/cigi.h"
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Cascades take a sanitizer a second for each new wind. */
static void use_trochoids(struct pel_scene *scene)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    sea.has_synthesiser = true;
    sea.synthesiser = PELAGOS__SYNTHESISER__TROCHOIDS;
    state.sea = &sea;
    patch.state = &state;
    if (pel_scene_patch(scene, &patch, NULL)) {
        abort();
    }
}

static struct pel_cigi *open_bridge(void)
{
    struct pel_scene_options scene_options = { .wave_count = 20 };
    struct pel_cigi_options options = pel_cigi_default_options();
    struct pel_scene *scene;
    struct pel_cigi *cigi;
    pel_log_set_level(PEL_LOG_ERROR);
    options.listen = NULL;
    if (pel_scene_create(&scene_options, &scene, NULL) != PEL_OK ||
        pel_cigi_create(&options, scene, &cigi, NULL) != PEL_OK) {
        abort();
    }
    use_trochoids(scene);
    return cigi;
}

/* What the data says about order and timestamps, with the next frame. */
static size_t put_control(uint8_t *out, size_t room, uint8_t how)
{
    static uint32_t frame;
    struct pel_cigi_packet p = pel_cigi_packet_of(PEL_CIGI_KIND_IG_CONTROL);
    frame += 1 + (how >> 6);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAJOR, 3);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MINOR, how & 2 ? 2 : 3);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAGIC, 0x8000);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MODE, how & 32 ? 0 : 1);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_FRAME, frame);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_STAMPED, (how & 8) != 0);
    pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_TIMESTAMP, frame * 1667.0);
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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_cigi *cigi;
    static uint8_t datagram[16384];
    const uint8_t *answer;
    struct pel_cigi_reader reader;
    struct pel_cigi_packet p;
    if (!cigi) {
        cigi = open_bridge();
    }
    if (size == 0) {
        return 0;
    }
    if (data[0] & 1) {
        size_t used = put_control(datagram, sizeof datagram, data[0]);
        used += put_packets(datagram + used, sizeof datagram - used, data + 1,
                            size - 1);
        pel_cigi_feed(cigi, datagram, used);
    } else {
        pel_cigi_feed(cigi, data + 1, size - 1);
    }
    size_t got = pel_cigi_frame(cigi, &answer);
    if (pel_cigi_open(answer, got, PEL_CIGI_KIND_START_OF_FRAME, &reader) !=
        PEL_CIGI_GOOD) {
        abort(); /* what we send is sound, whatever we were sent */
    }
    while (pel_cigi_next(&reader, &p)) {
        if (p.kind == PEL_CIGI_KIND_COUNT ||
            pel_cigi_packets[p.kind].from_host) {
            abort();
        }
    }
    return 0;
}
