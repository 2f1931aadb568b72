#include "models/describe.h"

#include <stdio.h>
#include <string.h>

#include "fault.h"
#include "json.h"
#include "ranges.h"

#define SAME(ours, theirs)                                                     \
    _Static_assert((int)(ours) == (int)(theirs), #ours " as " #theirs)
#define PEL_MODEL_CLASS(id, text)                                              \
    SAME(PEL_MODEL_##id, PELAGOS__MODEL_CLASS__##id);
#include "models/classes.def"
SAME(PEL_AXIS_X, PELAGOS__MODEL_AXIS__X);
SAME(PEL_AXIS_MINUS_Z, PELAGOS__MODEL_AXIS__MINUS_Z);

void pel_model_description_init(struct pel_model_description *out)
{
    *out = (struct pel_model_description){ .bow = PEL_AXIS_NONE,
                                           .up = PEL_AXIS_NONE,
                                           .draught_m = NAN };
}

static void name_it(char out[PEL_MODEL_NAME], const char *name)
{
    snprintf(out, PEL_MODEL_NAME, "%s", name ? name : "");
}

static void take_light(const Pelagos__ModelLight *from,
                       struct pel_model_light *to)
{
    name_it(to->name, from->name);
    to->at = (struct pel_vec3){ from->forward, -from->right, from->up };
    to->range_m = (float)(1852 * from->range);
    to->from_rad = (float)(from->from * PEL_DEG);
    to->to_rad = (float)(from->to * PEL_DEG);
    for (int k = 0; k < 3; k++) {
        to->colour[k] = (float)(from->colour >> (16 - 8 * k) & 255) / 255.0f;
    }
}

static void take(const Pelagos__ModelDescription *from,
                 struct pel_model_description *to)
{
    to->class = (enum pel_model_class)from->class_;
    to->bow = from->has_bow ? (enum pel_axis)from->bow : PEL_AXIS_NONE;
    to->up = from->has_up ? (enum pel_axis)from->up : PEL_AXIS_NONE;
    to->scale = from->has_scale ? from->scale : 0;
    to->length_m = from->has_length ? from->length : 0;
    to->beam_m = from->has_beam ? from->beam : 0;
    to->height_m = from->has_height ? from->height : 0;
    to->draught_m = from->has_draught ? from->draught : NAN;
    for (size_t i = 0; i < from->n_eyes; i++) {
        const Pelagos__ModelPoint *e = from->eyes[i];
        struct pel_model_eye *eye = &to->eyes[to->eye_count++];
        name_it(eye->name, e->name);
        eye->at = (struct pel_vec3){ e->forward, -e->right, e->up };
    }
    for (size_t i = 0; i < from->n_lights; i++) {
        take_light(from->lights[i], &to->lights[to->light_count++]);
    }
}

static enum pel_err check(const Pelagos__ModelDescription *d,
                          struct pel_fault *fault)
{
    enum pel_err err = pel_message_check(&d->base, "", fault);
    if (!err && d->n_eyes > PEL_MODEL_MOST_EYES) {
        err = pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "eyes", NULL,
                               "may be 16 at most", fault);
    }
    if (!err && d->n_lights > PEL_MODEL_MOST_LIGHTS) {
        err = pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "lights", NULL,
                               "may be 64 at most", fault);
    }
    if (!err && d->has_bow && d->has_up && d->bow / 2 == d->up / 2) {
        err = pel_fault_refuse(PEL_ERR_CONFLICT, "bow", NULL,
                               "is along the axis that `up` is along; give "
                               "another",
                               fault);
    }
    return err;
}

enum pel_err pel_model_description_read(const char *text, size_t length,
                                        struct pel_model_description *out,
                                        struct pel_fault *fault)
{
    ProtobufCMessage *message = NULL;
    pel_model_description_init(out);
    enum pel_err err = pel_json_to_message(
        text, length, &pelagos__model_description__descriptor, &message, fault);
    if (!err) {
        const Pelagos__ModelDescription *d =
            (const Pelagos__ModelDescription *)message;
        err = check(d, fault);
        if (!err) {
            take(d, out);
        }
        protobuf_c_message_free_unpacked(message, NULL);
    }
    return err;
}
